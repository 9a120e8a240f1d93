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
/// An experience that has been recalled more often is known ground. Where a further recall agrees with the map
/// it makes no node: the robot stands beside the experience (standing.h), and the way from one such recall to
/// another adds evidence to what is known of the way between the two (pass_evidence.h). Its ends are as far apart
/// as it takes for odometry to err as much as a recall does: what is between them would say little more. So the graph grows with
/// the ground that has been seen, not with the time that is spent on it (cf. the reduced pose graph of Johannsson,
/// Kaess, Fallon & Leonard, "Temporally scalable visual SLAM using a reduced pose graph", ICRA 2013).
///
/// Geometry is relative to where the template was learned. An experience that was created where a known
/// template was recalled lies elsewhere: its offset from there is kept as far as it is known, and geometry is
/// used only as far.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "ratslam/experience_map/params.h"
#include "ratslam/experience_map/solver/map_solver.h"
#include "ratslam/experience_map/solver/pass_evidence.h"
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

  std::size_t frames() const override { return pose_graph_.nodes().size(); }

  const PoseGraph& poseGraph() const { return pose_graph_; }
  const PassEvidence& evidence() const { return evidence_; }

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
  /// What the robot's odometry since it was placed makes a constraint to where it is.
  Constraint drivenConstraint(const RobotPlace& robot) const;
  /// The same from its frame, beside which it may have been placed.
  Constraint chainConstraint(const RobotPlace& robot) const;
  /// Covariance of the newest node, once the solver has reached an optimum.
  void takeCovariance();
  NodeCovariance carried(const Constraint& constraint, const NodeCovariance& covariance) const;
  void setWeights(Constraint& constraint, const Eigen::Matrix2d& xy, double z, double yaw) const;
  Constraint recallConstraint(std::uint32_t experience, double relative_rad,
                              const RecallGeometry* geometry) const;
  // Known ground (known_ground.cpp).
  /// Whether a recall, not yet joined to anything, is to make no node.
  bool onKnownGround(std::uint32_t experience, const Constraint& recall, const RobotPlace& robot) const;
  bool agrees(const Constraint& recall, const RobotPlace& robot) const;
  /// Whether a recall disagrees alone with where recalls before it have placed the robot: it is left out.
  bool strayed(std::uint32_t experience, const Constraint& recall, const RobotPlace& robot);
  /// A recall that makes no node. @return the robot's place beside the experience
  RobotPlace pass(const Constraint& recall, const RobotPlace& robot);
  /// Where the robot is in the axes of a node.
  Prediction predicted(const RobotPlace& robot, const MapPose& place) const;
  /// How well its place relative to its frame is known, in the axes of the frame [m].
  NodeCovariance spreadBeside(const RobotPlace& robot, const Constraint& driven) const;
  /// What it has driven since it was placed, in its own axes of then and the map's unit.
  UncertainPose drivenWay(const RobotPlace& robot) const;
  /// Goes on with the robot's way up to a recall that agrees, and makes evidence of it where it is long enough.
  void goOn(Standing& standing, std::uint32_t to, const UncertainPose& seen, const RobotPlace& robot);

  void work(ExperienceGraph& graph, std::int64_t amount);
  /// Weighs recalls anew where enough have come in. @return whether it did
  bool learnSpread();

  ExperienceMapParams params_;
  PoseGraph pose_graph_;
  PoseGraphSolver solver_;
  std::vector<std::uint32_t> nodes_;     ///< of the experiences
  std::vector<TemplateOffset> offsets_;  ///< of the experiences
  std::vector<std::uint32_t> recalls_;   ///< of the experiences that made nodes
  RecallSpread spread_;
  PassEvidence evidence_;
  std::optional<std::uint32_t> beside_;  ///< node that the robot stands beside, if it does
  std::uint32_t strays_ = 0;             ///< recalls in a row that disagreed
  /// Covariance of the newest node, or of that which the robot stands beside.
  NodeCovariance newest_covariance_ = NodeCovariance::Zero();
  std::map<std::uint32_t, NodeCovariance> ground_;  ///< of nodes that it has stood beside
  bool recalled_ = false;  ///< the last action added evidence: a created experience leaves nothing to solve
  double disagreement_ =
      0.0;  ///< of recalls with the map that is left to mend [standard deviations of place]
};

}  // namespace ratslam
