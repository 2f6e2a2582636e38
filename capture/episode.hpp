// An episode: one demonstration with all that is needed to play it again, in one HDF5 file.
//
// Layout (the demonstration layout of robomimic, with exact rows beside it):
//   /                    attributes: format, format_version, ferrule_version, build, scene (JSON),
//                        operator, seed, trial, period_s, alpha_x, alpha_f, outcome, inputs_sha1
//                        (of all other attributes in CBOR, rows/command and raw/counts); for a
//                        device with raw axes: mapping (JSON); where they are known: why (what
//                        ended it), rating (1 to 5, by the operator), trainee, date and session
//                        (when it, and the sitting, began, in UTC), loop (JSON: how well a loop
//                        with a device kept its period), coupling (JSON, where the device was
//                        coupled to the holder), phases (JSON: what the operator was at, a list of
//                        [first row, name])
//   /data                attributes: total, env_args (JSON)
//   /data/demo_0         attribute: num_samples
//     rows/<block>       every block of capture/row.hpp but `states`, float64, exact
//     states             that block, float64, exact
//     actions            (N, 5) command / attribute `scale`, cut to [-1, 1]
//     rewards, dones     1 in the last row of a successful episode; 1 in the last row
//     obs/<key>          what a policy may see, in units of order one: wrench_N (N, 5) in the
//     hand's
//                        world, depth_mm (N, 1) in the hand's world, time_s (N, 1)
//     next_obs/<key>     the same one row later
//     raw/counts         (N, 6) int64, of a device with raw axes: as it counted them at t_n
//     time               (N) as rows/time: the scale of the rows' dimension, by which netCDF and
//                        xarray know it; pose, wrench, force, state, axis, value: of the columns
// Every data set has the attributes `unit`, `columns` (a list of names), `about`, and where all
// columns have one unit `units`, as CF has it. Files of format 1 have `columns` as one text and no
// scales; they are read.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/difference.hpp"
#include "capture/row.hpp"
#include "haptic/device.hpp"
#include "haptic/stability.hpp"
#include "insertion/sensed_wrench.hpp"
#include "insertion/watch.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// 1: columns as one text, no scales, no flow and air; 2: no particle; 3 and 4: with the warm start
// of the step after; to 5: the scene does not say where the fibre started. Older files are read,
// and held against what they were.
inline constexpr std::uint64_t kEpisodeFormat = 6;

struct EpisodeInfo {
  std::string scene;      // JSON text as resolved
  std::string operator_;  // "simulated, skill 0.8", a device, a controller file
  std::uint64_t seed = 0, trial = 0;
  double period = kControlPeriod;  // [s]
  Outcome outcome = Outcome::interrupted;
  std::string why;             // it ended so, where the outcome does not say it all
  std::string version, build;  // of the program that recorded it
  std::string mapping;         // mapping_text of a device with raw axes, and else empty
  std::string coupling;        // coupling_text where there is one between device and holder
  std::string phases;          // of an operator who has some, the first row of each: see above
  std::string loop;            // loop_json of a loop in time (capture/haptic_loop.hpp)
  int rating = 0;              // by the operator, 1 to 5; 0: none
  std::string inputs_sha1;     // of the file it was read from; empty where that has none
  // Of a person's: who, and when the episode and the sitting that it belongs to began, as
  // "2026-11-21T12:50:07Z"; each may be empty.
  std::string trainee, date, session;
  std::uint64_t format = kEpisodeFormat;
};

// Row n: the counts that the pose at t_n, or its rate from then on, follows from.
using CountRows = Eigen::Matrix<std::int32_t, Eigen::Dynamic, kRawAxes, Eigen::RowMajor>;

struct Episode {
  EpisodeInfo info;
  Rows rows;
  CountRows counts;  // as many as rows where there is a mapping, and else none
};

// The rows of an episode one after the other, wherever they are: in memory, in a journal, in a
// file. Of a long one the first blocks and that of the last row asked for are in memory, so that an
// hour takes no more of it than a minute, and a minute is read once. For one thread.
class EpisodeRows {
 public:
  static constexpr Eigen::Index kBlock = 8192;
  static constexpr std::size_t kKept = 8;  // blocks, 51 MB
  struct Part {
    Rows rows;
    CountRows counts;
  };
  // Rows [first, first + count): a block from a multiple of kBlock on.
  using Read = std::function<Part(Eigen::Index first, Eigen::Index count)>;

  EpisodeRows(EpisodeInfo info, Eigen::Index count, Read read);
  // `episode` must outlive it.
  EpisodeRows(const Episode& episode);

