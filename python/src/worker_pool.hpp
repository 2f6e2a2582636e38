// Threads that take up work at once: some microseconds of it for each of many fibres, step after
// step. (Those of oneTBB sleep in between, and wake when such a step is over.)
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace ferrule::python {

class WorkerPool {
 public:
  // Of `threads` >= 1, the caller's among them.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // work(0) ... work(count - 1): each thread does its own share, which is in its cache from the
  // call before, then what is left of the others'. Throws what the first that failed threw, when
  // all are done. One call at a time.
  void for_each(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  struct alignas(64) Share {
    std::atomic<std::size_t> next = 0;
    std::size_t end = 0;
  };
  void serve(std::size_t self);
  void take(std::size_t self) noexcept;

  std::vector<Share> shares_;  // of each thread, the caller's first
  std::vector<std::thread> threads_;
  std::atomic<unsigned> round_ = 0;  // of work; the threads wait for the next
  std::atomic<int> busy_ = 0;        // threads that have not finished it
  std::atomic<bool> over_ = false;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::mutex failing_;
  std::exception_ptr failed_;
};

}  // namespace ferrule::python
