/// The parts of the Python module, one function each.
#pragma once

#include <pybind11/pybind11.h>

namespace ratslam::python {

void bindPoseCells(pybind11::module& module);
void bindLocalView(pybind11::module& module);
void bindExperienceMap(pybind11::module& module);
void bindPipeline(pybind11::module& module);

}  // namespace ratslam::python
