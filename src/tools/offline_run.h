// One run of the whole system over a recording. Whatever ends it before the recording does, what was mapped
// until then is finished and written.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/system/image_stage.h"
#include "ratslam/system/map_store.h"
#include "ratslam/system/odometry_span.h"
#include "ratslam/system/pose_cell_snapshots.h"
#include "ratslam/system/run_log.h"
#include "ratslam/view/run_video.h"
#include "run_options.h"

namespace ratslam {

class OfflineRun {
 public:
  /// Finds out everything that can be found wrong before the first image, unwritable outputs among it.
  /// @throws std::exception with one clear line
  explicit OfflineRun(const RunOptions& options);

  /// Runs until the recording ends, max_frames are over, a signal asks for the end or something fails; then
  /// writes what there is. @return whether all went well; else one clear line has been said
  bool run();

 private:
  void loadMap(const OdometryKind& kind);
  /// @return whether there is nothing to save, or it is saved; else it has been said why not
  bool saveMap() const;
  void addImage(const DecodedImage& image);
  void follow(const Pipeline::Progress& progress);
  void finish(double decoding_seconds);
  void sayWhatWasLeft() const;
  void sayWhatOdometryLacks() const;
  bool nothingCameOfIt() const;
  /// @return whether pose cells were asked for at times that the drive has not, which has been said
  bool snapshotsAreMissing() const;
  bool wanted() const;
  std::size_t totalFrames() const;

  RunOptions options_;
  ParameterMap parameters_;
  PipelineParams params_;
  std::unique_ptr<Recording> recording_;
  std::unique_ptr<Pipeline> pipeline_;
  std::map<std::string, std::string> map_parameters_;
  std::vector<MapSession> sessions_;  ///< before this run
  std::unique_ptr<MapLock> map_lock_;
  std::unique_ptr<MapWriter> map_writer_;
  std::optional<Stamp> first_stamp_;
  std::optional<Stamp> last_stamp_;
  std::size_t taken_ = 0;  ///< images of this run
  std::array<bool, kImageEvents> said_{};
  ImageStage images_;
  OdometrySpan span_;
  std::unique_ptr<RunLog> log_;
  PoseCellSnapshots snapshots_;
  std::optional<PoseCellRecording> cells_;
  std::unique_ptr<RunVideo> video_;
};

}  // namespace ratslam
