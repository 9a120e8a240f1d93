#include "ratslam/common/stop_signal.h"

#include <atomic>
#include <csignal>
#include <initializer_list>

namespace ratslam {
namespace {

// A signal may interrupt any thread while another one calls stopRequested(). A handler can reach only globals.
std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not wait for a lock");

}  // namespace

void catchStopSignals() {
  const auto note = [](int) { requested = true; };
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto before = std::signal(signal, note);
    // A program started with nohup must outlive the terminal.
    if (signal == SIGHUP && before == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  std::signal(SIGXFSZ, SIG_IGN);  // the writer of the file reports the error
}

bool stopRequested() { return requested; }

}  // namespace ratslam
