#include "ratslam/common/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

namespace ratslam {
namespace {

TEST(WorkerPool, DoesEachIndexOnceWhateverTheNumberOfThreads) {
  for (const int threads : {1, 2, 5}) {
    WorkerPool pool(threads);
    for (int round = 0; round < 200; ++round) {
      std::vector<int> done(static_cast<std::size_t>(round), 0);
      pool.run(round, [&](int i) { ++done[static_cast<std::size_t>(i)]; });
      EXPECT_EQ(done, std::vector<int>(done.size(), 1)) << threads;
    }
  }
}

TEST(WorkerPool, HandsOnAnErrorAndGoesOnWorking) {
  for (const int threads : {1, 3}) {
    WorkerPool pool(threads);
    EXPECT_THROW(pool.run(100,
                          [](int i) {
                            if (i == 40) throw std::runtime_error("bad");
                          }),
                 std::runtime_error);
    std::atomic<int> sum{0};
    pool.run(10, [&](int i) { sum += i; });
    EXPECT_EQ(sum, 45);
  }
}

}  // namespace
}  // namespace ratslam
