#include "capture/haptic_loop.hpp"

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <exception>
#include <thread>

#include "haptic/real_time.hpp"

namespace ferrule {
namespace {

constexpr auto kEmptyEvery = std::chrono::milliseconds(2);

struct RingEntry {
  RowVector row;
  RawCounts counts;
};

// What the two threads share.
struct Shared {
  boost::lockfree::spsc_queue<RingEntry, boost::lockfree::capacity<kRing>> ring;
  std::atomic<Request> request = Request::go_on;
  std::atomic<bool> done = false;
};

// Each read waits for its period, and says when the calling thread wants an end.
class TimedDevice : public Device {
 public:
  TimedDevice(Device& device, PeriodClock& clock, double period,
              const std::atomic<Request>& request)
      : device_(device), clock_(clock), period_(period), request_(request) {}
  HandSample read(double t) override {
    const double passed = clock_.wait();
    stood_still_ = passed > kStandstill || stood_still_;
    HandSample sample = device_.read(t);
    sample.stalled = passed > std::max(kStall, 2 * period_);
    sample.finished = sample.finished || stood_still_ || request_ == Request::finish;
    return sample;
  }
  bool stood_still() const noexcept { return stood_still_; }
  void render(const HandWrench& wrench) override { device_.render(wrench); }
  void holder_at(const HandPose& holder) override { device_.holder_at(holder); }
  const Mapping* mapping() const noexcept override { return device_.mapping(); }

 private:
  Device& device_;
  PeriodClock& clock_;
  double period_;
  const std::atomic<Request>& request_;
  bool stood_still_ = false;
};

// What the loop's thread does.
TimedEpisode keep_time(const TrialSetup& trial, Device& device, const LoopSettings& settings,
                       Shared& shared, bool (*stopped)() noexcept) {
  const RealTime real_time;
  TimedEpisode result{};
  result.timing.scheduling_error = real_time.scheduling_error();
  result.timing.locking_error = real_time.locking_error();
  PeriodClock clock(settings.period);
  TimedDevice timed(device, clock, settings.period, shared.request);
  bool full = false;
  result.end = run_insertion(trial, timed, settings, [&](const Tick& tick) {
    full = !shared.ring.push({make_row(tick), tick.sample.counts});
    return !full && shared.request != Request::stop && !stopped();
  });
  device.render(HandWrench::Zero());
  result.timing.periods = clock.statistics();
  if (timed.stood_still() && result.end.outcome != Outcome::inserted)
    result.end.outcome = Outcome::interrupted;
  if (timed.stood_still())
    result.end.why = "the loop stood still";
  else if (full)
    result.end.why = "rows came faster than they could be written";
  return result;
}

}  // namespace

Json loop_json(const LoopTiming& timing, double period) {
  const PeriodStatistics& p = timing.periods;
  return {{"period_us", 1e6 * period},
          {"periods", p.periods},
          {"p50_us", 1e6 * p.p50},
          {"p99_us", 1e6 * p.p99},
          {"p99_9_us", 1e6 * p.p99_9},
          {"worst_us", 1e6 * p.worst},
          {"missed", p.missed},
          {"sched_fifo", timing.scheduling_error == 0},
          {"memory_locked", timing.locking_error == 0}};
}

double missed_share(const PeriodStatistics& periods) noexcept {
  const double missed = static_cast<double>(periods.missed);
  return missed / std::max(1.0, missed + static_cast<double>(periods.periods));
}

TimedEpisode run_in_time(const TrialSetup& trial, Device& device, const LoopSettings& settings,
                         const std::function<void(const RowVector&, const RawCounts&)>& record,
                         const std::function<Request()>& request, bool (*stopped)() noexcept) {
  const auto shared = std::make_unique<Shared>();
  std::exception_ptr trouble;
  TimedEpisode result{};
  std::thread loop([&] {
    try {
      result = keep_time(trial, device, settings, *shared, stopped);
    } catch (...) {
      trouble = std::current_exception();
      try {
        device.render(HandWrench::Zero());
      } catch (...) {  // it has said what is wrong already
      }
    }
    shared->done = true;
  });

  const auto empty_ring = [&] {
    shared->ring.consume_all([&](const RingEntry& entry) { record(entry.row, entry.counts); });
  };
  try {
    while (!shared->done) {
      empty_ring();
      if (const Request now = request(); now != Request::go_on) shared->request = now;
      std::this_thread::sleep_for(kEmptyEvery);
    }
  } catch (...) {
    shared->request = Request::stop;
    loop.join();
    throw;
  }
  loop.join();
  empty_ring();
  if (trouble) std::rethrow_exception(trouble);
  return result;
}

}  // namespace ferrule
