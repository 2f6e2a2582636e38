// A policy that is somebody else's, in a process of its own, asked through a pipe.
//
// A program is run by the shell and talks JSON, a line each, in turns: it gets a line on its
// standard input and answers with one on its standard output.
//   {"reset": {"trial": k, "seed": s, "control_hz": f}}       before every trial; {} answers
//   {"wrench": [Fx, Fy, Fz, My, Mz], "depth": d, "time": t,   an observation, in the hand's world
//    "displacement": [x, y, z, tilt_y, tilt_z], "height": h,  [N, N m], [m, rad], [s]
//    "force_limit": F}
//   {"velocity": [vx, vy, vz, tilt_y, tilt_z]}                answers it [m/s, rad/s]
//   {"velocity": [...], "done": true}                         and ends the trial after it
//   {"error": "why"}                                          answers what it cannot answer
// One process serves one trial at a time and many after one another, each thread its own. One that
// ends, is silent for too long, or answers anything else ends its trial, which then says why, and
// is ended itself; the next trial begins another. One that failed in each of its first ten trials
// is not asked any more: it fails in all. A trial in which it was killed from outside is no
// failure: a campaign runs it again. No process outlives this program (sim/base/child_process.hpp).
#pragma once

#include <string>

#include "controller/controller.hpp"

namespace ferrule {

struct ProgramSettings {
  double start_timeout = 60;  // for the answer to a reset [s], > 0
  double timeout = 10;        // for each other answer [s], > 0
  double control_hz = 1000;   // how often it is asked, for it to know
  std::uint64_t seed = 0;     // of the trials, for it to know
  // Whether an answer is waited for no longer, and its trial fails; asked from any thread.
  std::function<bool()> stop{};
  // Gets what it writes to its standard error, some bytes at a time, from any thread: the first
  // 64 kB of all its processes.
  std::function<void(const std::string&)> said{};
};

// Of a trial that says `why` it ended (TrialResult): was the policy's process killed from outside,
// as where memory is short, or could not be started? That says nothing of the trial.
bool ended_by_system(const std::string& why);

// A controller that asks the program `command`, for /bin/sh -c; all that it makes share the
// processes.
MakeController program_policy(const std::string& command, const ProgramSettings& settings);

// Controllers of `make`, which runs in forks of this process that only read files, and take no more
// than `memory` [bytes] beyond what this process has.
MakeController forked_policy(const MakeController& make, std::size_t memory,
                             const ProgramSettings& settings);

}  // namespace ferrule