  const EpisodeInfo& info() const noexcept { return info_; }
  Eigen::Index count() const noexcept { return count_; }
  // Row n, and all of its block: until a row of another block is asked for. Throws what reading it
  // throws.
  auto row(Eigen::Index n) const { return part_of(n).rows.row(n % kBlock); }
  const Part& part_of(Eigen::Index n) const;

 private:
  EpisodeInfo info_;
  Eigen::Index count_;
  Read read_;
  mutable std::map<Eigen::Index, Part> parts_;  // by their first row
};

// The attribute `mapping`: how counts become the hand's pose (haptic/device.hpp), in JSON.
std::string mapping_text(const Mapping& mapping);
// The attribute `coupling`: {"stiffness_N_m", "damping_N_s_m"}.
std::string coupling_text(const Coupling& coupling);

// What an operator was at from a row on; the attribute `phases` is a list of these.
struct PhaseBegin {
  Eigen::Index row;
  std::string name;
};
// Adds one where `name` is another one than before.
void note_phase(std::vector<PhaseBegin>& phases, Eigen::Index row, const std::string& name);
std::string phases_text(const std::vector<PhaseBegin>& phases);  // empty where there are none
// Of an episode with so many rows. Throws FileTrouble where they are damaged.
std::vector<PhaseBegin> phases_of(const EpisodeInfo& info, Eigen::Index rows,
                                  const std::string& file);

// What period_s of an episode must be.
Rule period_rule();

// Of an episode that begins in `scene` with `device`: all that is known of any.
EpisodeInfo episode_info(const Scene& scene, const Device& device, std::uint64_t seed,
                         std::uint64_t trial);

// What was inserted, in its scene, which must outlive it. Throws BadInput where that draws parts
// that cannot be together, which no recording has.
TrialSetup recorded_setup(const EpisodeInfo& info, const Scene& scene);

// Version and build of this program.
std::string program_version();
std::string program_build();

// The holder's wrench in one row after the other, as the scene's force sensor read it, absolute and
// relative to that at rest (insertion/sensed_wrench.hpp), in the hand's world [N, N m]. The
// sensor's errors follow from the episode's seed and trial.
class RecordedSensor : public SensedWrench {
 public:
  RecordedSensor(const EpisodeInfo& info, const Scene& scene);
  void read(const RowVector& row) noexcept;
};
// In each row (N, 5).
struct SensedRows {
  Eigen::Matrix<double, Eigen::Dynamic, 5> absolute, relative;
};
SensedRows sensed_wrench(const Episode& episode, const Scene& scene);

// Writes beside `file` and gives it its name when whole. Throws FileTrouble, also if there is a
// file of that name: an episode never replaces another. `progress` is called with the rows written
// so far, and all.
using WriteProgress = std::function<void(std::size_t done, std::size_t all)>;
void write_episode(const std::string& file, const EpisodeRows& rows,
                   const WriteProgress& progress = {});

// The file again with another rating (1 to 5). Throws FileTrouble.
void rate_episode(const std::string& file, int stars);

// Now, as an episode says it.
std::string date_now();

// Throws FileTrouble (cannot be read, not an episode, damaged: names the data set and, where it
// can, the first damaged row). The file may be anybody's: it is read in a child process with limits
// (capture/child.hpp), and a row is believed only where its time is that of its number.
Episode read_episode(const std::string& file);
// The same, a block of rows at a time. Reading a row throws as well. `sha1` becomes the hash of the
// file's bytes. They are those of the file that is opened here, if its name leads to another later.
EpisodeRows open_episode(const std::string& file, std::string* sha1 = nullptr);

// The scene that the episode in `file` was recorded in. Throws BadInput.
Scene recorded_scene(const EpisodeInfo& info, const std::string& file);

// Compares every object and attribute of `file` with what an episode of its rows and its info has,
// and nothing else: data sets that follow from the rows, units, columns, types, and the hash of
// what does not follow from anything (`inputs_sha1`).
void compare_file(const std::string& file, Verification& comparison);
// The first difference.
std::optional<Difference> file_difference(const std::string& file);

// The episode files of a folder, sorted. Throws FileTrouble if there is no such folder.
std::vector<std::string> episode_files(const std::string& folder);
// Of several, each a folder or one such file.
std::vector<std::string> episode_files(const std::vector<std::string>& places);

// Of an episode or another file, without its folder.
std::string file_name(const std::string& path);

}  // namespace ferrule
