#include "ratslam/system/parameter_changes.h"

#include <algorithm>
#include <charconv>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/text_file.h"
#include "ratslam/system/pipeline.h"

namespace ratslam {
namespace {

const char kColumns[] = "after_ns,name,value";

/// Adds the change to the pipeline if its key is one of Params. @return whether it is
template <class Params>
bool changePart(const ParameterChange& change, const ParameterMap& parameters, Pipeline& pipeline) {
  Params params;
  if (changeableKeys(params).count(change.name) == 0) return false;
  parameters.read(params);
  pipeline.change(change.after, params);
  return true;
}

std::string joined(const std::set<std::string>& keys) {
  std::string text;
  for (const std::string& key : keys) text += (text.empty() ? "" : ", ") + key;
  return text;
}

}  // namespace

std::set<std::string> changeableKeys(const LocalViewParams&) {
  return {"vt_match_threshold", "vt_orientation_threshold"};
}

std::set<std::string> changeableKeys(const PoseCellParams&) {
  return {"pc_global_inhib", "pc_vt_inject_energy", "vt_active_decay", "pc_vt_restore",
          "exp_delta_pc_threshold"};
}

std::set<std::string> changeableKeys(const ExperienceMapParams&) {
  return {"exp_correction", "exp_loops", "exp_recall_kernel", "exp_goal_radius", "exp_goal_timeout"};
}

bool isChangeable(const std::string& key) {
  return changeableKeys(LocalViewParams()).count(key) + changeableKeys(PoseCellParams()).count(key) +
             changeableKeys(ExperienceMapParams()).count(key) >
         0;
}

std::vector<ParameterChange> readParameterChanges(const std::string& path) {
  std::vector<ParameterChange> changes;
  for (const TextLine& line : readLines(path)) {
    if (line.text == kColumns) continue;
    const std::string origin = path + ":" + std::to_string(line.number);
    const auto fail = [&] {
      throw std::runtime_error(origin + ": '" + shown(line.text) + "' is not of the form " + kColumns);
    };
    const std::size_t first = line.text.find(',');
    const std::size_t second = first == std::string::npos ? first : line.text.find(',', first + 1);
    if (second == std::string::npos) fail();
    ParameterChange change;
    const char* const end = line.text.data() + first;
    const auto [stop, error] = std::from_chars(line.text.data(), end, change.after);
    if (error != std::errc() || stop != end) fail();
    change.name = trimmed(line.text.substr(first + 1, second - first - 1));
    change.value = trimmed(line.text.substr(second + 1));
    change.origin = origin;
    changes.push_back(change);
  }
  return changes;
}

std::optional<std::string> changesNeverReached(const std::vector<ParameterChange>& changes, Stamp last) {
  const auto never = [last](const ParameterChange& change) { return change.after >= last; };
  const auto first = std::find_if(changes.begin(), changes.end(), never);
  if (first == changes.end()) return std::nullopt;
  std::ostringstream text;
  text << first->origin << ": " << first->name << " never changed, because after_ns=" << first->after
       << " is not before the last image, whose stamp is " << last << " ns ("
       << std::count_if(changes.begin(), changes.end(), never) << " of " << changes.size() << " changes)";
  return text.str();
}

void addChanges(std::vector<ParameterChange> changes, ParameterMap parameters, Pipeline& pipeline) {
  // Each change holds on top of all earlier ones, wherever they stand in the file.
  std::stable_sort(changes.begin(), changes.end(),
                   [](const ParameterChange& a, const ParameterChange& b) { return a.after < b.after; });
  for (const ParameterChange& change : changes) {
    parameters.setFromAssignment(change.name + "=" + change.value, change.origin);
    try {
      if (changePart<LocalViewParams>(change, parameters, pipeline) ||
          changePart<PoseCellParams>(change, parameters, pipeline) ||
          changePart<ExperienceMapParams>(change, parameters, pipeline)) {
        continue;
      }
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(change.origin + ": " + error.what());
    }
    throw std::invalid_argument(change.origin + ": " + shown(change.name) +
                                ": it cannot change in the middle of a drive; what can are " +
                                joined(changeableKeys(LocalViewParams())) + ", " +
                                joined(changeableKeys(PoseCellParams())) + ", " +
                                joined(changeableKeys(ExperienceMapParams())));
  }
}

}  // namespace ratslam
