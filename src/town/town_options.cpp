#include "town/town_options.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <type_traits>

#include "ratslam/common/text_file.h"

namespace ratslam {
namespace {

template <class Number>
Number parseNumber(const std::string& key, const std::string& text) {
  std::istringstream in(text);
  Number value{};
  if (!(in >> value) || !in.eof())
    throwBadValue(key, text,
                  std::is_integral_v<Number> ? "it must be a whole number" : "it must be a number");
  return value;
}

std::vector<double> parseList(const std::string& key, const std::string& text) {
  std::vector<double> values;
  std::istringstream in(text);
  for (std::string item; std::getline(in, item, ',');) values.push_back(parseNumber<double>(key, item));
  return values;
}

template <class T>
void parseValue(const std::string& key, const std::string& text, T& value) {
  if constexpr (std::is_same_v<T, std::string>) {
    value = text;
  } else if constexpr (std::is_same_v<T, bool>) {
    if (text != "true" && text != "false") throwBadValue(key, text, "it must be true or false");
    value = text == "true";
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    value = parseList(key, text);
  } else {
    value = parseNumber<T>(key, text);
  }
}

template <class T>
std::string printValue(const T& value) {
  std::ostringstream out;
  if constexpr (std::is_same_v<T, std::vector<double>>) {
    out.precision(10);
    for (std::size_t i = 0; i < value.size(); ++i) out << (i == 0 ? "" : ",") << value[i];
  } else {
    out.precision(12);
    out << std::boolalpha << value;
  }
  return out.str();
}

void checkCount(const char* key, const std::vector<double>& values, std::size_t count) {
  if (!values.empty() && values.size() != count)
    throwBadValue(key, printValue(values),
                  "it must be " + std::to_string(count) + " numbers with commas between");
}

}  // namespace

void TownOptions::validate() const {
  checkBounds(*this);
  if (out.empty()) throwBadValue("out", out, "it must say where to write");
  if (layout != "kitti" && layout != "recorder")
    throwBadValue("layout", layout, "it must be kitti or recorder");
  if (frames == 0) throwBadValue("frames", frames, "it must be positive, or -1 for all");
  if (!times.empty() && trajectory.empty()) throwBadValue("times", times, "it needs a trajectory");
  checkCount("wheel_noise", wheel_noise, 3);
  if (std::any_of(wheel_noise.begin() + (wheel_noise.empty() ? 0 : 1), wheel_noise.end(),
                  [](double sigma) { return !(sigma >= 0.0); }))
    throwBadValue("wheel_noise", printValue(wheel_noise), "standard deviations must not be negative");
  checkCount("wheel_slip", wheel_slip, 2);
  if (std::any_of(wheel_slip.begin(), wheel_slip.end(), [](double sigma) { return !(sigma >= 0.0); }))
    throwBadValue("wheel_slip", printValue(wheel_slip), "standard deviations must not be negative");
  if (wheel_covariance && !wheelOdometry())
    throwBadValue("wheel_covariance", "true", "it needs wheel_noise or wheel_slip");
  if (origin.size() != 3)
    throwBadValue("origin", printValue(origin), "it must be 3 numbers with commas between");
  if (!(std::abs(origin[0]) < 89.0 && std::abs(origin[1]) <= 180.0 && std::abs(origin[2]) < 1e5))
    throwBadValue("origin", printValue(origin), "latitude must lie within 89, longitude within 180 degrees");
  camera().validate();
}

bool TownOptions::writesBag() const { return endsWith(out, ".bag"); }

void TownOptions::expectEffects() const {
  if (writesBag()) {
    if (layout != "kitti") throwBadValue("layout", layout, "--out names a bag; folders have layouts");
    return;
  }
  if (layout == "recorder") {
    const std::string refusal = "the recorder layout has no wheel odometry; the kitti layout and bags have";
    if (!wheel_noise.empty()) throwBadValue("wheel_noise", printValue(wheel_noise), refusal);
    if (!wheel_slip.empty()) throwBadValue("wheel_slip", printValue(wheel_slip), refusal);
    return;
  }
  const std::string others = "; the recorder layout and bags have";
  const TownOptions defaults;
  if (std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; }))
    throwBadValue("distortion", printValue(distortion),
                  "the kitti layout has no coefficients of a lens" + others);
  if (gps_noise != defaults.gps_noise)
    throwBadValue("gps_noise", gps_noise, "the kitti layout has no GPS" + others);
  if (origin != defaults.origin)
    throwBadValue("origin", printValue(origin), "the kitti layout has no GPS" + others);
  if (start != defaults.start)
    throwBadValue("start", start, "the kitti layout has no absolute stamps" + others);
}

TownCamera TownOptions::camera() const {
  std::istringstream in(size);
  int width = 0;
  int height = 0;
  char x = ' ';
  if (!(in >> width >> x >> height) || x != 'x' || in.peek() != std::istringstream::traits_type::eof() ||
      width < 1 || height < 1)
    throwBadValue("size", size, "it must be WIDTHxHEIGHT in pixels, such as 1241x376");
  TownCamera result = TownCamera::kittiLike(width, height);
  checkCount("calibration", calibration, 4);
  if (!calibration.empty()) {
    result.fx = calibration[0];
    result.fy = calibration[1];
    result.cx = calibration[2];
    result.cy = calibration[3];
  }
  checkCount("distortion", distortion, result.distortion.size());
  std::copy(distortion.begin(), distortion.end(), result.distortion.begin());
  return result;
}

TownOptions parseTownOptions(const std::vector<std::string>& arguments) {
  TownOptions options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument.rfind("--", 0) != 0) throwBadValue("option", argument, "options start with --");
    const std::size_t equals = argument.find('=');
    std::string name = argument.substr(2, equals == std::string::npos ? equals : equals - 2);
    std::replace(name.begin(), name.end(), '-', '_');
    std::optional<std::string> text;
    if (equals != std::string::npos) text = argument.substr(equals + 1);
    bool known = false;
    options.visitFields([&](const std::string& key, auto& value, const Bounds&, const char*) {
      if (key != name) return;
      known = true;
      if (!text && std::is_same_v<std::decay_t<decltype(value)>, bool>) text = "true";
      if (!text && i + 1 < arguments.size()) text = arguments[++i];
      if (!text) throwBadValue(key, "", "a value must follow");
      parseValue(key, *text, value);
    });
    if (!known) throwBadValue("option", argument, "there is no such option; --help lists them");
  }
  options.validate();
  return options;
}

std::string townUsage() {
  std::ostringstream help;
  help << "ratslam_town: renders a synthetic drive through a town, with exact truth.\n\n"
       << "  ratslam_town --out out/town\n"
       << "  ratslam_town --out out/town00 --trajectory 00.txt --times times_00.txt --jpeg-quality 95\n"
       << "  ratslam_town --out out/phone --layout recorder --size 1280x960 --distortion=-0.2,0.05,0,0,0 "
          "--gps-noise 3\n\n";
  TownOptions defaults;
  defaults.visitFields([&](std::string key, auto& value, const Bounds&, const char* meaning) {
    std::replace(key.begin(), key.end(), '_', '-');
    std::string text = printValue(value);
    help << "  --" << key << std::string(key.size() < 14 ? 14 - key.size() : 1, ' ') << meaning;
    if (!text.empty() && !std::is_same_v<std::decay_t<decltype(value)>, bool>) help << " [" << text << "]";
    help << "\n";
  });
  return help.str();
}

}  // namespace ratslam
