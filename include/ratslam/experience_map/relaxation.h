/// OpenRatSLAM's relaxation, equation (6), in the reference arithmetic of MODEL.
///
/// Each sweep visits experiences by id and their outgoing links by age. With l = where the link says its end
/// should be, both ends move by alpha (end - l), start towards, end back; then the facings likewise. All
/// links count the same.
///
/// The links are kept in one array in the order of their visits. Most of a sweep's time goes into the sine
/// and cosine of each link's direction, which have to be the library's to the last bit. They are kept with
/// the direction they belong to: where the map is at rest, directions stay what they were.
#pragma once

#include <limits>
#include <vector>

#include "ratslam/common/pose2.h"
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
    double direction =
        std::numeric_limits<double>::quiet_NaN();  ///< of the link in the map when last visited
    double along_x = 0.0;                          ///< the link's vector in that direction
    double along_y = 0.0;
  };

  void takeNewLinks(const ExperienceGraph& graph);
  void relax(Spring& spring, Pose2& start, Pose2& end) const;

  int sweeps_;
  double correction_;
  std::size_t links_taken_ = 0;
  std::vector<Spring> springs_;  ///< by id of the start, then by age
  std::vector<Pose2> places_;    ///< of the experiences
};

}  // namespace ratslam
