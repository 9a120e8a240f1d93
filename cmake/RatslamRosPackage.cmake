# The package as catkin sees it: messages, what it exports, where devel and install files go.
# Comes before all targets, because catkin decides where they are put.

# rosrun leaves out whatever lies under <package>/build. Built there, the devel space therefore goes beside it, where a
# workspace would have it; build/devel leads to it.
if(NOT CATKIN_DEVEL_PREFIX AND PROJECT_BINARY_DIR STREQUAL "${PROJECT_SOURCE_DIR}/build")
  set(CATKIN_DEVEL_PREFIX ${PROJECT_SOURCE_DIR}/devel)
  set(former_devel_space ${PROJECT_BINARY_DIR}/devel)
  if(IS_DIRECTORY ${former_devel_space} AND NOT IS_SYMLINK ${former_devel_space})
    file(REMOVE_RECURSE ${former_devel_space})
  endif()
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR})
  execute_process(COMMAND ${CMAKE_COMMAND} -E create_symlink ../devel ${former_devel_space})
endif()

# catkin takes down at configure time which of its folders there are, and hands tests only those: the messages' Python
# folder must be there before the first build has filled it, or the first run of the tests does not find them.
if(CATKIN_DEVEL_PREFIX)
  file(MAKE_DIRECTORY ${CATKIN_DEVEL_PREFIX}/lib/python3/dist-packages)
else()
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/devel/lib/python3/dist-packages)
endif()

set(ratslam_ros_dependencies
  cv_bridge diagnostic_msgs dynamic_reconfigure geometry_msgs nav_msgs nodelet pluginlib rosbag_storage roscpp roslz4 sensor_msgs std_msgs std_srvs
  tf2 tf2_msgs tf2_ros visualization_msgs)
find_package(diagnostic_updater QUIET)  # not in Ubuntu 20.04's own archive
if(diagnostic_updater_FOUND)
  list(APPEND ratslam_ros_dependencies diagnostic_updater)
endif()
find_package(catkin REQUIRED COMPONENTS message_generation ${ratslam_ros_dependencies})

add_message_files(FILES
  OdometryQuality.msg
  ParameterChange.msg
  PoseCellState.msg
  RecallGeometry.msg
  TopologicalAction.msg
  TopologicalEdge.msg
  TopologicalMap.msg
  TopologicalNode.msg
  ViewTemplate.msg)
add_service_files(FILES MapPath.srv PartCommand.srv)
generate_messages(DEPENDENCIES std_msgs geometry_msgs)

catkin_package(
  INCLUDE_DIRS include
  LIBRARIES ratslam_ros ratslam
  CATKIN_DEPENDS message_runtime ${ratslam_ros_dependencies}
  DEPENDS EIGEN3 OpenCV)

# rosrun finds the nodes in catkin's folder; test programs stay in the build folder.
set(ratslam_node_directory ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
