// What a person at a device sees on the terminal while he inserts: one line, ten times a second.
#pragma once

#include "capture/row.hpp"

namespace ferrule {

class StatusLine {
 public:
  // Of an insertion in `scene`, which outlives it. Nothing is shown where stderr is not a terminal.
  explicit StatusLine(const Scene& scene) noexcept;
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;
  ~StatusLine();  // takes it away

  // Of every row in turn.
  void operator()(const RowVector& row);

 private:
  const Scene& scene_;
  bool shown_;
  double next_ = 0;  // [s]
};

// The line: "  3.2 s  depth  12.34 um  gap  0.412 um  force  2.31 of 10 uN [##        ]". Where the
// gap is none it says by how much the end is beside the bore, or is pressed in.
std::string status_text(const RowVector& row, const Scene& scene);

}  // namespace ferrule
