#include "ratslam_ros/support/part_calls.h"

#include <ros/console.h>
#include <ros/service.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

constexpr double kAnswer =
    10.0;  // [s] for a command that takes no time: a busy node first processes what has come
constexpr double kWork = 300.0;  // [s] for one that reads or writes a large map; its node has just answered
const ros::WallDuration kRenewal(2.0);

PartCalls::Request holdRequest(bool on, const StreamPoint& last = {}) {
  PartCalls::Request request;
  request.command = PartCalls::Request::HOLD;
  request.on = on ? 1 : 0;
  request.session = stampToRos(last.session);
  request.stamp = stampToRos(last.stamp);
  return request;
}

}  // namespace

PartCalls::PartCalls(const ros::NodeHandle& handle, std::vector<std::string> services, double patience)
    : handle_(handle), services_(std::move(services)), patience_(patience) {}

void PartCalls::requireAll() const {
  for (const std::string& service : services_) {
    if (!ros::service::exists(service, false)) {
      throw std::runtime_error("nobody offers " + service + ": all nodes must be up; nothing was done");
    }
  }
}

std::string PartCalls::toAll(const Request& request) {
  std::string names;
  for (const std::string& service : services_) {
    send(service, request);
    names += service + ", ";
  }
  return names;
}

void PartCalls::send(const std::string& service, const Request& request) { call(service, request, kWork); }

bool PartCalls::wait(const std::function<bool()>& done, double limit_s) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(limit_s);
  while (!done()) {
    if (ros::WallTime::now() > end) return false;
    if (ending_) throw std::runtime_error("the node ends");
    renewHolds();
  }
  return true;
}

void PartCalls::rest() {
  ros::WallDuration(0.01).sleep();
  if (ending_) throw std::runtime_error("the node ends");
  renewHolds();
}

PartCalls::Response PartCalls::call(const std::string& service, const Request& request, double limit_s) {
  Request sent = request;
  Response response;
  ros::NodeHandle node(handle_);  // a handle keeps a record of each of its clients
  ros::ServiceClient client = node.serviceClient<ratslam_ros::PartCommand>(service, true);
  if (!client.isValid()) throw std::runtime_error(service + " does not answer: its node has ended");
  std::mutex mutex;
  std::condition_variable changed;
  bool answered = false;
  bool ended = false;
  std::thread thread([&] {
    const bool good = client.call(sent, response);
    const std::lock_guard<std::mutex> lock(mutex);
    answered = good;
    ended = true;
    changed.notify_all();
  });
  const auto done = [&] {
    std::unique_lock<std::mutex> lock(mutex);
    return changed.wait_for(lock, std::chrono::milliseconds(20), [&] { return ended; });
  };
  std::string why = service + " does not answer: its node has ended";
  try {
    if (!wait(done, limit_s)) {
      why = service + " has not answered for " + std::to_string(std::lround(limit_s)) +
            " s: its node is stopped or too busy";
    }
  } catch (const std::exception& e) {
    why = e.what();
  }
  // Without its connection the call ends, if it has begun.
  while (!done()) client.shutdown();
  thread.join();
  if (!answered) throw std::runtime_error(why);
  if (response.success == 0) throw std::runtime_error(response.message);
  return response;
}

void PartCalls::renewHolds() {
  if (renewing_ || held_.empty() || ros::WallTime::now() - renewed_ < kRenewal) return;
  renewing_ = true;
  Request renewal;
  renewal.command = Request::RENEW;
  for (const std::string& service : held_) {
    try {
      call(service, renewal, kRenewal.toSec());
    } catch (const std::exception&) {  // a part whose hold ended reports it in goOn()
    }
  }
  renewed_ = ros::WallTime::now();
  renewing_ = false;
}

PartCalls::Response PartCalls::hold(const std::string& service, const StreamPoint& last, std::string& why) {
  StreamPoint progress;
  ros::WallTime since = ros::WallTime::now();
  while (true) {
    const Response response = call(service, holdRequest(true, last), kAnswer);
    if (response.later == 0) break;
    const StreamPoint now{stampFromRos(response.session), stampFromRos(response.stamp)};
    if (!(now == progress)) since = ros::WallTime::now();
    progress = now;
    if (ros::WallTime::now() - since > ros::WallDuration(patience_)) {
      why = response.message;
      break;
    }
    rest();
  }
  held_.push_back(service);
  return call(service, holdRequest(true), kAnswer);
}

std::string PartCalls::standStill(const Behind& behind) {
  requireAll();
  held_.clear();
  renewed_ = ros::WallTime::now();
  std::string why;
  StreamPoint last;
  Stamp last_change = 0;
  for (const std::string& service : services_) {
    const Response held = hold(service, last, why);
    last = {stampFromRos(held.session), stampFromRos(held.stamp)};
    last_change = stampFromRos(held.action_stamp);
  }
  std::string progress;
  ros::WallTime since = ros::WallTime::now();
  while (true) {
    const std::string now = behind(last, last_change);
    if (now.empty()) return why;
    if (now != progress) since = ros::WallTime::now();
    progress = now;
    if (ros::WallTime::now() - since > ros::WallDuration(patience_)) return why.empty() ? progress : why;
    rest();
  }
}

std::string PartCalls::goOn() {
  std::string why;
  std::vector<std::string> held;
  held.swap(held_);
  std::reverse(held.begin(), held.end());
  for (const std::string& service : held) {
    try {
      call(service, holdRequest(false), kAnswer);
    } catch (const std::exception& e) {
      why = e.what();
    }
  }
  return why;
}

Standstill::Standstill(PartCalls& calls, const PartCalls::Behind& behind) : calls_(calls) {
  try {
    why_ = calls_.standStill(behind);
  } catch (...) {
    calls_.goOn();
    throw;
  }
}

Standstill::~Standstill() { calls_.goOn(); }

std::string Standstill::end() {
  const std::string broken = calls_.goOn();
  return why_.empty() ? broken : why_;
}

}  // namespace ratslam
