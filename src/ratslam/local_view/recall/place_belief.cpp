#include "ratslam/local_view/recall/place_belief.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

constexpr double kSharpness =
    0.7;  // evidence per unit of z; small, because wrong places can also have a large z
constexpr double kChance = 6.0;  // wrong places exceed this z for one view in a hundred only
constexpr double kBeyond = 1.0;  // evidence per square of z - kChance
// The z of a place not yet known, if odometry measures the motion: the z of the most similar path through wrong places
// (mean over ten views: KITTI 00 2.4, synthetic towns 2.7, Nordland 2.3). It may be large, because the robot knows its
// position by odometry meanwhile, and a false recall would bend its map.
constexpr double kUnknownZ = 2.5;
// The same if each image counts as one step, so that only recalls tell the position, or if the robot was at a known
// place at the last view. With a larger z known places would be learned again whenever the view differs a little.
constexpr double kUnknownZToStay = 0.8;
constexpr double kLeave = 0.0005;       // probability per view to leave the known paths
constexpr double kAnywhere = 1e-4;      // probability per view that an unknown place is a known one
constexpr double kElsewhere = 0.01;     // probability to wake up at a place not yet known
constexpr double kLaneChange = 0.02;    // share of the belief in variants that is forgotten per view
constexpr double kBlur = 0.4;           // relative difference in length between the path now and then
constexpr double kRelativeError = 0.1;  // relative error of the distance by an odometry without covariance
constexpr double kLeastError = 0.03;    // the same for any odometry: covariances leave out systematic errors
constexpr double kTurnError = 0.1;      // error of the heading / sum of all turns, without covariance
constexpr double kLeastTurnError = 0.01;  // the same for any odometry
constexpr double kOtherView =
    M_PI / 4;                           // turned by more, a camera that looks ahead sees something else [rad]
constexpr double kVeto = 4.0;           // distance from which a place is excluded [standard deviations]
constexpr double kVetoSpacings = 2.0;   // allowance in addition [distances between places]
constexpr std::size_t kFollowed = 128;  // number of places per view at which belief may begin
constexpr std::size_t kFewest = 20;     // with fewer places the spread of the likeness is not known
constexpr std::size_t kJustLearned = 10;  // number of newest places that are no candidates
constexpr double kStillLikeness = 2.0;    // with a larger z the robot has only just left a place
constexpr double kMostExponent = 300.0;   // of a likelihood ratio; all of them are divided if one is larger
constexpr double kPruned = 1e-3;  // belief below this share of a place's belief by "anywhere" is dropped

/// Logarithm of the likelihood ratio of a view with this z: at the place against anywhere. It is small, because the
/// likeness of consecutive views is correlated.
double evidence(double z) { return kSharpness * z; }

/// Additional evidence of a likeness beyond chance. By chance z is normally distributed, hence the square.
double evidenceBeyondChance(double z) {
  const double beyond = std::max(z - kChance, 0.0);
  return kBeyond * beyond * beyond;
}

/// Second integral of a box distribution of half-width `blur` about 0.
double ramp(double x, double blur) {
  if (x <= -blur) return 0.0;
  if (x >= blur) return x;
  return (x + blur) * (x + blur) / (4.0 * blur);
}

/// Probability of the interval [begin, end] for a position that is uniform on [0, length] plus a uniform error of up to
/// `blur`.
double shareBetween(double begin, double end, double length, double blur) {
  return std::max(ramp(end, blur) - ramp(end - length, blur) - ramp(begin, blur) + ramp(begin - length, blur),
                  0.0) /
         length;
}

/// The largest likeness of a place over all variants of the view.
float likest(const ViewLikeness& likeness, std::size_t place) {
  float largest = likeness.row(0)[place];
  for (std::size_t v = 1; v < likeness.variants; ++v) largest = std::max(largest, likeness.row(v)[place]);
  return largest;
}

}  // namespace

