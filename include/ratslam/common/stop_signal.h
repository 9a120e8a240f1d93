/// Requests to end the program: SIGINT, SIGTERM and SIGHUP all mean to finish the work in progress and exit.
#pragma once

namespace ratslam {

/// From now on those signals are recorded instead of ending the program. Exceeding the limit on file sizes does not
/// end it either.
void catchStopSignals();

/// Whether one of the signals has come.
bool stopRequested();

}  // namespace ratslam
