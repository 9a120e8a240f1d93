/// Scratch memory that is aligned to a cache line. It grows as needed and never shrinks.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace ratslam {

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};

  CacheLineAllocator() = default;
  template <class U>
  explicit CacheLineAllocator(const CacheLineAllocator<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kAlignment)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kAlignment); }
  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
  friend bool operator!=(const CacheLineAllocator&, const CacheLineAllocator&) { return false; }
};

template <class T>
class AlignedBuffer {
 public:
  /// At least `count` elements. Elements keep their values from before.
  T* atLeast(std::size_t count) {
    if (elements_.size() < count) elements_.resize(count);
    return elements_.data();
  }
  T* data() { return elements_.data(); }
  const T* data() const { return elements_.data(); }

 private:
  std::vector<T, CacheLineAllocator<T>> elements_;
};

}  // namespace ratslam
