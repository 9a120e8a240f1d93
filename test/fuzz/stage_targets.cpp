// Odometry, views, decisions, measured geometry and images, of any stamps and values, into the stages.
#include <cmath>
#include <stdexcept>

#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/simd/feature_kernels.h"
#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"
#include "target.h"

namespace ratslam::fuzz {
namespace {

/// Any stamp that a message can carry; mostly a little after the one before.
class Clock {
 public:
  Stamp next(Reader& reader) {
    const auto how = reader.take<std::uint8_t>();
    if (how < 250) {
      now_ += static_cast<Stamp>(how) * 10'000'000;
    } else {
      now_ = static_cast<Stamp>(reader.take<std::uint32_t>()) * 1'000'000'000 + reader.take<std::uint32_t>();
    }
    return now_;
  }

 private:
  Stamp now_ = 0;
};

/// Any double, undefined ones included; mostly a usual one.
double number(Reader& reader) {
  const auto how = reader.take<std::int8_t>();
  return how == 127 ? reader.take<double>() : 0.1 * how;
}

OdometrySample sample(Reader& reader, Clock& clock) {
  OdometrySample sample;
  sample.stamp = clock.next(reader);
  sample.speed = number(reader);
  sample.yaw_rate = number(reader);
  if (reader.take<std::uint8_t>() % 4 == 0) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() << number(reader), number(reader), number(reader);
    sample.pose = pose;
  }
  return sample;
}

void poseCellStage(const Bytes& input) {
  Reader reader(input);
  Clock clock;
  PoseCellStage stage{fewPoseCells()};
  for (int steps = 0; !reader.atEnd() && steps < 100; ++steps) {
    const auto what = reader.take<std::uint8_t>();
    if (what % 8 == 7) {
      stage.drain(Passing::kAll);
    } else if (what % 2 == 0) {
      stage.addOdometry(sample(reader, clock));
    } else {
      ViewEvent view;
      view.stamp = clock.next(reader);
      view.id = what % 16 == 1 ? reader.take<std::uint32_t>() : reader.take<std::uint8_t>() % 16;
      view.relative_rad = number(reader);
      mayRefuse([&] { stage.addView(view); });
    }
    for (const PoseCellDecision& decision : stage.drain()) {
      const PoseCellEstimate& at = decision.estimate;
      require(std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.th), "the estimate is finite");
    }
  }
}

TopologicalAction decision(Reader& reader, Clock& clock, std::uint32_t created) {
  TopologicalAction action;
  action.stamp = clock.next(reader);
  const auto kind = reader.take<std::uint8_t>();
  action.kind = static_cast<ActionKind>(kind % 4);
  const auto id = [&] {
    return kind >= 240 ? reader.take<std::uint32_t>() : reader.take<std::uint8_t>() % (created + 1);
  };
  action.src_id = id();
  action.dest_id = action.kind == ActionKind::kCreateNode && kind < 240 ? created : id();
  action.relative_rad = number(reader);
  return action;
}

RecallGeometry geometry(Reader& reader, Clock& clock) {
  RecallGeometry geometry;
  geometry.stamp = clock.next(reader);
  geometry.view_id = reader.take<std::uint8_t>();
  for (double* value : {&geometry.relative_rad, &geometry.direction_rad, &geometry.distance,
                        &geometry.sigma_distance, &geometry.sigma_rotation, &geometry.sigma_direction,
                        &geometry.distance_ratio, &geometry.sigma_ratio, &geometry.ahead}) {
    *value = number(reader);
  }
  geometry.inliers = reader.take<std::int8_t>();
  geometry.template_stamp = clock.next(reader);
  geometry.companion_stamp = clock.next(reader);
  return geometry;
}

void mapStage(const Bytes& input) {
  Reader reader(input);
  Clock clock;
  const auto settings = reader.take<std::uint8_t>();
  ExperienceMapParams params;
  if ((settings & 2U) != 0) {
    params.exp_solver = "relaxation";
  } else {
    params.exp_height = (settings & 4U) != 0;
    params.exp_scale = (settings & 8U) != 0;
  }
  MapStage stage(params, settings % 2 == 1 ? GeometrySource::kImages : GeometrySource::kNone);
  for (int steps = 0; !reader.atEnd() && steps < 60; ++steps) {
    const auto what = reader.take<std::uint8_t>();
    const auto created = static_cast<std::uint32_t>(stage.map().graph().experiences().size());
    mayRefuse([&] {  // as the node does, which drops what is refused
      if (what % 16 == 15) {
        stage.drain(Passing::kAll);
      } else if (what % 16 == 14) {
        stage.map().setGoal(number(reader), number(reader));
      } else if (what % 4 == 0) {
        stage.addDecision(decision(reader, clock, created));
      } else if (what % 4 == 1 && settings % 2 == 1) {
        stage.addGeometry(geometry(reader, clock));
      } else {
        stage.addOdometry(sample(reader, clock));
      }
    });
    mayRefuse([&] { stage.drain(); });
  }
  mayRefuse([&] { stage.drain(Passing::kAll); });
  stage.map().settle();
  requireFinite(stage.map());
}

void views(const Bytes& input) {
  constexpr int kDepths[] = {CV_8U, CV_8U, CV_16U, CV_8S, CV_32F, CV_64F, CV_32S};
  Reader reader(input);
  LocalViewParams params;
  params.view_template.x_size = 8;
  params.view_template.y_size = 4;
  params.shift_match = 2;
  params.step_match = 1;
  LocalViewCells cells(params);
  for (int images = 0; !reader.atEnd() && images < 20; ++images) {
    const int rows = reader.take<std::uint8_t>() % 48;
    const int columns = reader.take<std::uint8_t>() % 48;
    const int type =
        CV_MAKETYPE(kDepths[reader.take<std::uint8_t>() % 7], 1 + reader.take<std::uint8_t>() % 5);
    cv::Mat image(rows, columns, type, cv::Scalar::all(0));
    const Bytes pixels = reader.takeBytes(image.total() * image.elemSize());
    if (!pixels.empty()) std::copy(pixels.begin(), pixels.end(), image.data);
    mayRefuse([&] {
      const ViewEvent view = cells.observe(images, image);
      require(!view.seen() || (view.id < cells.size() && std::isfinite(view.error)),
              "a view event names a view cell");
    });
  }
}

void planted(const Bytes& input) {
  if (input.size() < 3 || input[0] != 'R' || input[1] != 'A' || input[2] != 'T') return;
  const Bytes descriptor(32);
  const Bytes too_short(31);  // the core reads one byte beyond it
  featureKernels(SimdLevel::kScalar).hammingDistance(descriptor.data(), too_short.data());
}

}  // namespace

PoseCellParams fewPoseCells() {
  PoseCellParams params;
  params.n_xy = 7;
  params.n_th = 6;
  params.excitation_dim = params.inhibition_dim = 3;
  return params;
}

void requireFinite(const ExperienceMap& map) {
  for (const auto& trajectory : {map.onlineTrajectory(), map.finalTrajectory()}) {
    for (const StampedPose& stamped : trajectory) {
      const MapPose& pose = stamped.pose;
      const bool finite = std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.z) &&
                          std::isfinite(pose.yaw) && stamped.attitude().coeffs().allFinite();
      require(finite, "poses of the map are finite");
    }
  }
}

std::vector<Target> stageTargets() {
  return {{"pose_cell_stage", poseCellStage}, {"map_stage", mapStage}, {"views", views}};
}

Target plantedFault() { return {"planted", planted}; }

}  // namespace ratslam::fuzz
