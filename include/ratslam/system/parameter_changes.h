/// Thresholds and gains that change in the middle of a drive, as dynamic_reconfigure has it.
///
/// A change holds for every event whose stamp is later than the change's: with its stamp it is part of the input, and
/// whoever knows the changes can repeat the run. Nothing that sizes depend on may change, nor what describes a view.
#pragma once

#include <algorithm>
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
};

/// What may change while a part runs.
std::set<std::string> changeableKeys(const LocalViewParams&);
std::set<std::string> changeableKeys(const PoseCellParams&);
std::set<std::string> changeableKeys(const ExperienceMapParams&);
/// Whether the key is one of them.
bool isChangeable(const std::string& key);

/// A model of a stage, and the parameters that it gets as its events reach their stamps.
template <class Params>
class TimedChanges {
 public:
  /// The newest call wins where several have come due.
  void add(Stamp after, const Params& params) { waiting_.emplace_back(after, params); }

  /// To be called before `part` sees an event of this stamp. The part becomes one of the new parameters that knows all
  /// that it knew.
  template <class Part>
  void applyBefore(Stamp event, Part& part) {
    const auto due = std::stable_partition(waiting_.begin(), waiting_.end(),
                                           [event](const auto& change) { return change.first >= event; });
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
};

/// Lines of `after_ns,name,value` below a line that names the columns, as ratslam_em writes them.
/// @throws std::runtime_error naming file, line and what is wrong
std::vector<ParameterChange> readParameterChanges(const std::string& path);

/// Tells a pipeline of changes; to be called before the first event. @param parameters  of its beginning
/// @throws std::invalid_argument naming a key that may not change, or a bad value
void addChanges(const std::vector<ParameterChange>& changes, ParameterMap parameters, Pipeline& pipeline);

}  // namespace ratslam
