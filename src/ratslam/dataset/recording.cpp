#include "ratslam/dataset/recording.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace ratslam {

DecodedImage decodeNow(const RecordedImage& encoded) {
  DecodedImage decoded{encoded.stamp, encoded.name, {}, {}};
  try {
    decoded.image = encoded.decode();
    if (decoded.image.empty()) decoded.error = "not a complete image of a known format";
  } catch (const std::exception& error) {
    decoded.error = error.what();
  }
  return decoded;
}

DecodeAhead::DecodeAhead(Recording& recording, int threads)
    : recording_(recording), depth_(static_cast<std::size_t>(4 * std::max(threads, 1))) {
  try {
    for (int i = 0; i < std::max(threads, 1); ++i) threads_.emplace_back([this] { work(); });
  } catch (const std::system_error& error) {  // fewer threads give the same results
    if (threads_.empty()) {
      throw std::runtime_error(std::string("no thread can be started that decodes images: ") + error.what());
    }
  }
}

DecodeAhead::~DecodeAhead() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  wake_workers_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::optional<DecodedItem> DecodeAhead::next() {
  std::unique_lock<std::mutex> lock(mutex_);
  fill(lock);
  if (slots_.empty()) {
    if (failure_) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  const std::shared_ptr<Slot> slot = slots_.front();
  wake_reader_.wait(lock, [&slot] { return slot->done; });
  slots_.pop_front();
  return std::move(slot->item);
}

double DecodeAhead::decodingSeconds() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return decoding_seconds_;
}

void DecodeAhead::fill(std::unique_lock<std::mutex>& lock) {
  while (!at_end_ && slots_.size() < depth_) {
    lock.unlock();  // reading may wait for a disk, and the workers continue meanwhile
    std::optional<RecordedItem> item;
    try {
      item = recording_.next();
    } catch (...) {
      failure_ = std::current_exception();
    }
    lock.lock();
    if (!item) {
      at_end_ = true;
      return;
    }
    auto slot = std::make_shared<Slot>();
    if (const auto* odometry = std::get_if<OdometrySample>(&*item)) {
      slot->item = *odometry;
      slot->done = true;
    } else {
      slot->encoded = std::get<RecordedImage>(std::move(*item));
      to_decode_.push_back(slot);
      wake_workers_.notify_one();
    }
    slots_.push_back(std::move(slot));
  }
}

void DecodeAhead::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_workers_.wait(lock, [this] { return stopping_ || !to_decode_.empty(); });
    if (stopping_) return;
    const std::shared_ptr<Slot> slot = to_decode_.front();
    to_decode_.pop_front();
    lock.unlock();
    const auto begin = std::chrono::steady_clock::now();
    DecodedImage decoded = decodeNow(*slot->encoded);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    lock.lock();
    decoding_seconds_ += seconds.count();
    slot->item = std::move(decoded);
    slot->done = true;
    wake_reader_.notify_one();
  }
}

}  // namespace ratslam
