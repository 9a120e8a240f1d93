/// The streets of a town as a field over the ground plane: distance to the nearest road axis, and height of the ground.
///
/// The road is everything within a fixed distance of a road axis, so crossings, and places where a drive
/// comes back beside its earlier track, join by themselves, and whatever keeps its distance from all axes is
/// never on the road. Heights blend those of all axes nearby by inverse distance (Shepard 1968, regularised):
/// w = (d^2 + r^2)^-3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ratslam {

/// A point of the ground plane (x right, z forward, as in the world) and the height of the ground there [m].
struct RoadPoint {
  double x = 0.0;
  double z = 0.0;
  double height = 0.0;  ///< up
};

/// A road axis, resampled to equal steps.
struct RoadAxis {
  static constexpr double kStep = 0.5;  ///< [m]
  struct Sample {
    double x, z, height;
    double forward_x, forward_z;  ///< direction, of length 1
    /// No axis has passed within 5 m before, not counting the last 40 m of this one.
    bool first_visit;
  };
  std::vector<Sample> samples;
  double length() const { return kStep * static_cast<double>(samples.size() - 1); }
};

class RoadField {
 public:
  static constexpr double kFar = 24.0;  ///< distances are capped at this [m]

  /// @param roads road axes as polylines; each needs at least two points and some length.
  /// @throws std::invalid_argument if one does not have them or is not finite.
  explicit RoadField(const std::vector<std::vector<RoadPoint>>& roads);

  const std::vector<RoadAxis>& axes() const { return axes_; }
  /// Distance to the nearest road axis [m], at most kFar.
  double distance(double x, double z) const;
  /// Height of the road surface at, or of the ground near, a place [m].
  double height(double x, double z) const;

  double xMin() const { return x_min_; }
  double xMax() const { return x_max_; }
  double zMin() const { return z_min_; }
  double zMax() const { return z_max_; }
  /// Ground is modelled up to this far beyond the outermost axis [m].
  static constexpr double kMargin = 180.0;

 private:
  struct Place {
    float x, z;
    std::uint32_t axis, sample;
  };
  using Bucket = std::vector<Place>;
  /// Visits the buckets within `reach` of a place, nearer rings first.
  template <class Visit>
  void visitBuckets(double x, double z, const double& reach, Visit&& visit) const;
  void addAxis(const std::vector<RoadPoint>& points);
  void findFirstVisits();
  void tabulateHeights();

  std::vector<RoadAxis> axes_;
  std::vector<Bucket> buckets_;  ///< axis samples by 8 m squares, row by row
  int bucket_columns_ = 0, bucket_rows_ = 0;
  double x_min_ = 0.0, x_max_ = 0.0, z_min_ = 0.0, z_max_ = 0.0;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<float> heights_;  ///< on a 4 m lattice
};

}  // namespace ratslam
