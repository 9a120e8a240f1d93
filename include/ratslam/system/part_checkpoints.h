/// Checkpoints of one part of the system in a folder, for restarts.
///
/// A checkpoint is taken at each multiple of a period of message time, before the first message beyond it is
/// processed. So parts in different processes have checkpoints at the same stamps. The State is copied when it is
/// taken. A separate thread writes it, so that no message waits for a disk. Two files are written in turn, PART.a.db
/// and PART.b.db: if one is damaged, the other still holds the previous checkpoint.
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
  std::string folder;      ///< empty: no checkpoints
  std::string part;        ///< "local_view", "pose_cells", ...
  double period = 5.0;     ///< [s] of message time
  bool read_only = false;  ///< checkpoints are loaded and not changed
  /// How long another program may hold the files [s]. A node that is replaced by one of its own name takes a while to end.
  double patience = 8.0;
  std::map<std::string, std::string> parameters;
};

class PartCheckpoints {
 public:
  using Save = std::function<void(State&)>;

  /// @throws std::runtime_error if the folder cannot be made or written; MapBusy if another program still writes there
  /// after some seconds, in which one that is ending has released it
  explicit PartCheckpoints(const CheckpointSettings& settings);
  /// Waits until the last checkpoint is written.
  ~PartCheckpoints();
  PartCheckpoints(const PartCheckpoints&) = delete;
  PartCheckpoints& operator=(const PartCheckpoints&) = delete;

  /// The part's State from the newest usable checkpoint; none if there is none.
  /// @param report receives one line for each damaged checkpoint, and one that names the checkpoint used.
  /// @throws std::runtime_error if a checkpoint was made with other parameters; MapUnread if one may be sound but
  /// cannot be read, as while another program keeps it locked: it must not be replaced
  std::optional<State> resume(const std::function<void(const std::string&)>& report);

  /// To be called before a message is processed. Takes a checkpoint if one is due.
  void before(Stamp message, const Save& save);
  /// Why saveNow would write nothing: there is no folder, it is read-only, or no message has come. None if it writes.
  std::optional<std::string> whyNothingIsSaved() const;
  /// Takes a checkpoint at the newest stamp seen, and waits until it is written.
  /// @throws std::runtime_error naming file and cause
  void saveNow(const Save& save);

  /// Writes the part of the map to a separate file.
  /// @throws std::runtime_error naming file and cause, or saying that there is no folder, or nothing to save
  void saveTo(const std::string& path, const Save& save) const;
  /// Writes a checkpoint on trial and removes it, unless nothing is saved. @throws std::runtime_error if there is no room
  void requireRoom(const Save& save) const;
  /// The State of this part from a map file, which may hold other parts, too.
  /// @throws std::runtime_error if it cannot be used: missing, damaged, of other parameters, without this part
  State loadFrom(const std::string& path) const;
  /// Later checkpoints continue that map file, or with an empty path a new map: they have its sessions, and the present
  /// one begins with the next message. A map that was loaded can be saved at once, with its own stamp.
  /// @throws std::runtime_error as loadFrom does
  void continueFrom(const std::string& path);

  /// While on, checkpoints are not changed.
  /// @throws std::runtime_error if it is turned off and checkpoints cannot be written
  void setReadOnly(bool on);

  /// Why the last checkpoint could not be written; each failure is returned once. None if it was written.
  std::optional<std::string> takeFailure();

  bool enabled() const { return impl_ != nullptr; }
  const CheckpointSettings& settings() const { return settings_; }

 private:
  struct Impl;
  CheckpointSettings settings_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ratslam
