// What a hand at the page did in one insertion, without what followed of it: some kilobytes, of which the episode is
// computed again, bit for bit. A page that runs without the program (view/playground/) saves its tries so, and
// `ferrule import` makes episodes of them.
//
// One JSON object:
//   format "ferrule input log", format_version 1
//   ferrule_version, build    of the program that it was recorded with
//   scene                     the document, as drawn
//   seed, trial, operator, trainee, date, session, outcome, why
//                             as the attributes of an episode (capture/episode.hpp)
//   counts                    of the device `browser` (view/browser_device.hpp): a list of [rows, X, Y, Z], what so many
//                             rows after each other have. A row is 1 ms
//   rows_sha1                 SHA-1 of all rows (capture/row.hpp) as float64, little endian
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/episode.hpp"

namespace ferrule {

// So many rows with the same counts.
struct HeldCounts {
  std::int64_t rows;                   // >= 1
  std::array<std::int16_t, 3> counts;  // X Y Z, each within +-BrowserHand::kFull
};

struct InputLog {
  EpisodeInfo info;
  std::vector<HeldCounts> held;
  std::string rows_sha1;

  std::int64_t rows() const noexcept;
  // Adds a row, of the counts of its sample.
  void add(const RawCounts& counts);
};

Json to_json(const InputLog& log);
// Throws BadInput; the scene is only read by recorded_scene.
InputLog parse_input_log(const Json& json, const std::string& file);

// The hand that holds the fibre of `start` again, row by row; `log` outlives it. It is finished
// after the last row.
std::unique_ptr<Device> logged_hand(const InputLog& log, const TrialSetup& trial);

}  // namespace ferrule
