#include "worker_pool.hpp"

#include <chrono>

namespace ferrule::python {
namespace {

// As long as somebody's policy is expected to take between two steps: longer, and threads sleep.
constexpr std::chrono::microseconds kAwake{200};

// Returns when `value` is no longer `old`.
template <class T>
void wait_while(const std::atomic<T>& value, T old) noexcept {
  const auto begin = std::chrono::steady_clock::now();
  while (value.load(std::memory_order_acquire) == old)
    if (std::chrono::steady_clock::now() - begin > kAwake)
      value.wait(old, std::memory_order_acquire);
}

}  // namespace

WorkerPool::WorkerPool(int threads) : shares_(static_cast<std::size_t>(threads)) {
  for (std::size_t i = 1; i < shares_.size(); ++i) threads_.emplace_back([this, i] { serve(i); });
}

WorkerPool::~WorkerPool() {
  over_ = true;
  ++round_;
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::for_each(std::size_t count, const std::function<void(std::size_t)>& work) {
  work_ = &work;
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    shares_[i].next = i * count / shares_.size();
    shares_[i].end = (i + 1) * count / shares_.size();
  }
  failed_ = nullptr;
  busy_ = static_cast<int>(threads_.size());
  ++round_;
  round_.notify_all();
  take(0);
  for (int busy; (busy = busy_.load(std::memory_order_acquire)) > 0;) wait_while(busy_, busy);
  if (failed_) std::rethrow_exception(failed_);
}

void WorkerPool::serve(std::size_t self) {
  for (unsigned round = 0;;) {
    wait_while(round_, round++);
    if (over_) return;
    take(self);
    if (--busy_ == 0) busy_.notify_all();
  }
}

void WorkerPool::take(std::size_t self) noexcept {
  for (std::size_t k = 0; k < shares_.size(); ++k) {
    Share& share = shares_[(self + k) % shares_.size()];
    for (std::size_t i; (i = share.next.fetch_add(1)) < share.end;) {
      try {
        (*work_)(i);
      } catch (...) {
        const std::lock_guard lock(failing_);
        if (!failed_) failed_ = std::current_exception();
      }
    }
  }
}

}  // namespace ferrule::python
