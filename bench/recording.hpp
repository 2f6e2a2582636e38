// What recording costs beside the loop, and what is written.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct RecordingRow {
  std::string scene;
  long rows;
  double us_per_row;  // of the thread that records: a row made, kept, brought to the journal
  double us_per_row_written;  // by the clock, until a child process has made the file
  double kB_per_s;            // of recording, in the file
};

// An insertion by the simulated operator in `bench` and in `paper`, recorded into the folder for
// temporary files.
std::vector<RecordingRow> bench_recording(const GoOn& go_on = {});

}  // namespace ferrule
