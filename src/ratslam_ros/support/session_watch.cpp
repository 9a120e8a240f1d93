#include "ratslam_ros/support/session_watch.h"

#include <ros/console.h>

#include <utility>

namespace ratslam {

SessionWatch::SessionWatch(std::string who, std::string what)
    : who_(std::move(who)), what_(std::move(what)) {}

void SessionWatch::heard(const NumberSession& session) {
  if (session.id == 0 || !(session != last_)) return;
  const bool again = last_.id != 0;
  last_ = session;
  if (!again) return;
  ROS_WARN("%s started again: it knows %u %s from before, and what was known of later ones is forgotten",
           who_.c_str(), session.known, what_.c_str());
}

}  // namespace ratslam
