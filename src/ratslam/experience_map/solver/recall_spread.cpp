#include "ratslam/experience_map/solver/recall_spread.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/statistics.h"

namespace ratslam {
namespace {

constexpr double kLeastSpacing = 1e-6;      // below this distance the robot stood still [m]
constexpr std::size_t kLeastRecalls = 10;   // fewest recalls to learn from
constexpr double kFirstGuessCounts = 10.0;  // weight of the first guess, in recalls
constexpr double kMoreRecalls = 1.25;       // learn again when the number has grown by this factor
constexpr double kMoreSpacings = 1.1;       // take the median again when the number has grown by this factor
constexpr double kReach = 4.0 / 3.0;        // largest distance at which a place is recalled, in spacings
constexpr double kNoticeable = 0.05;  // least relative change of a spread for which recalls are weighed anew
constexpr double kGaussian = 1.4826;  // standard deviation / median absolute value
constexpr double kUniform = 0.28867513459481287;  // standard deviation / width
constexpr double kLeastFacing = 0.02;             // [rad]
// Least share of agreeing recalls; with fewer, errors of the map correlate the residuals.
constexpr double kLeastAgreeing = 0.9;

/// Length over which the errors' correlation falls to 1/e, from recalls no farther apart than `near`.
double correlatedLength(const std::vector<double>& errors, const std::vector<double>& apart, double near) {
  double squares = 0.0;
  double products = 0.0;
  double distance = 0.0;
  double pairs = 0.0;
  for (std::size_t k = 1; k < errors.size(); ++k) {
    if (apart[k] > near) continue;
    products += errors[k] * errors[k - 1];
    squares += 0.5 * (errors[k] * errors[k] + errors[k - 1] * errors[k - 1]);
    distance += apart[k];
    pairs += 1.0;
  }
  if (!(products > 0.0 && distance > 0.0)) return 0.0;
  // Less the standard error of the correlation of independent errors (Bartlett 1946).
  const double correlation = products / squares - 1.0 / std::sqrt(pairs);
  return correlation > 0.0 ? -distance / pairs / std::log(correlation) : 0.0;
}

}  // namespace

double RecallSpread::Component::effective(double guess, double apart) const {
  const double single = sigma > 0.0 ? sigma : guess;
  if (!(correlated > 0.0)) return single;
  const double correlation = std::exp(-apart / correlated);
  return std::clamp(shown * std::sqrt((1.0 + correlation) / (1.0 - correlation)), single,
                    std::max(guess, single));
}

bool RecallSpread::Component::learn(double guess, double least, const std::vector<double>& errors,
                                    const std::vector<double>& apart, double near) {
  const double seen = kGaussian * medianDeviation(errors, 0.0);
  shown = std::max(seen, least);
  const double count = static_cast<double>(errors.size());
  const double variance =
      (kFirstGuessCounts * guess * guess + count * seen * seen) / (kFirstGuessCounts + count);
  const Component before = *this;
  sigma = std::clamp(std::sqrt(variance), least, guess);
  correlated = correlatedLength(errors, apart, near);
  const double used = before.effective(guess, near);
  return std::abs(effective(guess, near) - used) > kNoticeable * used;
}

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
  const double along = along_.effective(place(), recall.apart);
  const double across = across_.effective(place(), recall.apart);
  recall.xy_weight = Eigen::Vector2d(1.0 / along, 1.0 / across).asDiagonal();
  recall.z_weight = 1.0 / up_.effective(place(), recall.apart);
  recall.yaw_weight = 1.0 / facing_.effective(first_facing_, recall.apart);
  // The kernel keeps its width in metres, whatever is learned.
  recall.doubt = place() / std::max(along, across);
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
  std::vector<double> apart;
  for (const Constraint& constraint : graph.constraints()) {
    if (!constraint.vague) continue;
    const Residual residual =
        PoseGraph::residual(constraint, graph.nodes()[constraint.from], graph.nodes()[constraint.to]);
    if (graph.weight(constraint, residual.squaredNorm()) < 0.5) continue;
    along.push_back(residual[0] / constraint.xy_weight(0, 0));
    across.push_back(residual[1] / constraint.xy_weight(1, 1));
    facing.push_back(residual[2] / constraint.yaw_weight);
    up.push_back(residual[4] / constraint.z_weight);
    apart.push_back(constraint.apart);
  }
  if (along.size() < kLeastRecalls) return false;
  // Where the map is wrong, its errors correlate the residuals; then the correlation of recalls is not learned.
  const bool agree = static_cast<double>(along.size()) >= kLeastAgreeing * static_cast<double>(vague);
  const double near = agree ? place() : 0.0;
  const double least = kUniform / kReach * place();
  const bool changes[] = {along_.learn(place(), least, along, apart, near),
                          across_.learn(place(), least, across, apart, near),
                          up_.learn(place(), least, up, apart, near),
                          facing_.learn(first_facing_, kLeastFacing, facing, apart, near)};
  return std::any_of(std::begin(changes), std::end(changes), [](bool changed) { return changed; });
}

}  // namespace ratslam
