/// OpenRatSLAM's relaxation, equation (6), in the reference arithmetic of docs/model.md.
///
/// Each sweep visits experiences by id and their outgoing links by age. Let l be the position of the link's end
/// by the measured link. The start moves by alpha (end - l), the end by the opposite; then the two facings move
/// in the same way. All links have the same weight.
///
/// Facings do not depend on positions. So each block of links is processed in three passes:
///  1. turn: update the facings of the ends, which gives the directions of the links;
///  2. compute the sines and cosines of the block together (sine_cosine.h), unless all directions are the same
///     as at the last sweep, as in a map at rest;
///  3. move the ends.
/// One block is moved while the next one is turned: each is a chain of dependent operations, and a processor
/// can execute two such chains at the same time.
#pragma once

#include <cstddef>
#include <vector>

#include "ratslam/experience_map/solver/map_solver.h"
#include "ratslam/simd/sine_cosine.h"

namespace ratslam {

class Relaxation : public MapSolver {
 public:
  /// @param sweeps per update. @param correction alpha of equation (6).
  Relaxation(int sweeps, double correction, SimdLevel level = bestSimdLevel())
      : sweeps_(sweeps), correction_(correction), sines_cosines_(sinesCosinesFor(level)) {}

  MapPose framePose(const ExperienceGraph& graph, std::uint32_t frame) const override;
  std::uint32_t frameOf(std::uint32_t experience) const override { return experience; }
  std::size_t frames() const override { return facings_.size(); }
  RobotPlace create(const ExperienceGraph& graph, const RobotPlace& robot,
                    const RecallGeometry* geometry) override;
  std::optional<RobotPlace> recall(const ExperienceGraph& graph, std::uint32_t experience,
                                   const RobotPlace& robot, double relative_rad,
                                   const RecallGeometry* geometry) override;

  /// Does the sweeps. The robot keeps its heading in the map.
  void update(ExperienceGraph& graph, RobotPlace& robot) override;
  void resume(ExperienceGraph&) override {}
  void settle(ExperienceGraph&) override {}

  /// Nothing is saved: everything follows from the graph.
  void save(State&) const override {}
  void load(const State&) override;

 private:
  static constexpr std::size_t kBlock = 64;

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
  struct Block {  ///< of links
    std::size_t begin = 0;
    std::size_t count = 0;
  };
  struct Turning;
  struct Moving;

  void takeNewLinks(const ExperienceGraph& graph);
  void sweep();
  void turnAndMove(const Block& turned, const Block& moved);

  int sweeps_;
  double correction_;
  SinesCosines sines_cosines_;
  std::size_t links_taken_ = 0;
  std::vector<Spring> springs_;     ///< by id of the start, then by age
  std::vector<double> directions_;  ///< of the links in the map, at the last sweep
  std::vector<double> sines_;       ///< of the directions
  std::vector<double> cosines_;
  std::vector<Place> places_;    ///< of the experiences
  std::vector<double> facings_;  ///< of the experiences
};

}  // namespace ratslam
