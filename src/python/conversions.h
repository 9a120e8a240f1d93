/// Conversions for all parts of the Python module: parameters by name, stamps, images, arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "ratslam/common/parameter_map.h"
#include "ratslam/common/state.h"
#include "ratslam/experience_map/experience_graph.h"
#include "ratslam/experience_map/map_pose.h"

namespace ratslam::python {

namespace py = pybind11;

/// Keyword arguments as the parameters of a model.
/// @throws std::invalid_argument naming an unknown key, or key, value and requirement
ParameterMap parametersOf(const py::kwargs& keywords);

template <class Params>
Params read(const py::kwargs& keywords) {
  const ParameterMap map = parametersOf(keywords);
  map.rejectUnknown(keysOf<Params>());
  Params params;
  map.read(params);
  return params;
}

/// All parameters of a model, by name.
template <class Params>
py::dict dictionaryOf(Params params) {
  py::dict dictionary;
  params.visitFields([&dictionary](const std::string& key, const auto& value, const Bounds&, const char*) {
    dictionary[key.c_str()] = py::cast(value);
  });
  return dictionary;
}

/// An int counts nanoseconds, a float seconds. @throws std::invalid_argument for anything else
Stamp stampFrom(const py::object& stamp);

/// An image without a copy: (rows, columns) of uint8 or uint16, grey; or (rows, columns, 3) of uint8, BGR as in OpenCV.
/// Any strides; an array that is not contiguous is copied.
/// @throws std::invalid_argument naming shape and type of any other array
cv::Mat imageFrom(const py::array& array);

/// A copy, shape (rows, columns).
py::array_t<std::uint8_t> arrayFrom(const cv::Mat& image);

/// Columns stamp [s], x, y, z [m], yaw [rad], log-scale: shape (poses, 6).
py::array_t<double> arrayFrom(const std::vector<StampedPose>& trajectory);

/// (experiences, 5): x, y, z [m], yaw [rad], log-scale.
py::array_t<double> experiencesOf(const ExperienceGraph& graph);
/// ends (links, 2), recall (links,), measured (links, 5).
py::dict linksOf(const ExperienceGraph& graph);

template <class Stage>
py::bytes save(const Stage& stage) {
  State state;
  stage.save(state);
  const std::vector<std::uint8_t> bytes = state.toBytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

State stateFrom(const py::bytes& bytes);

}  // namespace ratslam::python
