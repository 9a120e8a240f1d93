// One run of the whole system over a recording. If it ends early for any reason, the map so far is finished and written.
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
#include "ratslam/system/parameter_changes.h"
#include "ratslam/system/pose_cell_snapshots.h"
#include "ratslam/system/run_log.h"
#include "ratslam/view/run_video.h"
#include "run_options.h"

namespace ratslam {

class OfflineRun {
 public:
  /// Checks everything that can be checked before the first image, for example that outputs can be written.
  /// @throws std::exception with one clear line
  explicit OfflineRun(const RunOptions& options);

  /// Runs until the recording or max_frames end, a signal requests the end, or something fails. Then writes the results.
  /// @return whether all went well; if not, one clear line has been printed
  bool run();

 private:
  void loadMap(const OdometryKind& kind);
  void sayWhatIsForNodes() const;
  /// @return false if the map was to be saved and could not be; the reason has been printed
  bool saveMap() const;
  /// Ends a run that has mapped nothing. @return what becomes of the map file
  std::string withoutMap();
  void addImage(const DecodedImage& image);
  void follow(const Pipeline::Progress& progress);
  void finish(double decoding_seconds);
  void sayWhatWasLeft() const;
  void sayWhatOdometryLacks() const;
  /// Why the run was in vain; none if something was mapped.
  std::optional<std::string> nothingCameOfIt() const;
  /// @return whether the drive ended before one of the snapshots' times; that has been printed
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
  bool map_is_new_ = false;           ///< the file did not exist before
  std::optional<Stamp> first_stamp_;  ///< of the images that this run has used
  std::optional<Stamp> last_stamp_;   ///< of the images used so far; first that of the loaded map
  std::size_t taken_ = 0;             ///< number of images of this run
  std::array<bool, kImageEvents> said_{};
  ImageStage images_;
  OdometrySpan span_;
  std::unique_ptr<RunLog> log_;
  std::vector<ParameterChange> changes_;
  PoseCellSnapshots snapshots_;
  std::optional<PoseCellRecording> cells_;
  std::unique_ptr<RunVideo> video_;
};

}  // namespace ratslam
