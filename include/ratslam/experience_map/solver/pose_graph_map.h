/// The default solver of the experience map: a weighted graph, kept at its optimum in slices.
///
/// Frames are the nodes of a pose graph (pose_graph.h). The robot's way through them is one unbroken chain of
/// stiff odometry constraints; each created experience is a node of it. Recalling an experience adds a node
/// of its own, where the robot stands, and a loose constraint from the experience to it:
///
///  - without image geometry: the same place and heading, give or take exp_recall_sigma and
///  exp_recall_facing_sigma, or what recall_spread.h has learned;
///  - with it: the measured heading, tight across the measured direction of the offset, loose along it.
///
/// So a link by recall is a composition - odometry to the present place, which is the matched one up to about
/// a metre - and the chain goes on from where the robot is, not from where it was when it first came by.
///
/// Geometry is relative to where the template was learned. An experience that was created where a known
/// template was recalled lies elsewhere: its offset from there is kept as far as it is known, and geometry is
/// used only as far.
#pragma once

#include <optional>
#include <vector>

#include "ratslam/experience_map/params.h"
#include "ratslam/experience_map/solver/map_solver.h"
#include "ratslam/experience_map/solver/pose_graph_solver.h"
#include "ratslam/experience_map/solver/recall_spread.h"

namespace ratslam {

class PoseGraphMap : public MapSolver {
 public:
  explicit PoseGraphMap(const ExperienceMapParams& params);

  MapPose framePose(const ExperienceGraph& graph, std::uint32_t frame) const override;
  std::uint32_t frameOf(std::uint32_t experience) const override { return nodes_[experience]; }
  RobotPlace create(const ExperienceGraph& graph, const RobotPlace& robot,
                    const RecallGeometry* geometry) override;
  RobotPlace recall(const ExperienceGraph& graph, std::uint32_t experience, const RobotPlace& robot,
                    double relative_rad, const RecallGeometry* geometry) override;
  RobotPlace anchor(const ExperienceGraph& graph, const RobotPlace& robot) override;
  std::optional<Eigen::Matrix4d> covariance(const RobotPlace& robot) const override;
  bool corrects() const override { return !nodes_.empty(); }
  void correct(ExperienceGraph& graph, const CorrectedWay& way) override;
  void update(ExperienceGraph& graph, RobotPlace& robot) override;
  void resume(ExperienceGraph& graph) override;
  void settle(ExperienceGraph& graph) override;
  void save(State& state) const override;
  void load(const State& state) override;

  const PoseGraph& poseGraph() const { return pose_graph_; }

 private:
  /// Where an experience lies relative to where its template was learned, in the axes of then.
  struct TemplateOffset {
    double rotation = 0.0;                        ///< [rad]
    std::optional<Eigen::Vector2d> displacement;  ///< [m], unless the distance is unknown

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("rotation", rotation);
      fields("displacement", displacement);
    }
  };

  std::uint32_t extendChain(const RobotPlace& robot);
  /// What the robot's odometry since its frame makes a constraint to where it is.
  Constraint chainConstraint(const RobotPlace& robot) const;
  /// Covariance of the newest node, once the solver has reached an optimum.
  void takeCovariance();
  NodeCovariance carried(const Constraint& constraint, const NodeCovariance& covariance) const;
  void setWeights(Constraint& constraint, const Eigen::Matrix2d& xy, double z, double yaw) const;
  Constraint recallConstraint(std::uint32_t experience, double relative_rad,
                              const RecallGeometry* geometry) const;
  void work(ExperienceGraph& graph, std::int64_t amount);
  /// Weighs recalls anew where enough have come in. @return whether it did
  bool learnSpread();

  ExperienceMapParams params_;
  PoseGraph pose_graph_;
  PoseGraphSolver solver_;
  std::vector<std::uint32_t> nodes_;     ///< of the experiences
  std::vector<TemplateOffset> offsets_;  ///< of the experiences
  RecallSpread spread_;
  NodeCovariance newest_covariance_ = NodeCovariance::Zero();  ///< of the newest node
  bool recalled_ = false;  ///< the last action added evidence: a created experience leaves nothing to solve
  double disagreement_ =
      0.0;  ///< of recalls with the map that is left to mend [standard deviations of place]
};

}  // namespace ratslam