PlaceBelief::Spread PlaceBelief::spreadOf(const ViewLikeness& likeness) {
  const float* row = likeness.row(0);
  const double count = static_cast<double>(likeness.places);
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < likeness.places; ++i) {
    const double value = static_cast<double>(row[i]);
    sum += value;
    squares += value * value;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(squares / count - mean * mean, 1e-12))};
}

void PlaceBelief::move(const ViewMotion& motion, double novelty) {
  novelty_ = novelty;
  measured_ = !motion.assumed;
  here_.heading += motion.rotation;
  here_.turned += std::abs(motion.rotation);
  here_.x += motion.forward * std::cos(here_.heading);
  here_.y += motion.forward * std::sin(here_.heading);
  here_.way += std::abs(motion.forward);
  const double by_default = kRelativeError * std::abs(motion.forward);
  // For an odometry without covariance, excluded() uses a share of the distance driven.
  if (motion.forward_variance) here_.forward_variance += *motion.forward_variance;
  if (motion.yaw_variance) here_.yaw_variance += *motion.yaw_variance;
  here_.epoch = motion.epoch;
  step_ = std::abs(motion.forward);
  since_arrival_ += motion.forward;
  novelty_since_arrival_ += novelty;
  const double measured = motion.forward_variance ? std::sqrt(*motion.forward_variance) : by_default;
  const double sigma = std::max(measured, motion.unmeasured);
  if (motion.unmeasured > 0.0) leave();
  added_.clear();
  for (const PlaceMass& from : active_) handOn(from, motion.forward, sigma);
  unknown_ += kLeave * novelty_ * (1.0 - unknown_);
  collect(graph_.size());
}

/// Moves the belief in one place along its links. Belief that would pass their end goes to the place not yet known.
void PlaceBelief::handOn(const PlaceMass& from, double driven, double sigma) {
  const double mass = (1.0 - kLeave * novelty_) * from.mass;
  // A place stands for the stretch of path up to the next place. The position on it is unknown.
  const double least = std::max(std::abs(driven), 1e-9);
  const double length = graph_.stretch(from.place, least, candidates_);
  const double blur = std::max(kBlur * std::abs(driven), sigma) + 1e-9;
  graph_.around(from.place, std::max(blur - driven, 0.0), std::max(driven + length + blur, 0.0), around_);
  double sum = 0.0;
  for (PlaceAhead& ahead : around_) {
    const double begin = ahead.distance - driven;
    const double end = begin + graph_.stretch(ahead.place, least, candidates_);
    ahead.distance = ahead.place < candidates_ ? shareBetween(begin, end, length, blur) : 0.0;
    sum += ahead.distance;
  }
  const double scale = mass / std::max(sum, 1.0);
  unknown_ += mass * std::max(1.0 - sum, 0.0);
  for (const PlaceAhead& ahead : around_) {
    if (ahead.distance > 0.0) added_.push_back({ahead.place, scale * ahead.distance});
  }
}

/// Sums the entries of added_ by place into active_, in ascending order.
void PlaceBelief::collect(std::size_t places) {
  std::stable_sort(added_.begin(), added_.end(),
                   byPlace);  // a fixed order of equal places fixes the bits of sums
  active_.clear();
  const double least = kPruned * kAnywhere / static_cast<double>(std::max<std::size_t>(places, 1));
  for (std::size_t i = 0; i < added_.size();) {
    PlaceMass sum{added_[i].place, 0.0};
    for (; i < added_.size() && added_[i].place == sum.place; ++i) sum.mass += added_[i].mass;
    if (sum.mass >= least) {
      active_.push_back(sum);
    } else {
      unknown_ += sum.mass;
    }
  }
  added_.clear();
}

