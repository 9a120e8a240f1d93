/// A queue for messages that wait for a slow callback. They are processed in the order of arrival. If too many wait, the
/// oldest are dropped, so that a node on a slow machine does not fall further and further behind.
///
/// A bounded ROS subscription also drops messages, but does not count them. Everything runs in the callback queue of the
/// node handle, which must have one thread.
#pragma once

#include <ros/callback_queue_interface.h>
#include <ros/node_handle.h>

#include <cstddef>
#include <deque>
#include <functional>

namespace ratslam {

/// A call that is made later, in the callback queue.
class PostedCall : public ros::CallbackInterface {
 public:
  explicit PostedCall(std::function<void()> call) : call_(std::move(call)) {}
  CallResult call() override {
    call_();
    return Success;
  }

 private:
  std::function<void()> call_;
};

template <class Item>
class DropOldestQueue {
 public:
  /// @param size  largest number of waiting items; 0: no bound   @param handle_item  receives the items in order
  DropOldestQueue(const ros::NodeHandle& handle, std::size_t size,
                  std::function<void(const Item&)> handle_item)
      : callbacks_(handle.getCallbackQueue()), size_(size), handle_item_(std::move(handle_item)) {}
  ~DropOldestQueue() { callbacks_->removeByID(id()); }
  DropOldestQueue(const DropOldestQueue&) = delete;
  DropOldestQueue& operator=(const DropOldestQueue&) = delete;

  /// @return number of items that were dropped
  std::size_t push(const Item& item) {
    items_.push_back(item);
    std::size_t dropped = 0;
    for (; size_ > 0 && items_.size() > size_; ++dropped) items_.pop_front();
    post();
    return dropped;
  }

  /// Holds all items until release().
  void hold() { held_ = true; }
  void release() {
    held_ = false;
    post();
  }

  std::size_t waiting() const { return items_.size(); }

 private:
  std::uint64_t id() const { return reinterpret_cast<std::uint64_t>(this); }

  /// Messages that have arrived meanwhile precede this call in the callback queue, so they are processed first.
  void post() {
    if (posted_ || held_ || items_.empty()) return;
    posted_ = true;
    callbacks_->addCallback(boost::make_shared<PostedCall>([this] { handleOne(); }), id());
  }

  void handleOne() {
    posted_ = false;
    if (items_.empty() || held_) return;
    const Item item = items_.front();
    items_.pop_front();
    post();
    handle_item_(item);
  }

  ros::CallbackQueueInterface* callbacks_;
  std::size_t size_;
  std::function<void(const Item&)> handle_item_;
  std::deque<Item> items_;
  bool posted_ = false;
  bool held_ = false;
};

}  // namespace ratslam
