/// Renders a synthetic drive with exact truth: `ratslam_town --help`.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>

#include "ratslam/town/town_run.h"

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

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (std::find(arguments.begin(), arguments.end(), "--help") != arguments.end()) {
      std::cout << ratslam::townUsage();
      return 0;
    }
    std::signal(SIGINT, askToStop);
    std::signal(SIGTERM, askToStop);
    const ratslam::TownOptions options = ratslam::parseTownOptions(arguments);
    const auto sink = ratslam::makeFolderSink(options);
    const ratslam::TownSummary summary = ratslam::runTown(options, *sink, showProgress);
    std::cout << options.out << ": " << summary.frames << " frames, " << summary.way << " m in "
              << summary.seconds << " s\n";
    return stop_asked == 0 ? 0 : 130;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_town: " << error.what() << "\n";
    return 1;
  }
}