bool PlaceBelief::excluded(std::uint32_t place) const {
  if (!wayIsMeasured(place)) return false;
  const PlaceVisit& then = graph_.lastVisit(place);
  if (!all_round_ && facesElsewhere(then)) return true;
  const double way = here_.way - then.way;
  const double said = here_.forward_variance - static_cast<double>(then.forward_variance) +
                      (here_.yaw_variance - static_cast<double>(then.yaw_variance)) * way * way / 3.0;
  const double share = here_.forward_variance > 0.0 ? kLeastError : kRelativeError;
  const double sigma = std::sqrt(std::max(said, 0.0) + share * share * way * way);
  const double apart =
      std::hypot(static_cast<double>(then.x) - here_.x, static_cast<double>(then.y) - here_.y);
  return apart > kVeto * sigma + kVetoSpacings * graph_.spacing(place);
}

bool PlaceBelief::facesElsewhere(const PlaceVisit& then) const {
  const double said = here_.yaw_variance - static_cast<double>(then.yaw_variance);
  const double unsaid = (here_.yaw_variance > 0.0 ? kLeastTurnError : kTurnError) *
                        (here_.turned - static_cast<double>(then.turned));
  const double sigma = std::sqrt(std::max(said, 0.0) + unsaid * unsaid);
  const double turned = std::abs(wrapAngle(here_.heading - static_cast<double>(then.heading)));
  return turned > kVeto * sigma + kOtherView;
}

std::size_t PlaceBelief::leftBehind(const ViewLikeness& likeness) const {
  const std::size_t before = std::min<std::size_t>(before_, likeness.places);
  if (likeness.places <= kJustLearned) return before;
  const Spread spread = spreadOf(likeness);
  const auto still = [&](std::size_t place) {
    return spread.standardised(likest(likeness, place)) > kStillLikeness;
  };
  std::size_t end = likeness.places;
  double learned = 0.0;  // length of the path on which the places from `end` on were learned
  const auto left_long_ago = [&](std::size_t index) {
    const auto place = static_cast<std::uint32_t>(index);
    const PlaceVisit& visit = graph_.lastVisit(place);
    learned += std::max(static_cast<double>(visit.to_next), 0.0);
    const double elsewhere = here_.way - visit.way - learned;
    return elsewhere > static_cast<double>(kJustLearned) * std::max(graph_.spacing(place), step_);
  };
  while (end > before && !left_long_ago(end - 1) && (end + kJustLearned > likeness.places || still(end - 1)))
    --end;
  return end;
}

void PlaceBelief::seedEverywhere(std::size_t candidates) {
  for (std::size_t place = 0; place < candidates; ++place) {
    added_.push_back(
        {static_cast<std::uint32_t>(place), (1.0 - kElsewhere) / static_cast<double>(candidates)});
  }
  unknown_ = kElsewhere;
}

/// Moves a share of the belief in a place not yet known to the most similar places.
void PlaceBelief::seed(const ViewLikeness& likeness, std::size_t candidates) {
  std::vector<std::pair<float, std::uint32_t>> best;  // a heap with the least similar one first
  const auto more = [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  };
  for (std::size_t place = 0; place < candidates; ++place) {
    const std::pair<float, std::uint32_t> next{likest(likeness, place), static_cast<std::uint32_t>(place)};
    if (best.size() == kFollowed && !more(next, best.front())) continue;
    if (best.size() == kFollowed) {
      std::pop_heap(best.begin(), best.end(), more);
      best.pop_back();
    }
    best.push_back(next);
    std::push_heap(best.begin(), best.end(), more);
  }
  const double each = unknown_ * kAnywhere / static_cast<double>(candidates);
  for (const auto& [value, place] : best) {
    if (excluded(place)) continue;
    added_.push_back({place, each});
    unknown_ -= each;
  }
}

