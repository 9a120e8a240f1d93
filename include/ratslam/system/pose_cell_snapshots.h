/// The pose cells' activity at chosen moments of a run, kept for pictures drawn later.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/system/pipeline.h"

namespace ratslam {

/// When snapshots are taken: after the first decision at or past each of the times, or, where there are no
/// times, after the decisions of the given numbers.
struct SnapshotMoments {
  std::vector<double> times;         ///< since the first decision [s], rising
  std::vector<std::size_t> numbers;  ///< counted from 0, rising

  /// `count` moments spread evenly over `decisions` of them, the last at the end.
  static SnapshotMoments evenly(std::size_t count, std::size_t decisions);
  /// "10,20.5": times in seconds. @throws std::invalid_argument where they are no rising numbers from 0 on
  static SnapshotMoments fromTimes(const std::string& text);
};

class PoseCellSnapshots {
 public:
  explicit PoseCellSnapshots(const SnapshotMoments& moments) : moments_(moments) {}

  /// To be told of every progress, while the pose cells are as it left them. Of several decisions in one
  /// progress only the last has left its activity.
  void follow(const Pipeline::Progress& progress, const PoseCells& cells);

  std::size_t size() const { return snapshots_.size(); }
  /// What is to be said where the drive ended before a time that was asked for.
  std::optional<std::string> complaint() const;

  /// The moments are the caller's; what was kept at those that have passed is saved.
  void save(State& state) const;
  void load(const State& state, const PoseCells& cells);

  /// CSV: stamp,layer,row,column,activity: a line a cell that holds at least a millionth of the activity, in
  /// the order of stamps, layers, rows and columns. @throws std::runtime_error naming the file
  void write(const std::string& path) const;
  void write(std::ostream& file) const;

 private:
  struct Snapshot {
    Stamp stamp = 0;
    ActivityGrid activity;
  };

  bool momentPasses(Stamp stamp);

  SnapshotMoments moments_;
  std::vector<Snapshot> snapshots_;
  std::size_t next_ = 0;  ///< of the moments
  std::size_t decisions_ = 0;
  Stamp start_ = 0;
  Stamp last_ = 0;  ///< of the decisions
};

}  // namespace ratslam
