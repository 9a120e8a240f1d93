// The claim of a belief over places.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "ratslam/local_view/recall/along_way.h"
#include "ratslam/local_view/recall/place_belief.h"

namespace ratslam {
namespace {

constexpr int kClaimLinks = 2;
constexpr double kClaimNovelty = 1.0;  // with less novelty between them two places have nearly the same view
// A place on the robot's way can be claimed instead of the most likely one if it has at least this share of its belief.
constexpr double kPlausible = 0.05;

}  // namespace

std::optional<PlaceClaim> PlaceBelief::claim(const ViewLikeness& likeness, const Spread& spread) const {
  if (active_.empty()) return std::nullopt;
  const auto less = [](const PlaceMass& a, const PlaceMass& b) { return a.mass < b.mass; };
  PlaceClaim claim;
  const PlaceMass most = *std::max_element(active_.begin(), active_.end(), less);
  claim.place = most.place;
  std::vector<std::uint32_t> near;
  graph_.within(claim.place, kClaimLinks, kClaimNovelty, near);
  for (const std::uint32_t place : near) claim.confidence += massOf(place);
  // If a road was learned twice, before the robot recalled it, its places share the belief. Continuity decides then.
  const std::optional<PlaceMass> next = onTheWay();
  if (next && claim.confidence <= kClaim && next->mass >= kPlausible * most.mass) {
    claim.place = next->place;
    claim.confidence = std::max(claim.confidence, 1.0 - unknown_);
  }
  if (measured_ && claim.confidence > kClaim) claim.ahead = aheadOf(claim.place, likeness, spread.mean);
  double sum = 0.0;
  for (std::size_t v = 0; v < likeness.variants; ++v) {
    const double z = spread.standardised(likeness.row(v)[claim.place]);
    claim.variant_weights.push_back(std::exp(z));
    sum += claim.variant_weights.back();
  }
  for (double& weight : claim.variant_weights) weight /= sum;
  return claim;
}

/// The nearest candidates before and after a place along its links.
std::pair<std::optional<PlaceAhead>, std::optional<PlaceAhead>> PlaceBelief::neighbours(
    std::uint32_t place) const {
  std::vector<PlaceAhead> near;
  graph_.around(place, 0.0, 0.0, near);
  std::optional<PlaceAhead> before;
  std::optional<PlaceAhead> after;
  for (const PlaceAhead& next : near) {
    if (next.place >= candidates_) continue;
    if (next.distance < 0.0 && (!before || next.distance > before->distance)) before = next;
    if (next.distance > 0.0 && (!after || next.distance < after->distance)) after = next;
  }
  return {before, after};
}

/// Distance of the robot ahead of a place, from the likeness of its neighbours. It can pass the next place by half the
/// distance to the one after it, because belief lags behind the last view.
double PlaceBelief::aheadOf(std::uint32_t place, const ViewLikeness& likeness, double faded) const {
  const auto believed = [&](std::uint32_t at) {
    double sum = 0.0;
    for (std::size_t v = 0; v < likeness.variants; ++v) {
      sum += variants_[v] * static_cast<double>(likeness.row(v)[at]);
    }
    return sum;
  };
  PlaceAhead likest{place, 0.0};
  auto [before, after] = neighbours(place);
  for (const auto& next : {before, after}) {
    if (next && believed(next->place) > believed(likest.place)) likest = *next;
  }
  if (likest.place != place) std::tie(before, after) = neighbours(likest.place);
  if (!before || !after) return 0.0;
  return likest.distance + likestBetween({before->distance, believed(before->place)}, believed(likest.place),
                                         {after->distance, believed(after->place)}, faded);
}

/// The most likely place among those that the robot can reach from the known place of the last view. None unless dead
/// reckoning vouches for it: otherwise similar places elsewhere would not have been excluded.
std::optional<PlaceMass> PlaceBelief::onTheWay() const {
  if (!atKnownPlace() || *at_ >= candidates_) return std::nullopt;
  const double reach = graph_.stretch(*at_, std::max(step_, 1e-9), candidates_) + 2.0 * step_;
  if (std::abs(since_arrival_) > reach) return std::nullopt;
  std::vector<PlaceAhead> near;
  graph_.around(*at_, reach, reach, near);
  std::optional<PlaceMass> best;
  for (const PlaceAhead& ahead : near) {
    const PlaceMass mass{ahead.place, massOf(ahead.place)};
    if (mass.mass > (best ? best->mass : 0.0) && deadReckoningKnows(ahead.place)) best = mass;
  }
  return best;
}

/// The belief in one place.
double PlaceBelief::massOf(std::uint32_t place) const {
  const auto found = std::lower_bound(active_.begin(), active_.end(), PlaceMass{place, 0.0}, byPlace);
  return found != active_.end() && found->place == place ? found->mass : 0.0;
}

}  // namespace ratslam
