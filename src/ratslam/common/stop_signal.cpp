#include "ratslam/common/stop_signal.h"

#include <csignal>
#include <initializer_list>

namespace ratslam {
namespace {

volatile std::sig_atomic_t requested = 0;  // a signal handler can reach nothing else

}  // namespace

void catchStopSignals() {
  const auto note = [](int) { requested = 1; };
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto before = std::signal(signal, note);
    // Whoever starts a program with nohup wants it to outlive the terminal.
    if (signal == SIGHUP && before == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is for its writer to report
}

bool stopRequested() { return requested != 0; }

}  // namespace ratslam
