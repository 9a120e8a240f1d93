# find_package(ratslam) gives the target ratslam::ratslam, the core without ROS.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.3 NO_MODULE)
find_dependency(OpenCV 4 COMPONENTS core imgproc imgcodecs features2d calib3d video videoio)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/ratslamTargets.cmake)
