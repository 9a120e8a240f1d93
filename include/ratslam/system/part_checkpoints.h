/// Checkpoints that one part of the system keeps of itself in a folder, for restarts.
///
/// A checkpoint is taken at each multiple of a period of message time, before the first message beyond it is
/// taken in: parts that do so each for itself, in processes of their own, have checkpoints of common stamps.
/// The State is copied where it is taken; a thread of its own writes it, so that no message waits for a disk.
/// Two files take turns, PART.a.db and PART.b.db: where one is damaged the other still holds the checkpoint
/// before.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/system/map_store.h"

namespace ratslam {

struct CheckpointSettings {
  std::string folder;      ///< empty: nothing is kept
  std::string part;        ///< "local_view", "pose_cells", ...
  double period = 5.0;     ///< [s] of message time
  bool read_only = false;  ///< what is there is loaded and stays as it is
  std::map<std::string, std::string> parameters;
};

class PartCheckpoints {
 public:
  using Save = std::function<void(State&)>;

  /// @throws std::runtime_error where the folder cannot be made or written, or another program writes there
  explicit PartCheckpoints(const CheckpointSettings& settings);
  /// Waits until what was taken is written.
  ~PartCheckpoints();
  PartCheckpoints(const PartCheckpoints&) = delete;
  PartCheckpoints& operator=(const PartCheckpoints&) = delete;

  /// The part's State as of the newest checkpoint that can be used; none where there is none.
  /// @param report told in one line each: which checkpoint is used, and what is wrong with a newer one.
  /// @throws std::runtime_error where there is one that was made with other parameters
  std::optional<State> resume(const std::function<void(const std::string&)>& report);

  /// To be called before a message is taken in; takes a checkpoint if one is due.
  void before(Stamp message, const Save& save);
  /// Why saveNow writes nothing: there is no folder, it stays as it is, no message has come; none where it writes.
  std::optional<std::string> whyNothingIsSaved() const;
  /// Takes a checkpoint now, at the newest stamp seen, and waits until it is written.
  /// @throws std::runtime_error naming file and cause
  void saveNow(const Save& save);

  /// Writes the part's share of a map to a file of its own.
  /// @throws std::runtime_error naming file and cause, or saying that there is no folder, or nothing to save
  void saveTo(const std::string& path, const Save& save) const;
  /// The part's share of a map file: of this part alone, or of all of them.
  /// @throws std::runtime_error where it cannot be used: missing, damaged, of other parameters, without this part
  State loadFrom(const std::string& path) const;

  /// While on, checkpoints stay as they are.
  /// @throws std::runtime_error where they cannot be written from now on
  void setReadOnly(bool on);

  /// Why the last checkpoint could not be written, told once; none where it could.
  std::optional<std::string> takeFailure();

  bool enabled() const { return impl_ != nullptr; }
  const CheckpointSettings& settings() const { return settings_; }

 private:
  struct Impl;
  CheckpointSettings settings_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ratslam
