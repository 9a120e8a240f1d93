#include "ratslam_ros/support/node_diagnostics.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <memory>

namespace ratslam {

double RateMeter::perSecond(std::size_t count) {
  const ros::WallTime now = ros::WallTime::now();
  const double elapsed = looked_at_.isZero() ? 0.0 : (now - looked_at_).toSec();
  const double rate = elapsed > 0.0 ? static_cast<double>(count - count_) / elapsed : 0.0;
  looked_at_ = now;
  count_ = count;
  return rate;
}

double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  double resident = 0.0;
  if (!(file >> pages >> resident)) return 0.0;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

NodeDiagnostics::NodeDiagnostics(const ros::NodeHandle& handle, const ros::NodeHandle& own)
    : updater_(handle, own, own.getNamespace()) {
  updater_.setHardwareID("none");
  add("memory", [](DiagnosticStatus& status) {
    status.summaryf(DiagnosticStatus::OK, "%.0f MB", residentMegabytes());
    status.add("resident memory [MB]", residentMegabytes());
  });
}

void NodeDiagnostics::add(const std::string& name, std::function<void(DiagnosticStatus&)> describe) {
  updater_.add(name, std::move(describe));
}

void NodeDiagnostics::addImages(const ImageSubscriber& images) {
  struct Seen {
    RateMeter rate;
    std::size_t left_out = 0;
  };
  add("images", [&images, seen = std::make_shared<Seen>()](DiagnosticStatus& status) {
    const ImageCounts& counts = images.counts();
    const ImageTraffic& traffic = images.traffic();
    const double rate = seen->rate.perSecond(counts.used);
    const std::size_t left_out = counts.images - counts.used + traffic.dropped;
    if (counts.images == 0) {
      status.summary(DiagnosticStatus::WARN, "no images yet");
    } else if (counts.used == 0) {
      status.summary(DiagnosticStatus::ERROR, counts.text());
    } else if (rate == 0.0) {
      status.summary(DiagnosticStatus::WARN, "no images in the last second; " + counts.text());
    } else if (left_out > seen->left_out) {
      status.summaryf(DiagnosticStatus::WARN, "%.1f images a second; %zu left out", rate,
                      left_out - seen->left_out);
    } else {
      status.summaryf(DiagnosticStatus::OK, "%.1f images a second", rate);
    }
    seen->left_out = left_out;
    status.add("rate [1/s]", rate);
    counts.visit([&status](const std::string& name, std::size_t number) { status.add(name, number); });
    status.add("dropped_images", traffic.dropped);
    status.add("arrival to result [s]", traffic.delay_s);
    status.add("stamp to arrival [s]", traffic.age_s);
  });
}

void NodeDiagnostics::addMessages(const std::string& name, const MessageGuard& messages) {
  add(name, [&messages](DiagnosticStatus& status) { messages.describe(status); });
}

void describeMap(DiagnosticStatus& status, const ExperienceGraph& graph) {
  const auto recalls =
      std::count_if(graph.links().begin(), graph.links().end(), [](const Link& link) { return link.recall; });
  status.summaryf(DiagnosticStatus::OK, "%zu experiences, %zu links", graph.experiences().size(),
                  graph.links().size());
  status.add("experiences", graph.experiences().size());
  status.add("links", graph.links().size());
  status.add("links by recall", recalls);
}

}  // namespace ratslam
