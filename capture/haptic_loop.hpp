// The episode of a person at a device: the loop of insertion/loop.hpp in a thread of its own.
//
// The loop's thread runs under SCHED_FIFO with memory that stays resident, as far as that is
// permitted, and wakes at absolute deadlines, once per period. It hands each row on through a
// lock-free ring; the calling thread takes the rows out, so that a slow disk never delays the
// force.
#pragma once

#include "capture/row.hpp"
#include "haptic/period_clock.hpp"
#include "insertion/loop.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// How well the loop kept its period.
struct LoopTiming {
  PeriodStatistics periods;
  int scheduling_error = 0, locking_error = 0;  // errno of what was not permitted, or 0
};

// {"period_us", "periods", "p50_us", "p99_us", "p99_9_us", "worst_us", "missed", "sched_fifo",
// "memory_locked"}
Json loop_json(const LoopTiming& timing, double period);

// What the calling thread asks of a running episode.
enum class Request {
  go_on,
  finish,  // as if the operator had said that he is done
  stop     // `interrupted`
};

// Deadlines that were missed, of those that there should have been [-].
double missed_share(const PeriodStatistics& periods) noexcept;

struct TimedEpisode {
  InsertionEnd end;
  LoopTiming timing;
};

// Runs `run_insertion` in time: `device.read` is called once per period [s]. `record` and `request`
// are called in this thread, some hundred times per second; where `record` throws, the loop ends
// without force and the exception goes on. `stopped` is asked in the loop's thread, once per
// period, so that it ends the episode as `interrupted` also while `record` waits for the disk. Rows
// that wait for the disk: kRing at most, or the episode ends as `interrupted`; and so it does where
// the loop stood still for kStandstill, after which the time of the rows would not be that of the
// hand. What was inserted by then stays so. Where it stood still for kStall, and two periods, the
// force ramps up again. Throws what the device throws.
inline constexpr std::size_t kRing = 8192;
inline constexpr double kStandstill = 0.5;  // [s]; a device's own dead man's switch is faster
inline constexpr double kStall = 0.1;       // [s]; within ForceOutput::kDuration of the last start
TimedEpisode run_in_time(const TrialSetup& trial, Device& device, const LoopSettings& settings,
                         const std::function<void(const RowVector&, const RawCounts&)>& record,
                         const std::function<Request()>& request, bool (*stopped)() noexcept);

}  // namespace ferrule
