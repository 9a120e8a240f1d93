/// A warning that may occur with every message. All are counted, and few are printed.
#pragma once

#include <ros/console.h>
#include <ros/time.h>

#include <cstddef>
#include <string>

namespace ratslam {

class CountedWarning {
 public:
  /// @param period_s  least wall time between two lines [s]
  explicit CountedWarning(double period_s = 5.0) : period_(period_s) {}

  /// Counts, and prints `text` with the count unless a line was printed within the period.
  void report(const std::string& text) { report(text, count_ + 1); }

  /// The same for several events at once: `count` is the new count.
  void report(const std::string& text, std::size_t count) {
    const bool first = count_ == 0;
    count_ = count;
    text_ = text;
    if (first || ros::WallTime::now() - printed_ >= period_) print();
  }

  /// Prints what came since the last line, once the period is over. To be called a few times a second where the last count
  /// matters.
  void remind() {
    if (count_ > told_ && ros::WallTime::now() - printed_ >= period_) print();
  }

  /// The same for a counter of another object, which went from `before` to `now`. A loaded state may set that counter to
  /// anything, so that only the difference over a call tells what has happened in it.
  void reportIncrease(const std::string& text, std::size_t before, std::size_t now) {
    if (now > before) report(text, count_ + now - before);
  }

  std::size_t count() const { return count_; }

 private:
  void print() {
    printed_ = ros::WallTime::now();
    told_ = count_;
    ROS_WARN("%s (%zu so far)", text_.c_str(), count_);
  }

  ros::WallDuration period_;
  ros::WallTime printed_;
  std::string text_;
  std::size_t count_ = 0;
  std::size_t told_ = 0;  ///< the count in the last line
};

}  // namespace ratslam
