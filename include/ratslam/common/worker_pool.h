/// A few threads that share the work of one loop at a time. Which thread gets which index is not determined. So each
/// task must write only to its own data: then results do not depend on the number of threads.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace ratslam {

class WorkerPool {
 public:
  /// @param threads  at least 1, the calling thread included
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Calls task(i) once for each i in [0, count) and returns when all are done. Not to be called from a task.
  /// @throws the first exception of a task. Remaining indices are skipped then.
  void run(int count, const std::function<void(int)>& task);

 private:
  void work();
  void takeIndices(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(int)>* task_ = nullptr;
  int count_ = 0;
  int next_ = 0;
  int running_ = 0;  // number of running tasks
  std::exception_ptr error_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace ratslam
