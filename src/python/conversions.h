/// Conversions for all parts of the Python module: parameters by name, stamps, images, arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "ratslam/common/parameter_map.h"
#include "ratslam/common/state.h"
#include "ratslam/experience_map/experience_graph.h"
#include "ratslam/experience_map/map_pose.h"
#include "ratslam/system/map_store.h"

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

/// A copy of an image: (rows, columns) of uint8 or uint16, grey; or (rows, columns, 3) of uint8, BGR as in OpenCV.
/// Any strides.
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

py::bytes bytesOf(State& state, const std::map<std::string, std::string>& parameters);
State stateOf(const py::bytes& bytes, const std::map<std::string, std::string>& parameters);

/// The state of a model and its parameters, as bytes.
template <class Stage, class Params>
py::bytes save(const Stage& stage, const Params& params) {
  State state;
  stage.save(state.child("state"));
  return bytesOf(state, parameterTexts(params));
}

/// The state of a model with the same parameters.
/// @throws std::invalid_argument naming the first parameter that differs, std::runtime_error for bytes that are no state
template <class Params>
State stateFrom(const py::bytes& bytes, const Params& params) {
  return stateOf(bytes, parameterTexts(params));
}
}  // namespace ratslam::python
