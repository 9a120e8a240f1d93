#include "ratslam/camera/calibration_file.h"

#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "ratslam/common/parameter_map.h"
#include "ratslam/common/text_file.h"
#include "ratslam/common/yaml_check.h"

namespace ratslam {
namespace {

struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::array<double, 5> distortion{};

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("image_width", width, Bounds{1, 65535}, "[px]");
    visit("image_height", height, Bounds{1, 65535}, "[px]");
    visit("fx", fx, Bounds{1e-3, 1e6}, "focal length along x [px]");
    visit("fy", fy, Bounds{1e-3, 1e6}, "focal length along y [px]");
    visit("cx", cx, Bounds{-1e6, 1e6}, "principal point [px]");
    visit("cy", cy, Bounds{-1e6, 1e6}, "principal point [px]");
    constexpr std::array<const char*, 5> kKeys{"k1", "k2", "p1", "p2", "k3"};
    for (std::size_t i = 0; i < kKeys.size(); ++i) visit(kKeys[i], distortion[i], Bounds{}, "distortion");
  }
  void validate() const { checkBounds(*this); }
};

CameraModel readOwnForm(const std::string& path) {
  const ParameterMap map = ParameterMap::fromYaml(path);
  map.rejectUnknown(keysOf<Intrinsics>());
  for (const char* key : {"image_width", "image_height", "fx", "fy", "cx", "cy"}) {
    if (!map.has(key)) throw std::runtime_error(path + ": no " + key + ", without which there is no camera");
  }
  Intrinsics camera;
  map.read(camera);
  return makeCamera(
      {camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, LensModel::kNone, {}},
      "plumb_bob", {camera.distortion.begin(), camera.distortion.end()});
}

double numberIn(const YAML::Node& node, const std::string& key) {
  try {
    const auto number = node.as<double>();
    if (std::isfinite(number)) return number;
  } catch (const YAML::Exception&) {  // reported below
  }
  throw std::invalid_argument(key + ": '" + (node.IsScalar() ? shown(node.Scalar()) : "a list") +
                              "' is not a finite number");
}

/// The numbers of `key: {rows, cols, data: [...]}`.
std::vector<double> dataIn(const YAML::Node& root, const std::string& key) {
  const YAML::Node entry = root[key];
  const YAML::Node data = entry.IsMap() ? entry["data"] : entry;
  if (!data.IsDefined() || !data.IsSequence())
    throw std::invalid_argument(key + ": 'data: [...]' is expected");
  std::vector<double> numbers;
  for (const auto& element : data) numbers.push_back(numberIn(element, key));
  return numbers;
}

int sizeIn(const YAML::Node& root, const std::string& key) {
  if (!root[key].IsDefined()) throw std::invalid_argument("no " + key);
  const double number = numberIn(root[key], key);
  if (number != std::floor(number) || number < 1.0 || number > 65535.0) {
    throwBadValue(key, number, "it must be a whole number within [1, 65535]");
  }
  return static_cast<int>(number);
}

CameraModel readRosForm(const YAML::Node& root) {
  const std::vector<double> k = dataIn(root, "camera_matrix");
  if (k.size() != 9) throwBadValue("camera_matrix", k.size(), "9 numbers are expected");
  const std::string model =
      root["distortion_model"].IsDefined() ? root["distortion_model"].as<std::string>() : "plumb_bob";
  const bool bends = root["distortion_coefficients"].IsDefined();
  CameraModel camera =
      makeCamera({sizeIn(root, "image_width"),
                  sizeIn(root, "image_height"),
                  k[0],
                  k[4],
                  k[2],
                  k[5],
                  LensModel::kNone,
                  {}},
                 model, bends ? dataIn(root, "distortion_coefficients") : std::vector<double>{});
  requireNoSkew("camera_matrix[1]", k[1], camera);
  return camera;
}

/// The file's root if it has a matrix, as ROS and OpenCV write it; else none.
std::optional<YAML::Node> rootOfRosForm(const std::string& path) {
  std::string text = readText(path);
  const std::string head = "%YAML:";  // OpenCV's directive, which is not valid YAML
  if (text.compare(0, head.size(), head) == 0) text.insert(0, "#");
  try {
    requireOneYamlDocument(text);
    const YAML::Node root = YAML::Load(text);
    if (root.IsMap() && root["camera_matrix"].IsDefined()) return root;
  } catch (const YAML::Exception&) {  // the reader of the other form reports it with its line
  }
  return std::nullopt;
}

}  // namespace

CameraModel readCalibration(const std::string& path) {
  try {
    const auto root = rootOfRosForm(path);
    return root ? readRosForm(*root) : readOwnForm(path);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": " + error.what());
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ": " + error.msg);
  }
}

}  // namespace ratslam
