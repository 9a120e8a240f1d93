#include "ratslam/dataset/clock.h"

#include <algorithm>
#include <set>

namespace ratslam {
namespace {

/// Fewest consecutive images before the latest stamp that show a clock set back. Fewer are late images.
constexpr int kMinBehind = 3;
/// A file is not ordered if more than this share of its times is earlier than the time before it.
constexpr double kMaxDescents = 0.05;
constexpr std::size_t kDescentsOfAnyFile = 3;
/// Largest step between images of one clock, in usual steps.
constexpr Stamp kMaxStep = 5;

}  // namespace

std::optional<ClockJump> clockSetBack(const std::vector<std::pair<Stamp, std::string>>& images) {
  std::vector<Stamp> stamps;
  std::set<std::pair<Stamp, std::string>> seen;
  for (const auto& image : images) {
    if (seen.insert(image).second) stamps.push_back(image.first);
  }
  std::vector<Stamp> forward;
  std::size_t descents = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const Stamp step = stamps[i] - stamps[i - 1];
    if (step > 0) forward.push_back(step);
    if (step < 0) ++descents;
  }
  const double allowed = kMaxDescents * static_cast<double>(stamps.empty() ? 0 : stamps.size() - 1);
  if (forward.empty() || descents == 0) return std::nullopt;
  if (descents > kDescentsOfAnyFile && static_cast<double>(descents) > allowed) return std::nullopt;
  std::sort(forward.begin(), forward.end());
  const Stamp usual = forward[forward.size() / 2];
  Stamp latest = stamps.front();
  std::size_t begin = 0;
  int behind = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > latest) {
      latest = stamps[i];
      behind = 0;
      continue;
    }
    const Stamp step = stamps[i] - stamps[i - 1];
    // Equivalent to step <= kMaxStep * usual, which could overflow.
    const bool goes_on = behind > 0 && step > 0 && (step - 1) / kMaxStep < usual;
    behind = goes_on ? behind + 1 : 1;
    if (!goes_on) begin = i;
    if (behind >= kMinBehind) return ClockJump{stamps[begin], latest - stamps[begin]};
  }
  return std::nullopt;
}

}  // namespace ratslam
