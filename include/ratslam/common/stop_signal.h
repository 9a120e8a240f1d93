/// Being asked to end: SIGINT, SIGTERM and SIGHUP mean the same, to finish what has been begun and to leave.
#pragma once

namespace ratslam {

/// From now on those signals are taken down instead of ending the program. A file that may not grow any more does
/// not end it either.
void catchStopSignals();

/// Whether one of them has come.
bool stopRequested();

}  // namespace ratslam
