/// Renders a synthetic drive with exact truth: `ratslam_town --help`.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

#include "bags.h"
#include "ratslam/common/params.h"
#include "town/town_run.h"

namespace {

volatile std::sig_atomic_t stop_asked = 0;

void askToStop(int) { stop_asked = 1; }

bool showProgress(int done, int total) {
  if (isatty(STDERR_FILENO) != 0 && (done % 10 == 0 || done == total)) {
    std::cerr << "\r" << done << " / " << total << " frames" << std::flush;
    if (done == total) std::cerr << "\n";
  }
  return stop_asked == 0;
}

/// Takes `--root NAME`, the namespace of a bag's topics, out of the arguments.
std::optional<std::string> takeRoot(std::vector<std::string>& arguments) {
  const auto found = std::find(arguments.begin(), arguments.end(), "--root");
  if (found == arguments.end()) return std::nullopt;
  if (std::next(found) == arguments.end())
    throw std::invalid_argument("--root: the name of the topics' namespace is missing");
  std::string root = *std::next(found);
  arguments.erase(found, found + 2);
  return root;
}

std::unique_ptr<ratslam::TownSink> makeSink(const ratslam::TownOptions& options,
                                            const std::optional<std::string>& root) {
  if (options.writesBag()) return ratslam::makeBagSink(options, root.value_or("town"));
  if (root) ratslam::throwBadValue("root", *root, "folders have no topics; --out must end with .bag");
  return ratslam::makeFolderSink(options);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (std::find(arguments.begin(), arguments.end(), "--help") != arguments.end()) {
      std::cout << ratslam::townUsage()
                << "\nWhere --out ends with .bag the drive is written as a bag; --root NAME (default: town) "
                   "is the\n"
                   "namespace of its topics.\n";
      return 0;
    }
    std::signal(SIGINT, askToStop);
    std::signal(SIGTERM, askToStop);
    const std::optional<std::string> root = takeRoot(arguments);
    const ratslam::TownOptions options = ratslam::parseTownOptions(arguments);
    const auto sink = makeSink(options, root);
    const ratslam::TownSummary summary = ratslam::runTown(options, *sink, showProgress);
    std::cout << options.out << ": " << summary.frames << " frames, " << summary.way << " m in "
              << summary.seconds << " s\n";
    return stop_asked == 0 ? 0 : 130;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_town: " << error.what() << "\n";
    return 1;
  }
}
