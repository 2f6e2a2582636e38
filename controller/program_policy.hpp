// A policy that is a program of somebody else's, asked through a pipe.
//
// It is run by the shell and talks JSON, a line each, in turns: it gets a line on its standard
// input and answers with one on its standard output.
//   {"reset": {"trial": k, "seed": s, "control_hz": f}}       before every trial; {} answers
//   {"wrench": [Fx, Fy, Fz, My, Mz], "depth": d, "time": t}   an observation, in the hand's world
//                                                             [N, N m], [m], [s]
//   {"velocity": [vx, vy, vz, tilt_y, tilt_z]}                answers it [m/s, rad/s]
// One process serves one trial at a time and many after one another, each thread its own. One that
// ends, is silent for too long, or answers anything else ends its trial, which then says why, and
// is ended itself; the next trial begins another.
#pragma once

#include <string>

#include "controller/controller.hpp"

namespace ferrule {

struct ProgramSettings {
  std::string command;        // for /bin/sh -c
  double start_timeout = 60;  // for the answer to a reset [s], > 0
  double timeout = 10;        // for each other answer [s], > 0
  double control_hz = 1000;   // how often it is asked, for it to know
  std::uint64_t seed = 0;     // of the trials, for it to know
};

// A controller that asks such a program; all that it makes share the processes.
MakeController program_policy(const ProgramSettings& settings);

}  // namespace ferrule
