/// OpenRatSLAM's relaxation, equation (6), in the reference arithmetic of MODEL.
///
/// Each sweep visits experiences by id and their outgoing links by age. With l = where the link says its end
/// should be, both ends move by alpha (end - l), start towards, end back; then the facings likewise. All
/// links count the same.
///
/// The facings do not depend on the places, so a sweep runs in three passes - facings, sines and cosines of
/// all link directions, places - each a dependency chain of a few additions instead of one that holds a sine
/// per link. Every number is the result of the same operations on the same operands as in the plain order.
#pragma once

#include <vector>

#include "ratslam/experience_map/map_solver.h"

namespace ratslam {

class Relaxation : public MapSolver {
 public:
  /// @param sweeps per update. @param correction alpha of equation (6).
  Relaxation(int sweeps, double correction) : sweeps_(sweeps), correction_(correction) {}

  MapPose framePose(const ExperienceGraph& graph, std::uint32_t frame) const override;
  std::uint32_t frameOf(std::uint32_t experience) const override { return experience; }
  RobotPlace create(const ExperienceGraph& graph, const RobotPlace& robot,
                    const RecallGeometry* geometry) override;
  RobotPlace recall(const ExperienceGraph& graph, std::uint32_t experience, const RobotPlace& robot,
                    double relative_rad, const RecallGeometry* geometry) override;

  /// Sweeps. The robot keeps the heading it had in the map before them.
  void update(ExperienceGraph& graph, RobotPlace& robot) override;
  void resume(ExperienceGraph&) override {}
  void settle(ExperienceGraph&) override {}

 private:
  struct Spring {  ///< a link, in the order in which sweeps visit it
    std::uint32_t from;
    std::uint32_t to;
    double distance;
    double heading_rad;
    double facing_rad;
  };

  struct Place {
    double x;
    double y;
  };

  void takeNewLinks(const ExperienceGraph& graph);
  void sweepFacings();
  void sweepPlaces();

  int sweeps_;
  double correction_;
  std::size_t links_taken_ = 0;
  std::vector<Spring> springs_;     ///< by id of the start, then by age
  std::vector<double> directions_;  ///< of each spring in the map, in the running sweep [rad]
  std::vector<char> stale_;         ///< whether the direction has changed since the sweep before
  std::vector<Place> ends_;         ///< displacement along each spring in the map, in the running sweep [m]
  std::vector<double> facings_;     ///< of the experiences [rad]
  std::vector<Place> places_;       ///< of the experiences
};

}  // namespace ratslam
