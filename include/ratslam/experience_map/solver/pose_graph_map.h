/// The default solver of the experience map: a weighted pose graph that is kept at its optimum in slices.
///
/// Frames are the nodes of a pose graph (pose_graph.h). The robot's path is one unbroken chain of stiff odometry
/// constraints. Each created experience is a node of the chain. A recall adds a node at the robot's present pose
/// and a loose constraint to it from the recalled experience:
///
///  - Without image geometry: the same place and heading, with the standard deviations exp_recall_sigma and
///    exp_recall_facing_sigma, or those that recall_spread.h has learned.
///  - With image geometry: the measured heading, and an offset that is tight across its measured direction and
///    loose along it.
///
/// The chain continues from the new node and not from the experience, because the robot is near the experience
/// but not exactly there.
///
/// An experience that has been recalled several times is known ground. A further recall that agrees with the map
/// makes no node there: the robot is placed beside the experience (standing.h). The path from one such recall to
/// another is evidence of the relative pose of the two experiences (pass_evidence.h). The two lie so far apart
/// that odometry between them errs as much as a recall does; recalls between them would add little. So the graph
/// grows with the area that was seen and not with time (cf. the reduced pose graph of Johannsson, Kaess, Fallon &
/// Leonard, "Temporally scalable visual SLAM using a reduced pose graph", ICRA 2013).
///
/// Image geometry is relative to the place where the template was learned. An experience that was created when a
/// known template was recalled lies elsewhere. Its offset from the template's place is kept as far as it is
/// known: if only the rotation is known, only the rotation of later geometry is used.
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
  std::optional<RobotPlace> recall(const ExperienceGraph& graph, std::uint32_t experience,
                                   const RobotPlace& robot, double relative_rad,
                                   const RecallGeometry* geometry) override;
  RobotPlace locate(std::uint32_t experience, double relative_rad, const RecallGeometry* geometry) override;
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
  /// Pose of an experience relative to the place where its template was learned, in the robot's axes there.
  struct TemplateOffset {
    double rotation = 0.0;                        ///< [rad]
    std::optional<Eigen::Vector2d> displacement;  ///< [m]; none if the distance is unknown

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("rotation", rotation);
      fields("displacement", displacement);
    }
  };

  std::uint32_t extendChain(const RobotPlace& robot);
  /// Weighs a recall without image geometry by its distance from the one before it.
  void weighAfterLast(Constraint& recall);
  /// Odometry constraint from the pose at which the robot was placed to its present pose.
  Constraint drivenConstraint(const RobotPlace& robot) const;
  /// The same from the robot's frame, beside which it may have been placed.
  Constraint chainConstraint(const RobotPlace& robot) const;
  /// Covariance of the newest node, once the solver has reached an optimum.
  void takeCovariance();
  /// Covariance of any node, in a map to which nothing is added meanwhile.
  NodeCovariance covarianceAt(std::uint32_t node);
  NodeCovariance carried(const Constraint& constraint, const NodeCovariance& covariance) const;
  void setWeights(Constraint& constraint, const Eigen::Matrix4d& covariance) const;
  Constraint recallConstraint(std::uint32_t experience, double relative_rad,
                              const RecallGeometry* geometry) const;
  // Known ground (known_ground.cpp). The recalls are constraints that are not part of the graph.
  /// Whether a recall is on known ground, and so makes no node.
  bool onKnownGround(std::uint32_t experience, const Constraint& recall, const RobotPlace& robot) const;
  bool agrees(const Constraint& recall, const RobotPlace& robot) const;
  /// Whether a recall is to be ignored, because it alone disagrees with the place given by the recalls before.
  bool strayed(std::uint32_t experience, const Constraint& recall, const RobotPlace& robot);
  /// Uses a recall without making a node. @return the robot's place beside the experience
  RobotPlace pass(const Constraint& recall, const RobotPlace& robot);
  /// The robot's pose by odometry, in the axes of a node.
  Prediction predicted(const RobotPlace& robot, const MapPose& place) const;
  /// Covariance of the robot's pose relative to its frame, in the axes of the frame [m].
  NodeCovariance spreadBeside(const RobotPlace& robot, const Constraint& driven) const;
  /// The robot's motion since it was placed, in its axes at that time and the map's unit.
  UncertainPose drivenWay(const RobotPlace& robot) const;
  /// Continues the robot's pass up to a recall that agrees. If the pass is long enough, adds it as evidence.
  void goOn(Standing& standing, std::uint32_t to, const UncertainPose& seen, const RobotPlace& robot);

  void work(ExperienceGraph& graph, std::int64_t amount);
  /// Weighs the recalls anew if there are enough new ones. @return whether it did
  bool learnSpread();

  ExperienceMapParams params_;
  PoseGraph pose_graph_;
  PoseGraphSolver solver_;
  std::vector<std::uint32_t> nodes_;     ///< node of each experience
  std::vector<TemplateOffset> offsets_;  ///< of each experience
  std::vector<std::uint32_t> recalls_;   ///< of each experience, the number of recalls that made nodes
  RecallSpread spread_;
  PassEvidence evidence_;
  std::optional<std::uint32_t> beside_;  ///< node beside which the robot is placed, if it is
  std::uint32_t strays_ = 0;             ///< consecutive recalls that disagreed
  /// Node of the latest recall without image geometry.
  std::optional<std::uint32_t> vague_recall_;
  /// Covariance of the newest node, or of the node beside which the robot is placed.
  NodeCovariance newest_covariance_ = NodeCovariance::Zero();
  std::map<std::uint32_t, NodeCovariance> ground_;  ///< of the nodes beside which it has been placed
  std::vector<NodeCovariance> along_chain_;         ///< of each node (covarianceAt); empty if not computed
  bool recalled_ = false;  ///< the last action added evidence; after a mere creation nothing is left to solve
  /// Disagreement of recalls with the map that is still to be corrected [standard deviations of place].
  double disagreement_ = 0.0;
};

}  // namespace ratslam
