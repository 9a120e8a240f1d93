#include "ratslam/experience_map/solver/recall_spread.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kLeastSpacing = 1e-6;      // below this distance the robot stood still [m]
constexpr std::size_t kLeastRecalls = 10;   // fewest recalls to learn from
constexpr double kFirstGuessCounts = 10.0;  // weight of the first guess, in recalls
constexpr double kMoreRecalls = 1.25;       // learn again when the number has grown by this factor
constexpr double kMoreSpacings = 1.1;       // take the median again when the number has grown by this factor
constexpr double kReach = 4.0 / 3.0;        // largest distance at which a place is recalled, in spacings
constexpr double kNoticeable = 0.05;        // relative change of a spread from which recalls are weighed anew
constexpr double kGaussian = 1.4826;        // standard deviation / median absolute value
constexpr double kUniform = 0.28867513459481287;  // standard deviation / width
constexpr double kLeastFacing = 0.02;             // [rad]

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double joined(double guess, const std::vector<double>& sizes, double least) {
  const double seen = kGaussian * median(sizes);
  const double count = static_cast<double>(sizes.size());
  const double variance =
      (kFirstGuessCounts * guess * guess + count * seen * seen) / (kFirstGuessCounts + count);
  return std::clamp(std::sqrt(variance), least, guess);
}

}  // namespace

RecallSpread::RecallSpread(double place, double facing)
    : fixed_(place > 0.0), first_place_(place), first_facing_(facing) {}

void RecallSpread::addSpacing(double length) {
  if (fixed_ || !(length > kLeastSpacing)) return;
  spacings_.push_back(length);
  if (static_cast<double>(spacings_.size()) < kMoreSpacings * static_cast<double>(counted_at_)) return;
  counted_at_ = spacings_.size();
  spacing_ = kReach * median(spacings_);
}

void RecallSpread::weigh(Constraint& recall) const {
  const double along = along_ > 0.0 ? along_ : place();
  const double across = across_ > 0.0 ? across_ : place();
  recall.xy_weight = Eigen::Vector2d(1.0 / along, 1.0 / across).asDiagonal();
  recall.z_weight = 1.0 / (up_ > 0.0 ? up_ : place());
  // Learning sharpens the recalls that agree. The kernel keeps its width in metres.
  recall.doubt = std::max(place() / std::max(along, across), 1.0);
  recall.yaw_weight = 1.0 / (facing_ > 0.0 ? facing_ : first_facing_);
}

bool RecallSpread::learn(const PoseGraph& graph) {
  if (fixed_) return false;
  std::vector<double> along;
  std::vector<double> across;
  std::vector<double> up;
  std::vector<double> facing;
  std::size_t vague = 0;
  for (const Constraint& constraint : graph.constraints()) {
    if (!constraint.vague) continue;
    ++vague;
  }
  if (vague < kLeastRecalls || static_cast<double>(vague) < kMoreRecalls * static_cast<double>(learned_at_)) {
    return false;
  }
  learned_at_ = vague;
  for (const Constraint& constraint : graph.constraints()) {
    if (!constraint.vague) continue;
    const Residual residual =
        PoseGraph::residual(constraint, graph.nodes()[constraint.from], graph.nodes()[constraint.to]);
    if (graph.weight(constraint, residual.squaredNorm()) < 0.5) continue;
    along.push_back(std::abs(residual[0]) / constraint.xy_weight(0, 0));
    across.push_back(std::abs(residual[1]) / constraint.xy_weight(1, 1));
    facing.push_back(std::abs(residual[2]) / constraint.yaw_weight);
    up.push_back(std::abs(residual[4]) / constraint.z_weight);
  }
  if (along.size() < kLeastRecalls) return false;
  const double least = kUniform / kReach * place();
  const auto update = [](double& value, double before, double now) {
    const bool changed = std::abs(now - before) > kNoticeable * before;
    value = now;
    return changed;
  };
  const auto known = [](double value, double guess) { return value > 0.0 ? value : guess; };
  const bool changes[] = {
      update(along_, known(along_, place()), joined(place(), along, least)),
      update(across_, known(across_, place()), joined(place(), across, least)),
      update(up_, known(up_, place()), joined(place(), up, least)),
      update(facing_, known(facing_, first_facing_), joined(first_facing_, facing, kLeastFacing))};
  return std::any_of(std::begin(changes), std::end(changes), [](bool changed) { return changed; });
}

}  // namespace ratslam
