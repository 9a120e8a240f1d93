/// Changes of thresholds and gains during a drive, as by dynamic_reconfigure.
///
/// A change has a stamp and holds for every later event. It is part of the input: a run can be repeated from its
/// recorded changes. Parameters that determine sizes or the description of views cannot change.
#pragma once

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ratslam/common/parameter_map.h"
#include "ratslam/common/stamp.h"
#include "ratslam/common/state.h"
#include "ratslam/experience_map/params.h"
#include "ratslam/local_view/local_view_params.h"
#include "ratslam/pose_cells/params.h"

namespace ratslam {

class Pipeline;

struct ParameterChange {
  Stamp after = 0;
  std::string name;
  std::string value;
  std::string origin;  ///< file and line
};

/// Keys that may change while a part runs.
std::set<std::string> changeableKeys(const LocalViewParams&);
std::set<std::string> changeableKeys(const PoseCellParams&);
std::set<std::string> changeableKeys(const ExperienceMapParams&);
/// Whether the key is one of them.
bool isChangeable(const std::string& key);

/// Changes of the parameters of a stage's model that wait for their stamps.
template <class Params>
class TimedChanges {
 public:
  /// Of several changes that are due, the last one added holds.
  void add(Stamp after, const Params& params) { waiting_.emplace_back(after, params); }

  /// The stamp after which a change made now holds: that of the last event. The stamp of one that waits does not do,
  /// because that event may be dropped, and time may then go on far before it. @param passed  if there was no event
  Stamp latest(Stamp passed) const { return last_.value_or(passed); }

  /// To be called before `part` processes an event of this stamp. Replaces the part by one with the new parameters
  /// and the same state.
  template <class Part>
  void applyBefore(Stamp event, Part& part) {
    // If time has gone back, what was to hold after the old time's last event holds from the beginning of the new one.
    const std::optional<Stamp> last = std::exchange(last_, event);
    const bool back = last && event < *last;
    const auto due = std::stable_partition(waiting_.begin(), waiting_.end(), [&](const auto& change) {
      return change.first >= event && !(back && change.first <= *last);
    });
    if (due == waiting_.end()) return;
    State known;
    part.save(known);
    Part changed(waiting_.back().second);
    changed.load(known);
    changed.setLearning(part.learning());
    part = std::move(changed);
    waiting_.erase(due, waiting_.end());
  }

 private:
  std::vector<std::pair<Stamp, Params>> waiting_;
  std::optional<Stamp> last_;  ///< the last event
};

/// Reads changes from a CSV file with the columns after_ns,name,value, as ratslam_em writes it.
/// @throws std::runtime_error naming file, line and reason
std::vector<ParameterChange> readParameterChanges(const std::string& path);

/// Names the first change whose stamp the drive did not reach, and counts such changes; none if all were reached.
/// @param last  stamp of the last image
std::optional<std::string> changesNeverReached(const std::vector<ParameterChange>& changes, Stamp last);

/// Adds changes to a pipeline, in any order. To be called before the first event. @param parameters  at the beginning
/// @throws std::invalid_argument naming a key that may not change, or a bad value
void addChanges(std::vector<ParameterChange> changes, ParameterMap parameters, Pipeline& pipeline);

}  // namespace ratslam
