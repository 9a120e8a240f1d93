// ratslam_run: the whole system over a recording, without a roscore, as fast as the machine allows.
#include <iostream>

#include "offline_run.h"
#include "ratslam/common/stop_signal.h"
#include "run_options.h"

int main(int argc, char** argv) {
  ratslam::catchStopSignals();
  try {
    const auto options = ratslam::parseRunOptions(argc, argv);
    if (!options) return 0;
    return ratslam::OfflineRun(*options).run() ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_run: " << error.what() << '\n';
    return 1;
  }
}
