# The Python module `ratslam`: the core through pybind11, and beside it the tools of scripts/ratslam_tools.
# Where pybind11 is missing, everything else is built without it.

# The Python whose programs are called is the one that loads the module; its headers come before pybind11 looks for them.
find_package(Python3 COMPONENTS Interpreter Development QUIET)
find_package(pybind11 2.4 QUIET)
if(NOT pybind11_FOUND OR NOT Python3_Development_FOUND)
  message(STATUS "pybind11 or Python's headers are not installed: the Python module ratslam is left out")
  return()
endif()

# Where Python finds packages after `. devel/setup.bash`, and once installed.
if(RATSLAM_ROS)
  set(python_folder ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_PYTHON_DESTINATION})
  set(python_destination ${CATKIN_GLOBAL_PYTHON_DESTINATION})
else()
  set(python_folder ${PROJECT_BINARY_DIR}/python)
  set(python_destination lib/python3/dist-packages)
endif()

file(GLOB python_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/python/*.cpp)
pybind11_add_module(ratslam_python MODULE NO_EXTRAS ${python_sources})
target_link_libraries(ratslam_python PRIVATE ratslam)
ratslam_warnings(ratslam_python)
set_target_properties(ratslam_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY ${python_folder}/ratslam
  INSTALL_RPATH "$ORIGIN/../../..")
file(MAKE_DIRECTORY ${python_folder}/ratslam)
execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink
  ${PROJECT_SOURCE_DIR}/python/ratslam/__init__.py ${python_folder}/ratslam/__init__.py)
execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink
  ${PROJECT_SOURCE_DIR}/scripts/ratslam_tools ${python_folder}/ratslam_tools)

install(TARGETS ratslam_python LIBRARY DESTINATION ${python_destination}/ratslam)
install(FILES python/ratslam/__init__.py DESTINATION ${python_destination}/ratslam)
install(DIRECTORY scripts/ratslam_tools DESTINATION ${python_destination} PATTERN __pycache__ EXCLUDE)
