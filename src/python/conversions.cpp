#include "conversions.h"

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace ratslam::python {
namespace {

std::string textOf(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  // repr keeps all digits; that of numpy's own numbers has letters around them.
  if (py::isinstance<py::float_>(value))
    return py::repr(py::float_(value.cast<double>())).cast<std::string>();
  return py::str(value).cast<std::string>();
}

std::string shapeOf(const py::array& array) {
  std::string text;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    text += (i == 0 ? "" : " x ") + std::to_string(array.shape(i));
  }
  return text + " of " + py::str(array.dtype()).cast<std::string>();
}

}  // namespace

ParameterMap parametersOf(const py::kwargs& keywords) {
  ParameterMap map;
  for (const auto& [key, value] : keywords) {
    ParameterValue parameter;
    parameter.origin = "the call";
    parameter.is_list = py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value) ||
                        (py::isinstance<py::array>(value) && py::array::ensure(value).ndim() == 1);
    if (parameter.is_list) {
      for (const py::handle& element : value) parameter.elements.push_back(textOf(element));
    } else {
      parameter.text = textOf(value);
    }
    map.set(key.cast<std::string>(), std::move(parameter));
  }
  return map;
}

Stamp stampFrom(const py::object& stamp) {
  constexpr double kNanoseconds = 1e9;
  constexpr double kLatest_s = 9e9;
  const auto number = py::module::import("numbers");
  if (py::isinstance(stamp, number.attr("Integral"))) {
    int beyond = 0;
    const Stamp nanoseconds = PyLong_AsLongLongAndOverflow(py::int_(stamp).ptr(), &beyond);
    if (beyond == 0 && std::abs(static_cast<double>(nanoseconds)) <= kLatest_s * kNanoseconds)
      return nanoseconds;
  }
  if (py::isinstance(stamp, number.attr("Real"))) {
    const double seconds = py::float_(stamp).cast<double>();
    if (std::abs(seconds) <= kLatest_s) return static_cast<Stamp>(std::llround(seconds * kNanoseconds));
  }
  throw std::invalid_argument("stamp: value " + py::str(stamp).cast<std::string>() +
                              " is not allowed: an int counts nanoseconds, a float seconds, up to 9e9 s");
}

cv::Mat imageFrom(const py::array& array) {
  const bool bytes = py::isinstance<py::array_t<std::uint8_t>>(array);
  const bool words = py::isinstance<py::array_t<std::uint16_t>>(array);
  const bool grey = array.ndim() == 2;
  const bool colour = array.ndim() == 3 && array.shape(2) == 3 && bytes;
  if (!((bytes || words) && (grey || colour)) || array.size() == 0) {
    throw std::invalid_argument(
        "image: an array of " + shapeOf(array) +
        " is not allowed: rows x columns of uint8 or uint16, or rows x columns x 3 of uint8");
  }
  const int type = words ? CV_16UC1 : grey ? CV_8UC1 : CV_8UC3;
  const py::array whole = py::array::ensure(array, py::array::c_style);
  if (!whole) throw std::bad_alloc();
  const cv::Mat image(static_cast<int>(whole.shape(0)), static_cast<int>(whole.shape(1)), type,
                      const_cast<void*>(whole.data()));
  return image.clone();  // the models keep it, and the caller's array may be freed or filled anew
}

py::array_t<std::uint8_t> arrayFrom(const cv::Mat& image) {
  py::array_t<std::uint8_t> array({image.rows, image.cols});
  for (int row = 0; row < image.rows; ++row) {
    std::memcpy(array.mutable_data(row, 0), image.ptr(row), static_cast<std::size_t>(image.cols));
  }
  return array;
}

py::array_t<double> arrayFrom(const std::vector<StampedPose>& trajectory) {
  py::array_t<double> array({static_cast<py::ssize_t>(trajectory.size()), static_cast<py::ssize_t>(6)});
  double* value = array.mutable_data();
  for (const StampedPose& stamped : trajectory) {
    const MapPose& pose = stamped.pose;
    for (const double number :
         {secondsBetween(0, stamped.stamp), pose.x, pose.y, pose.z, pose.yaw, pose.log_scale}) {
      *value++ = number;
    }
  }
  return array;
}

py::bytes bytesOf(State& state, const std::map<std::string, std::string>& parameters) {
  for (const auto& [key, text] : parameters)
    state.child("parameters").set(key, std::vector<std::uint8_t>(text.begin(), text.end()));
  const std::vector<std::uint8_t> bytes = state.toBytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

State stateOf(const py::bytes& bytes, const std::map<std::string, std::string>& parameters) {
  const std::string text = bytes;
  const State state = State::fromBytes({text.begin(), text.end()});
  for (const auto& [key, now] : parameters) {
    std::vector<std::uint8_t> saved;
    state.child("parameters").get(key, saved);
    const std::string then(saved.begin(), saved.end());
    if (then != now) {
      throw std::invalid_argument("state: it was saved with " + key + " = " + then + ", but it is " + now +
                                  " here");
    }
  }
  return state.child("state");
}

}  // namespace ratslam::python
