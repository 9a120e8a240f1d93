// A race that the thread sanitizer must find: shows that a run of `scripts/endurance threads` would see one.
#include <atomic>
#include <iostream>

#include "ratslam/common/worker_pool.h"

int main() {
  ratslam::WorkerPool workers(3);
  int shared = 0;
  std::atomic<int> both{0};
  workers.run(3, [&](int) {
    for (++both; both < 2;) {  // two threads at least are in here at once
    }
    for (int i = 0; i < 1000; ++i) ++shared;
  });
  std::cout << shared << std::endl;
  return 0;
}
