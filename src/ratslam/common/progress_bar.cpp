#include "ratslam/common/progress_bar.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <ostream>
#include <sstream>

namespace ratslam {

ProgressBar::ProgressBar(std::ostream& out, std::size_t total, std::string unit, bool drawn)
    : out_(out), total_(total), unit_(std::move(unit)), drawn_(drawn), start_(Clock::now()), last_(start_) {}

ProgressBar::~ProgressBar() {
  if (begun_) out_ << std::endl;
}

void ProgressBar::update(std::size_t done) {
  if (!drawn_) return;
  const Clock::time_point now = Clock::now();
  const bool last_step = total_ != 0 && done >= total_;
  if (begun_ && !last_step && now - last_ < std::chrono::milliseconds(100)) return;
  begun_ = true;
  last_ = now;
  out_ << '\r' << line(done, std::chrono::duration<double>(now - start_).count()) << "   " << std::flush;
}

std::string ProgressBar::line(std::size_t done, double seconds) const {
  std::ostringstream text;
  const double rate = seconds > 0.0 ? static_cast<double>(done) / seconds : 0.0;
  text << done;
  if (total_ != 0) {
    const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
    const auto filled = static_cast<std::size_t>(share * 30.0);
    text << '/' << total_;
    const std::string bar = std::string(filled, '#') + std::string(30 - filled, '.');
    text << ' ' << unit_ << " [" << bar << "] " << std::lround(share * 100.0) << '%';
  } else {
    text << ' ' << unit_;
  }
  text << std::fixed << std::setprecision(rate < 10.0 ? 1 : 0) << ", " << rate << "/s";
  if (total_ > done && rate > 0.0) {
    const long left = std::lround(static_cast<double>(total_ - done) / rate);
    text << ", " << left / 60 << ':' << std::setw(2) << std::setfill('0') << left % 60 << " left";
  }
  return text.str();
}

}  // namespace ratslam