std::optional<PlaceClaim> PlaceBelief::weigh(const ViewLikeness& likeness, std::size_t candidates) {
  if (variants_.size() != likeness.variants) {
    variants_ = likeness.priors;
  }
  added_ = active_;
  if (candidates < kFewest) candidates = 0;
  candidates_ = candidates;
  for (PlaceMass& mass : added_) {
    if (mass.place < candidates && !excluded(mass.place)) continue;
    unknown_ += mass.mass;
    mass.mass = 0.0;
  }
  if (candidates > 0) {
    if (waking_) {
      seedEverywhere(candidates);
    } else {
      seed(likeness, candidates);
    }
    waking_ = false;
  }
  collect(likeness.places);
  const Spread spread = likeness.places > 0 ? spreadOf(likeness) : Spread{};
  std::vector<double> of_variants(likeness.variants, 0.0);
  std::vector<double> exponents;
  for (const PlaceMass& mass : active_) {
    const bool vouched_for = deadReckoningKnows(mass.place);
    for (std::size_t v = 0; v < likeness.variants; ++v) {
      const double z = spread.standardised(likeness.row(v)[mass.place]);
      exponents.push_back(novelty_ * (evidence(z) + (vouched_for ? 0.0 : evidenceBeyondChance(z))));
    }
  }
  // A place unlike all others has a z as large as the root of their number, whose exponential no double holds.
  double shift = 0.0;
  for (const double exponent : exponents) shift = std::max(shift, exponent - kMostExponent);
  double sum = 0.0;
  auto exponent = exponents.begin();
  for (PlaceMass& mass : active_) {
    double weighed = 0.0;
    for (std::size_t v = 0; v < likeness.variants; ++v) {
      const double share = mass.mass * variants_[v] * std::exp(*exponent++ - shift);
      of_variants[v] += share;
      weighed += share;
    }
    mass.mass = weighed;
    sum += weighed;
  }
  const bool may_stay = !measured_ || atKnownPlace();
  unknown_ *= std::exp(novelty_ * evidence(may_stay ? kUnknownZToStay : kUnknownZ) - shift);
  sum += unknown_;
  for (std::size_t v = 0; v < likeness.variants; ++v) {
    const double believed = (of_variants[v] + unknown_ * variants_[v]) / sum;
    variants_[v] = (1.0 - kLaneChange) * believed + kLaneChange * likeness.priors[v];
  }
  for (PlaceMass& mass : active_) mass.mass /= sum;
  unknown_ /= sum;
  return claim(likeness, spread);
}

/// Whether odometry has measured the way from a place's last visit until now without a break.
bool PlaceBelief::wayIsMeasured(std::uint32_t place) const {
  return measured_ && graph_.lastVisit(place).epoch == here_.epoch;
}

/// Whether odometry has measured that way and states its covariance.
bool PlaceBelief::deadReckoningKnows(std::uint32_t place) const {
  return here_.forward_variance > 0.0 && here_.yaw_variance > 0.0 && wayIsMeasured(place);
}

void PlaceBelief::arrive(std::uint32_t place, bool learns) {
  const bool is_new = place == graph_.size();
  if (is_new) graph_.add();
  graph_.visit(place, here_);
  if (at_ == place) return;
  // Known places have their links already. More links between them would only blur the belief.
  if (at_ && learns && (is_new || at_new_)) graph_.link(*at_, place, since_arrival_, novelty_since_arrival_);
  at_ = place;
  at_new_ = is_new;
  since_arrival_ = novelty_since_arrival_ = 0.0;
}

void PlaceBelief::leave() {
  at_.reset();
  since_arrival_ = novelty_since_arrival_ = 0.0;
}

void PlaceBelief::wakeUp() {
  active_.clear();
  waking_ = true;
  before_ = static_cast<std::uint32_t>(graph_.size());
  unknown_ = 1.0;
  variants_.clear();
  leave();
  ++here_.epoch;
}

std::vector<PlaceMass> PlaceBelief::strongest(std::size_t count) const {
  std::vector<PlaceMass> sorted = active_;
  count = std::min(count, sorted.size());
  std::partial_sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count), sorted.end(),
                    [](const PlaceMass& a, const PlaceMass& b) {
                      return a.mass != b.mass ? a.mass > b.mass : a.place < b.place;
                    });
  sorted.resize(count);
  return sorted;
}

std::size_t PlaceBelief::memoryBytes() const {
  return graph_.memoryBytes() + active_.capacity() * sizeof(PlaceMass);
}

}  // namespace ratslam
