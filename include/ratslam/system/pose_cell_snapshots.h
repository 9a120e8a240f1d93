/// Snapshots of the pose cells' activity at chosen moments of a run, for figures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/system/pipeline.h"

namespace ratslam {

/// Moments of the snapshots: after the first decision at or past each of the times, or, without times, after the
/// decisions with the given numbers.
struct SnapshotMoments {
  std::vector<double> times;         ///< since the first decision [s], ascending
  std::vector<std::size_t> numbers;  ///< counted from 0, ascending

  /// `count` moments at equal distances over `decisions` decisions, the last one at the end.
  static SnapshotMoments evenly(std::size_t count, std::size_t decisions);
  /// "10,20.5": times [s]. @throws std::invalid_argument if they are not ascending numbers from 0 on
  static SnapshotMoments fromTimes(const std::string& text);
};

class PoseCellSnapshots {
 public:
  explicit PoseCellSnapshots(const SnapshotMoments& moments) : moments_(moments) {}

  /// To be called with every progress, directly after it. If a progress has several decisions, `cells` holds the
  /// activity after the last one only.
  void follow(const Pipeline::Progress& progress, const PoseCells& cells);

  std::size_t size() const { return snapshots_.size(); }
  /// A warning if the drive ended before one of the times.
  std::optional<std::string> complaint() const;

  /// Saves the snapshots, but not the moments, which the caller gives again.
  void save(State& state) const;
  void load(const State& state, const PoseCells& cells);

  /// Writes CSV with the columns stamp,layer,row,column,activity: one line for each cell with at least a millionth of
  /// the activity, in the order of stamps, layers, rows and columns. @throws std::runtime_error naming the file
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
  std::size_t next_ = 0;  ///< index of the next moment
  std::size_t decisions_ = 0;
  Stamp start_ = 0;
  Stamp last_ = 0;  ///< stamp of the last decision
};

}  // namespace ratslam
