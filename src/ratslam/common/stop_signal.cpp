#include "ratslam/common/stop_signal.h"

#include <atomic>
#include <csignal>
#include <initializer_list>

namespace ratslam {
namespace {

// Any thread may be the one that a signal interrupts, while another one asks; a handler can reach no more than this.
std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not wait for a lock");

}  // namespace

void catchStopSignals() {
  const auto note = [](int) { requested = true; };
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto before = std::signal(signal, note);
    // Whoever starts a program with nohup wants it to outlive the terminal.
    if (signal == SIGHUP && before == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is for its writer to report
}

bool stopRequested() { return requested; }

}  // namespace ratslam
