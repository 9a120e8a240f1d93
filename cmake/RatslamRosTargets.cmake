# The ROS storey: one library, one small executable a node, integration tests, and what is installed.

file(GLOB_RECURSE ros_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/ratslam_ros/*.cpp)
add_library(ratslam_ros SHARED ${ros_sources})
add_dependencies(ratslam_ros ${PROJECT_NAME}_generate_messages_cpp ${catkin_EXPORTED_TARGETS})
target_include_directories(ratslam_ros SYSTEM PUBLIC ${CATKIN_DEVEL_PREFIX}/include ${catkin_INCLUDE_DIRS})
find_package(BZip2 REQUIRED)  # as rosbag unpacks
target_link_libraries(ratslam_ros PUBLIC ratslam ${catkin_LIBRARIES} PRIVATE ${BZIP2_LIBRARIES})
ratslam_warnings(ratslam_ros)

file(GLOB town_ros_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/town/ros/*.cpp)
add_library(town_ros STATIC ${town_ros_sources})
target_link_libraries(town_ros PUBLIC town ratslam_ros)
ratslam_warnings(town_ros)

# src/nodes/<name>_main.cpp becomes the executable ratslam_<name>.
file(GLOB node_mains CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/nodes/*_main.cpp)
set(node_targets)
foreach(source ${node_mains})
  get_filename_component(name ${source} NAME_WE)
  string(REGEX REPLACE "^(.*)_main$" "ratslam_\\1" target ${name})
  add_executable(${target} ${source})
  target_link_libraries(${target} PRIVATE ratslam_ros)
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${ratslam_node_directory})
  ratslam_warnings(${target})
  list(APPEND node_targets ${target})
endforeach()

add_library(ratslam_nodelets MODULE src/nodelets/nodelets.cpp)
target_link_libraries(ratslam_nodelets PRIVATE ratslam_ros)
ratslam_warnings(ratslam_nodelets)

# Programs need not be told where the libraries beside them lie, in the build folder or once installed.
set_target_properties(ratslam_ros ratslam_nodelets PROPERTIES INSTALL_RPATH "$ORIGIN")
set_target_properties(${node_targets} PROPERTIES INSTALL_RPATH "$ORIGIN/..")
install(TARGETS ratslam_ros ratslam_nodelets LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
install(TARGETS ${node_targets} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(DIRECTORY include/ratslam_ros DESTINATION ${CATKIN_GLOBAL_INCLUDE_DESTINATION})
install(DIRECTORY launch config docs DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(FILES LICENSE README.md nodelets.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
# The Python scripts, and beside them the package they share. No catkin_install_python: its relays in the devel space
# would give rosrun two programs of each name, and ours name their interpreter already.
file(GLOB candidates CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/scripts/*)
set(python_scripts)
foreach(file ${candidates})
  if(NOT IS_DIRECTORY ${file})
    file(STRINGS ${file} first_line LIMIT_COUNT 1)
    if(first_line MATCHES "python3$")
      list(APPEND python_scripts ${file})
    endif()
  endif()
endforeach()
# These and the tools are on PATH once the devel space is sourced: by links in the build folder, where rosrun does not look, as it would find
# each script twice.
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
foreach(file ${python_scripts})
  get_filename_component(name ${file} NAME)
  execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink ${file} ${PROJECT_BINARY_DIR}/bin/${name})
endforeach()
foreach(tool ratslam_run ratslam_map ratslam_places ratslam_town)
  execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink ${ratslam_node_directory}/${tool} ${PROJECT_BINARY_DIR}/bin/${tool})
endforeach()
catkin_add_env_hooks(50.ratslam_scripts SHELLS sh DIRECTORY ${PROJECT_SOURCE_DIR}/cmake)
install(PROGRAMS ${python_scripts} DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(DIRECTORY scripts/ratslam_tools DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION} PATTERN __pycache__ EXCLUDE)

if(RATSLAM_TESTS AND CATKIN_ENABLE_TESTING)
  find_package(rostest REQUIRED)
  file(GLOB rostests CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/integration/*.test)
  foreach(file ${rostests})
    add_rostest(${file} DEPENDENCIES ${node_targets})
  endforeach()
  # Tests run side by side, and these take minutes: whoever begins them last waits for one alone.
  foreach(name launches playback broken restarts services)
    set_tests_properties(_ctest_ratslam_ros_rostest_test_integration_${name}.test PROPERTIES COST 100)
  endforeach()
  if(CATKIN_DEVEL_PREFIX STREQUAL "${PROJECT_SOURCE_DIR}/devel")
    add_test(NAME devel_space COMMAND ${PROJECT_SOURCE_DIR}/test/integration/devel_space.sh ${PROJECT_SOURCE_DIR})
  endif()
  add_test(NAME two_machines COMMAND ${PROJECT_SOURCE_DIR}/test/integration/two_machines.sh
    ${PROJECT_SOURCE_DIR} ${CATKIN_DEVEL_PREFIX})
  set_tests_properties(two_machines PROPERTIES SKIP_RETURN_CODE 77)
  add_test(NAME install_space COMMAND ${PROJECT_SOURCE_DIR}/test/integration/install_space.sh
    ${PROJECT_BINARY_DIR} ${CMAKE_INSTALL_PREFIX})
endif()
