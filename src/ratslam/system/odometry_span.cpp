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

void OdometrySpan::end(const std::vector<Stamp>& images, const std::vector<Stamp>& views,
                       std::size_t dropped) {
  views_.insert(views_.end(), images.begin(), images.end());
  left_inside_ = dropped;
  for (const auto* left : {&images, &views}) {
    for (const Stamp stamp : *left) left_inside_ += isOutside(stamp) ? 0U : 1U;
  }
}

std::size_t OdometrySpan::outside() const {
  return static_cast<std::size_t>(
      std::count_if(views_.begin(), views_.end(), [this](Stamp view) { return isOutside(view); }));
}

std::optional<std::string> OdometrySpan::complaint() const {
  std::optional<std::string> complaint = complaintOfOutside();
  if (left_inside_ == 0) return complaint;
  return (complaint ? *complaint + "; " : "") + std::to_string(left_inside_) + " of " +
         std::to_string(views_.size()) +
         " images were never mapped: their time went back and that of the odometry did not, or it went back "
         "before the odometry had reached them";
}

std::optional<std::string> OdometrySpan::complaintOfOutside() const {
  const std::size_t outside = this->outside();
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
