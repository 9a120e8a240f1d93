/// Progress of a long run on the terminal: share done, rate, remaining time.
#pragma once

#include <chrono>
#include <cstddef>
#include <iosfwd>
#include <string>

namespace ratslam {

class ProgressBar {
 public:
  /// @param out    output stream, usually std::cerr
  /// @param total  number of steps; 0: unknown
  /// @param unit   name of the steps: "frames"
  /// @param drawn  false: draw nothing (no terminal)
  ProgressBar(std::ostream& out, std::size_t total, std::string unit, bool drawn);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Updates the line, at most ten times a second.
  void update(std::size_t done);

  /// Text of the line after `seconds` of work.
  std::string line(std::size_t done, double seconds) const;

 private:
  using Clock = std::chrono::steady_clock;
  std::ostream& out_;
  std::size_t total_;
  std::string unit_;
  bool drawn_;
  bool begun_ = false;
  Clock::time_point start_;
  Clock::time_point last_;
};

}  // namespace ratslam
