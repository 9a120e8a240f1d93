/// The Python module ratslam._core: the models of the core, their parameters by the names of docs/parameters.md.
#include "module.h"

#include "ratslam/version.h"

PYBIND11_MODULE(_core, module) {
  module.doc() = "Local view cells, pose cells, experience map and the whole pipeline of ratslam_ros.";
  module.attr("__version__") = ratslam::version();
  ratslam::python::bindPoseCells(module);
  ratslam::python::bindLocalView(module);
  ratslam::python::bindExperienceMap(module);
  ratslam::python::bindPipeline(module);
}
