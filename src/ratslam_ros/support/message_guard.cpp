#include "ratslam_ros/support/message_guard.h"

namespace ratslam {

std::size_t MessageGuard::dropped(const std::string& topic) const {
  const auto found = dropped_.find(topic);
  return found == dropped_.end() ? 0 : found->second.count();
}

void MessageGuard::number(const std::string& topic, const std::string& publisher, std::uint32_t seq) {
  Losses& losses = losses_[topic];
  const std::size_t lost = losses.watch.messageOf(publisher, seq);
  if (lost == 0) return;
  losses.warning.report(
      topic + ": messages of " + publisher + " were lost: this node did not read them in time",
      losses.warning.count() + lost);
}

std::size_t MessageGuard::lost(const std::string& topic) const {
  const auto found = losses_.find(topic);
  return found == losses_.end() ? 0 : found->second.warning.count();
}

void MessageGuard::describe(DiagnosticStatus& status) const {
  if (dropped_.empty()) {
    status.summary(DiagnosticStatus::OK, "none dropped");
  } else {
    status.summary(DiagnosticStatus::WARN, "some could not be processed");
  }
  for (const auto& [topic, warning] : dropped_) status.add("dropped " + topic, warning.count());
  for (const auto& [topic, losses] : losses_) {
    if (losses.warning.count() > 0) status.add("lost " + topic, losses.warning.count());
  }
}

}  // namespace ratslam
