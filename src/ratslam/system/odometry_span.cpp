#include "ratslam/system/odometry_span.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ratslam {
namespace {

constexpr double kOneClock = 1.0;  // largest distance of the begins and ends of streams with one clock [s]

std::string secondsText(double seconds) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f s", seconds);
  return text;
}

}  // namespace

void OdometrySpan::addOdometry(Stamp stamp) {
  first_ = first_ ? std::min(*first_, stamp) : stamp;
  last_ = last_ ? std::max(*last_, stamp) : stamp;
}

std::size_t OdometrySpan::viewsOutside() const {
  if (!first_) return views_.size();
  return static_cast<std::size_t>(std::count_if(
      views_.begin(), views_.end(), [this](Stamp view) { return view < *first_ || view > *last_; }));
}

std::optional<std::string> OdometrySpan::complaint() const {
  const std::size_t outside = viewsOutside();
  if (outside == 0) return std::nullopt;
  const std::string many = std::to_string(outside) + " of " + std::to_string(views_.size()) +
                           " images lie outside the odometry's time: ";
  if (!first_) return many + "there is no odometry at all";
  const auto [first_view, last_view] = std::minmax_element(views_.begin(), views_.end());
  const double begins_later = secondsBetween(*first_view, *first_);
  const double ends_later = secondsBetween(*last_view, *last_);
  if (std::min(begins_later, ends_later) > kOneClock)
    return many + "it is " + secondsText(begins_later) + " ahead";
  if (std::max(begins_later, ends_later) < -kOneClock) {
    return many + "it is " + secondsText(-begins_later) + " behind";
  }
  std::string edges;
  if (begins_later > 0.0) edges = "it begins " + secondsText(begins_later) + " after them";
  if (ends_later < 0.0) {
    edges +=
        (edges.empty() ? "it" : " and") + std::string(" ends ") + secondsText(-ends_later) + " before them";
  }
  return many + edges;
}

}  // namespace ratslam
