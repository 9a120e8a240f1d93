// What a belief over places claims.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "ratslam/local_view/recall/along_way.h"
#include "ratslam/local_view/recall/place_belief.h"

namespace ratslam {
namespace {

constexpr int kClaimLinks = 2;
constexpr double kClaimNovelty = 1.0;  // views that add up to less tell their places hardly apart
// The next place on the way may be meant as well if it has this share of what the most believed one has.
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
  // Several places of one stretch of road, learned before the robot knew that it was there again, share the belief.
  const std::optional<PlaceMass> next = onTheWay();
  if (next && claim.confidence <= kClaim && next->mass >= kPlausible * most.mass) {
    claim.place = next->place;
    claim.confidence = std::max(claim.confidence, 1.0 - unknown_);
  }
  if (measured_ && claim.confidence > kClaim) claim.ahead = aheadOf(claim.place, likeness);
  double sum = 0.0;
  for (std::size_t v = 0; v < likeness.variants; ++v) {
    const double z = spread.standardised(likeness.row(v)[claim.place]);
    claim.variant_weights.push_back(std::exp(z));
    sum += claim.variant_weights.back();
  }
  for (double& weight : claim.variant_weights) weight /= sum;
  return claim;
}

/// The nearest places before and after one on the ways driven; only such as the robot may be at.
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

/// How far ahead of a place the robot is by the places learned before and after it: at most as far as half the way beyond
/// the next one, since belief lags behind what the last view shows.
double PlaceBelief::aheadOf(std::uint32_t place, const ViewLikeness& likeness) const {
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
                                         {after->distance, believed(after->place)});
}

/// The most believed of the places that are on the way from the known one where the robot was when it saw the last view;
/// none where dead reckoning does not say how well it knows: what looks alike elsewhere would not be excluded.
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

/// What is believed of one place.
double PlaceBelief::massOf(std::uint32_t place) const {
  const auto found = std::lower_bound(active_.begin(), active_.end(), PlaceMass{place, 0.0}, byPlace);
  return found != active_.end() && found->place == place ? found->mass : 0.0;
}

}  // namespace ratslam
