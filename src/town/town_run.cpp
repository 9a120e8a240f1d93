#include "town/town_run.h"

#include "town/drive.h"
#include "town/hash.h"
#include "town/sensors.h"
#include "town/town.h"
#include "town/town_renderer.h"
#include "town/traffic.h"

namespace ratslam {

TownSummary runTown(const TownOptions& options, TownSink& sink, const TownProgress& progress) {
  options.validate();
  constexpr int kDefaultFrames = 600;
  const bool recorded = !options.trajectory.empty();
  Drive drive = recorded
                    ? loadDrive(options.trajectory, options.times, options.frames < 0 ? 0 : options.frames)
                    : planTownDrive(options.frames < 0 ? kDefaultFrames : options.frames);
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const Town town(drive.roads, seed, options.identical_houses);
  if (recorded) settleOnRoad(drive, town.roads());
  const TownRenderer renderer(town, options.camera(), options.threads);
  const Traffic traffic(drive, town.roads(), town.textures(), options.moving_cars, seed);
  const DriveSensors sensors(drive, options);

  TownSummary summary;
  Stamp next_gps = 0;
  const int total = static_cast<int>(drive.poses.size());
  for (std::size_t i = 0; i < drive.poses.size(); ++i) {
    TownFrame frame;
    frame.index = static_cast<int>(i);
    frame.stamp = drive.poses[i].stamp;
    frame.T_world_camera = drive.poses[i].T_world_camera;
    Exposure exposure = options.exposure ? exposureAt(toSeconds(frame.stamp), seed) : Exposure{};
    exposure.other_light =
        options.other_light_after >= 0.0 && toSeconds(frame.stamp) >= options.other_light_after;
    frame.image = expose(renderer.renderFloat(frame.T_world_camera, traffic.at(i)), exposure, options.noise,
                         hashOf(seed, 100, i));
    if (options.wheelOdometry()) frame.wheel = sensors.wheel(i);
    if (frame.stamp >= next_gps) {
      frame.gps = sensors.gps(i);
      next_gps = frame.stamp + stampFromSeconds(1.0);
    }
    frame.imu = sensors.imu(i);
    sink.add(frame);
    ++summary.frames;
    summary.seconds = toSeconds(frame.stamp);
    if (i > 0)
      summary.way +=
          (frame.T_world_camera.translation() - drive.poses[i - 1].T_world_camera.translation()).norm();
    if (progress && !progress(summary.frames, total)) break;
  }
  sink.finish();
  return summary;
}

}  // namespace ratslam
