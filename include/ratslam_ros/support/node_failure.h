/// What an exception does that makes a node useless: a checkpoint with other parameters, for example.
///
/// A node ends with it, as its program reports the message and exits. A nodelet shares its process with others, such as the
/// camera's driver, and must not end them: it reports the message and remains idle.
#pragma once

#include <exception>

namespace ratslam {

/// To be called once by a process that runs nodelets.
void setProcessIsShared();

/// To be called in a handler of the exception. Throws it on, unless the process is shared.
void failNode(const std::exception& error);

}  // namespace ratslam
