#include "ratslam/system/pose_cell_snapshots.h"

#include <sstream>

#include "ratslam/common/atomic_file.h"
#include "ratslam/common/stamp.h"
#include "ratslam/common/state.h"
#include "ratslam/common/text_file.h"
#include "ratslam/dataset/csv.h"

namespace ratslam {

SnapshotMoments SnapshotMoments::evenly(std::size_t count, std::size_t decisions) {
  SnapshotMoments moments;
  for (std::size_t i = 1; i <= count; ++i) {
    const std::size_t passed = i * decisions / count;
    if (passed > 0) moments.numbers.push_back(passed - 1);
  }
  return moments;
}

SnapshotMoments SnapshotMoments::fromTimes(const std::string& text) {
  SnapshotMoments moments;
  for (const std::string& word : splitCsv(text)) {
    double time = 0.0;
    if (!parseNumber(word, time) || time < 0.0 || (!moments.times.empty() && time <= moments.times.back())) {
      throwBadValue("--pose-cells-at", shown(text),
                    "it must be rising times in seconds with commas between: 10,20.5");
    }
    moments.times.push_back(time);
  }
  return moments;
}

void PoseCellSnapshots::save(State& state) const {
  for (std::size_t i = 0; i < snapshots_.size(); ++i) {
    State& snapshot = state.child("snapshots").child(std::to_string(i));
    snapshot.set("stamp", snapshots_[i].stamp);
    snapshots_[i].activity.save(snapshot.child("activity"));
  }
  state.set("count", static_cast<std::uint64_t>(snapshots_.size()));
  state.set("next", static_cast<std::uint64_t>(next_));
  state.set("decisions", static_cast<std::uint64_t>(decisions_));
  state.set("start", start_);
}

void PoseCellSnapshots::load(const State& state, const PoseCells& cells) {
  snapshots_.clear();
  const auto count = state.get<std::uint64_t>("count");
  for (std::uint64_t i = 0; i < count; ++i) {
    const State& snapshot = state.child("snapshots").child(std::to_string(i));
    snapshots_.push_back({snapshot.get<Stamp>("stamp"), cells.activity()});
    snapshots_.back().activity.load(snapshot.child("activity"));
  }
  next_ = state.get<std::uint64_t>("next");
  decisions_ = state.get<std::uint64_t>("decisions");
  state.get("start", start_);
  last_ = start_;
}

bool PoseCellSnapshots::momentPasses(Stamp stamp) {
  if (decisions_ == 0) start_ = stamp;
  last_ = stamp;
  const std::size_t number = decisions_++;
  const std::size_t before = next_;
  while (next_ < moments_.times.size() && secondsBetween(start_, stamp) >= moments_.times[next_]) ++next_;
  while (next_ < moments_.numbers.size() && number >= moments_.numbers[next_]) ++next_;
  return next_ > before;
}

void PoseCellSnapshots::follow(const Pipeline::Progress& progress, const PoseCells& cells) {
  bool due = false;
  for (const PoseCellDecision& decision : progress.decisions) {
    if (momentPasses(decision.view.stamp)) due = true;
  }
  if (due) snapshots_.push_back({progress.decisions.back().view.stamp, cells.activity()});
}

std::optional<std::string> PoseCellSnapshots::complaint() const {
  if (next_ >= moments_.times.size()) return std::nullopt;
  std::ostringstream text;
  text << "--pose-cells-at: value " << moments_.times[next_] << ": the last decision is "
       << secondsBetween(start_, last_) << " s after the first; " << moments_.times.size() - next_
       << " of the " << moments_.times.size() << " times lie behind it";
  return text.str();
}

void PoseCellSnapshots::write(const std::string& path) const {
  AtomicFile file(path);
  write(file.stream());
  file.commit();
}

void PoseCellSnapshots::write(std::ostream& file) const {
  constexpr double kLeast = 1e-6;
  constexpr int kDigits = 6;
  const auto precision = file.precision(kDigits);
  file << "stamp,layer,row,column,activity\n";
  for (const Snapshot& snapshot : snapshots_) {
    const ActivityGrid& activity = snapshot.activity;
    for (int layer = 0; layer < activity.nTh(); ++layer) {
      for (int row = 0; row < activity.nXy(); ++row) {
        for (int column = 0; column < activity.nXy(); ++column) {
          const double value = activity.at({column, row, layer});
          if (value < kLeast) continue;
          file << formatStamp(snapshot.stamp) << ',' << layer << ',' << row << ',' << column << ',' << value
               << '\n';
        }
      }
    }
  }
  file.precision(precision);
}

}  // namespace ratslam
