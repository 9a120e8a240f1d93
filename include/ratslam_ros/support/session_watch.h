/// Logs once that another part has started again, and which of its numbers it has forgotten.
#pragma once

#include <string>

#include "ratslam/events.h"

namespace ratslam {

class SessionWatch {
 public:
  /// @param who  "the local view"   @param what  it numbers: "views"
  SessionWatch(std::string who, std::string what);

  /// Sets the session from before this process began, which is not reported.
  void start(const NumberSession& known) { last_ = known; }
  /// To be called with the session of every message.
  void heard(const NumberSession& session);

 private:
  std::string who_;
  std::string what_;
  NumberSession last_;
};

}  // namespace ratslam
