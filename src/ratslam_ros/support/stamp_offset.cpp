#include "ratslam_ros/support/stamp_offset.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ratslam {
namespace {

const ros::WallDuration kSilence(2.0);
constexpr double kMost_s = 1.0;     // a slow sensor or a queue can be that late
constexpr std::size_t kLooks = 15;  // 3 s at five calls a second
constexpr double kSteady = 0.1;     // largest variation of a lasting difference, as a share of it

}  // namespace

std::optional<double> StampOffset::seconds() const {
  if (!first_ || !second_) return std::nullopt;
  const ros::WallTime now = ros::WallTime::now();
  if (now - first_->at > kSilence || now - second_->at > kSilence) return std::nullopt;
  return secondsBetween(first_->stamp, second_->stamp) - (second_->at - first_->at).toSec();
}

std::optional<double> StampOffset::secondAlone() const {
  if (!first_ || !second_) return std::nullopt;
  return std::max(0.0, (second_->at - first_->at).toSec());
}

std::optional<std::string> StampOffset::complaint(const std::string& first_name,
                                                  const std::string& second_name) {
  const std::optional<double> offset = seconds();
  if (!offset) {
    lately_.clear();
    return std::nullopt;
  }
  lately_.push_back(*offset);
  if (lately_.size() > kLooks) lately_.pop_front();
  const auto [least, most] = std::minmax_element(lately_.begin(), lately_.end());
  const double size = std::abs(*offset);
  const double variation = *most - *least;
  if (lately_.size() < kLooks || size < kMost_s || variation > std::max(kSteady * size, 0.5))
    return std::nullopt;
  if (told_ && std::abs(*told_ - *offset) < std::max(0.5 * size, kMost_s)) return std::nullopt;
  told_ = offset;
  char text[512];
  std::snprintf(
      text, sizeof(text),
      "%s is stamped %.1f s %s %s: the two are merged by stamp, so that the map cannot know the motion "
      "between its views. Set the clocks of the machines alike (chrony); images of a camera that does not "
      "stamp can be stamped by their arrival (stamp_source: arrival)",
      second_name.c_str(), size, *offset < 0.0 ? "behind" : "ahead of", first_name.c_str());
  return text;
}

}  // namespace ratslam
