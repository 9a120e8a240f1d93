/// Parameters of the experience map: OpenRatSLAM's keys, those of the weighted graph and of the goal planner.
///
/// Lengths are in the unit of the odometry: metres if the odometry is metric. `exp_recall_sigma` is the size of
/// "the same place"; by default it is learned. An odometry without covariance gets random walks that are stated
/// per square root of that length. Thus a small robot needs no other values.
#pragma once

#include <string>

#include "ratslam/common/params.h"

namespace ratslam {

struct ExperienceMapParams {
  double exp_correction = 0.5;
  int exp_loops = 10;
  double exp_initial_em_deg = 90.0;
  std::string exp_solver = "graph";
  bool exp_scale = false;
  bool exp_height = false;
  double exp_recall_sigma = 0.0;
  double exp_recall_facing_sigma = 0.3;
  double exp_recall_kernel = 2.0;
  double exp_odometry_sigma = 0.03;
  double exp_rotation_sigma = 0.001;
  double exp_scale_sigma = 0.003;
  int exp_trajectory_poses = 100'000;
  double exp_goal_radius = 5.0;
  double exp_goal_timeout = 600.0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("exp_correction", exp_correction, Bounds{0.0, 0.5},
          "relaxation: share of a link's disagreement by which a sweep moves each end");
    visit("exp_loops", exp_loops, Bounds{0, 100000}, "relaxation: sweeps over all links after each action");
    visit("exp_initial_em_deg", exp_initial_em_deg, Bounds{-360.0, 360.0}, "heading at the start [deg]");
    visit("exp_solver", exp_solver, Bounds{},
          "graph: least squares over weighted links; relaxation: OpenRatSLAM's sweeps");
    visit("exp_scale", exp_scale, Bounds{}, "graph: estimate the odometry's scale at each experience");
    visit("exp_height", exp_height, Bounds{}, "graph: estimate the height of each experience");
    visit("exp_recall_sigma", exp_recall_sigma, Bounds{0.0, 1e6},
          "graph: standard deviation of the distance between two views that match [m]; 0: learned from "
          "the spacing of the experiences and from how far recalls agree");
    visit("exp_recall_facing_sigma", exp_recall_facing_sigma, Bounds{1e-4, 10.0},
          "graph: standard deviation of the heading of a recall without image geometry [rad]");
    visit("exp_recall_kernel", exp_recall_kernel, Bounds{0.1, 1e6},
          "graph: residual above which a recall loses weight as an outlier [standard deviations]");
    visit("exp_odometry_sigma", exp_odometry_sigma, Bounds{1e-6, 10.0},
          "graph: relative error of the odometry's distance over a stretch of one exp_recall_sigma, for an "
          "odometry without covariance");
    visit("exp_rotation_sigma", exp_rotation_sigma, Bounds{1e-7, 10.0},
          "graph: error of the odometry's heading over a stretch of one exp_recall_sigma, for an odometry "
          "without covariance [rad]");
    visit("exp_scale_sigma", exp_scale_sigma, Bounds{1e-9, 10.0},
          "graph: change of the odometry's log-scale over a stretch of one exp_recall_sigma, for an odometry "
          "that does not state it");
    visit(
        "exp_trajectory_poses", exp_trajectory_poses, Bounds{0, 1'000'000'000},
        "most poses kept of the robot's path; a longer path is thinned and keeps its shape; 0: all are kept");
    visit("exp_goal_radius", exp_goal_radius, Bounds{0.0, 1e9},
          "greatest distance of a goal from the nearest experience [m]");
    visit("exp_goal_timeout", exp_goal_timeout, Bounds{0.0, 1e9}, "time allowed for reaching a goal [s]");
  }

  bool relaxes() const { return exp_solver == "relaxation"; }

  /// @throws std::invalid_argument naming key, value and requirement.
  void validate() const;
};

}  // namespace ratslam
