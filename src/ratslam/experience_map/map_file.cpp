#include "ratslam/experience_map/map_file.h"

#include <cmath>
#include <istream>
#include <limits>
#include <locale>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace ratslam {
namespace {

constexpr const char* kFormat = "format: ratslam_experience_map 1";

/// Parses one `- {key: value, ...}` line from left to right.
class Record {
 public:
  Record(const std::string& line, std::size_t number) : rest_(line), number_(number) { expect("- {"); }

  double number(const std::string& key) {
    const std::string text = value(key);
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    double parsed = 0.0;
    if (!(in >> parsed) || in.peek() != std::istringstream::traits_type::eof() || !std::isfinite(parsed)) {
      fail(key + ": " + text + " is not a finite number");
    }
    return parsed;
  }

  std::uint32_t id(const std::string& key) {
    const double parsed = number(key);
    if (parsed < 0.0 || parsed >= static_cast<double>(kNoLink) || parsed != std::floor(parsed)) {
      fail(key + ": it must be a whole number from 0");
    }
    return static_cast<std::uint32_t>(parsed);
  }

  bool flag(const std::string& key) {
    const std::string text = value(key);
    if (text != "true" && text != "false") fail(key + ": it must be true or false");
    return text == "true";
  }

  void end() {
    if (!rest_.empty()) fail("unexpected \"" + rest_ + "\"");
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error("map file, line " + std::to_string(number_) + ": " + what);
  }

 private:
  void expect(const std::string& text) {
    if (rest_.compare(0, text.size(), text) != 0) fail("expected \"" + text + "\"");
    rest_.erase(0, text.size());
  }

  std::string value(const std::string& key) {
    expect(key + ": ");
    const std::size_t end = rest_.find_first_of(",}");
    if (end == std::string::npos) fail(key + ": the record is cut off");
    std::string text = rest_.substr(0, end);
    rest_.erase(0, rest_.compare(end, 2, ", ") == 0 ? end + 2 : end + 1);
    return text;
  }

  std::string rest_;
  std::size_t number_;
};

Experience readExperience(Record record, std::size_t expected_id) {
  Experience experience;
  if (record.id("id") != expected_id) record.fail("experiences must be numbered from 0");
  experience.pose.x = record.number("x");
  experience.pose.y = record.number("y");
  experience.pose.z = record.number("z");
  experience.pose.yaw = record.number("yaw");
  experience.pose.log_scale = record.number("log_scale");
  record.end();
  return experience;
}

Link readLink(Record record, std::size_t expected_id, std::size_t experiences) {
  Link link;
  if (record.id("id") != expected_id) record.fail("links must be numbered from 0");
  link.from = record.id("from");
  link.to = record.id("to");
  link.distance = record.number("distance");
  link.heading_rad = record.number("heading_rad");
  link.facing_rad = record.number("facing_rad");
  link.rise = record.number("rise");
  link.duration_s = record.number("duration_s");
  link.recall = record.flag("recall");
  record.end();
  if (link.from >= experiences || link.to >= experiences || link.from == link.to) {
    record.fail("the link must join two of the " + std::to_string(experiences) + " experiences");
  }
  if (link.duration_s < 0.0) record.fail("duration_s: it must not be negative");
  return link;
}

}  // namespace

void writeMap(std::ostream& out, const ExperienceGraph& graph) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  text << kFormat << "\nexperiences:\n";
  for (std::size_t id = 0; id < graph.experiences().size(); ++id) {
    const MapPose& pose = graph.experiences()[id].pose;
    text << "- {id: " << id << ", x: " << pose.x << ", y: " << pose.y << ", z: " << pose.z
         << ", yaw: " << pose.yaw << ", log_scale: " << pose.log_scale << "}\n";
  }
  text << "links:\n";
  for (std::size_t id = 0; id < graph.links().size(); ++id) {
    const Link& link = graph.links()[id];
    text << "- {id: " << id << ", from: " << link.from << ", to: " << link.to
         << ", distance: " << link.distance << ", heading_rad: " << link.heading_rad
         << ", facing_rad: " << link.facing_rad << ", rise: " << link.rise
         << ", duration_s: " << link.duration_s << ", recall: " << (link.recall ? "true" : "false") << "}\n";
  }
  out << text.str();
}

ExperienceGraph readMap(std::istream& in) {
  ExperienceGraph graph;
  std::string line;
  std::size_t number = 0;
  const auto next = [&] { return ++number, static_cast<bool>(std::getline(in, line)); };
  const auto requireLine = [&](const std::string& wanted) {
    if (line != wanted) {
      throw std::runtime_error("map file, line " + std::to_string(number) + ": expected \"" + wanted + "\"");
    }
  };
  line.clear();
  next();
  requireLine(kFormat);
  line.clear();
  next();
  requireLine("experiences:");
  line.clear();
  while (next() && line != "links:") {
    graph.addExperience(readExperience(Record(line, number), graph.experiences().size()).pose);
  }
  requireLine("links:");
  while (next()) {
    graph.addLink(readLink(Record(line, number), graph.links().size(), graph.experiences().size()));
  }
  return graph;
}

}  // namespace ratslam
