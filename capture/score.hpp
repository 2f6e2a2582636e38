// How good an insertion was: what an episode's rows say about the operator's skill, each measure
// against a yardstick that is fixed by the scene, a total, and where most of it was lost.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "capture/episode.hpp"
#include "insertion/phase.hpp"

namespace ferrule {

// Measures of one episode, at the tip's scale, all rows unless said otherwise. For all of them less
// is better.
enum class Part {
  time,           // from the start until the success depth is reached, or to the end [s]
  peak_force,     // largest at the holder, weight apart [N]
  mean_force,     // over the time in contact, weight apart [N]; 0 without contact
  friction_work,  // against the friction of all contacts together [J]
  smoothness,     // minus the spectral arc length of the hand's speed, over the same time [-], > 0
  corrections,    // movements along x after the first [-]
  contact_time,   // with the end or the side touching [s]
};
inline constexpr std::size_t kParts = 7;
inline constexpr std::array<const char*, kParts> kPartNames = {
    "time",       "peak_force",  "mean_force",  "friction_work",
    "smoothness", "corrections", "contact_time"};

struct Measures {
  std::array<double, kParts> parts;
  Outcome outcome;
  double completion;  // inserted length over the success depth, largest [-], 0 to 1
  // Of the way from where it started to the success depth, the largest part that was done [-].
  double progress = 0;
  // What of each part came about in which phase: time, work and contact [s, J], beginnings of
  // movements after the first, and the largest force [N].
  std::array<std::array<double, kPhases.size()>, kParts> by_phase{};
  // Where the force was largest in each phase: how far the hand was off the axis
  // (insertion/phase.hpp) [m]. And the clearance of fibre and bore [m].
  std::array<double, kPhases.size()> off_axis{};
  double clearance = 0;
  double touched_off_axis = 0;  // the same where end or side touched first [m]; 0: they never did

  double operator[](Part part) const noexcept { return parts[static_cast<std::size_t>(part)]; }
};

// Of an episode recorded in `scene`.
Measures measure(const EpisodeRows& episode, const Scene& scene);

// Spectral arc length SPARC of a speed profile sampled every `period` [s] (Balasubramanian,
// Melendez-Calderon, Roby-Brami and Burdet 2015, "On the analysis of movement smoothness"):
//   -integral from 0 to f_c of sqrt((1/f_c)^2 + (d V/d f)^2) df
// with V the spectrum divided by its value at 0, the speed padded with zeros to 16 times the next
// power of two of its length, and f_c the last frequency up to 20 Hz at which V >= 0.05. The
// authors' 10 Hz would cut through the band of physiological tremor (8 to 12 Hz), so that chance
// decides whether a hand's tremor counts; with 20 Hz all of it counts where it is above the
// threshold. The result is < 0, or 0 where nothing moves. It does not depend on the profile's
// amplitude, nor on its duration while the spectrum stays below 20 Hz.
double spectral_arc_length(const Eigen::Ref<const Eigen::VectorXd>& speed, double period);

// Movements of an axial velocity [m/s] sampled every `period` [s]: averaged over 0.2 s, which takes
// tremor out; one begins when the speed exceeds a fifth of `limit` [m/s] and ends when it falls
// below a tenth of it or changes sign.
int movements(const Eigen::VectorXd& velocity, double limit, double period);

// What a skilled operator takes in a scene: the median of each part over kReferences insertions by
// a simulated one of skill 1 from starts of the scene's own, which are always the same.
struct Yardstick {
  std::array<double, kParts> parts;
};
inline constexpr int kReferences = 3;
// `scene` as it is written, before parts are drawn. Takes about a second. Empty where the simulated
// operator does not succeed either: there is nothing to measure by.
std::optional<Yardstick> yardstick(const Scene& scene);

struct Score {
  // yardstick / own of each part, at most 1 (movements instead of corrections, so that none divides
  // by 0). NaN for what was not shown: of a fibre that never touched, all about contact.
  std::array<double, kParts> parts;
  // Inserted: 100 times the mean of the parts that were shown. Otherwise 50 times the progress and
  // the mean of all, with 0 for time and for what was not shown.
  double total;
};

Score score(const Measures& episode, const Yardstick& yardstick);

// What cost it most, as what the hand did, why, and what it should do instead: "you pushed on the
// cone with 35 uN after you touched 12 um off the axis: correct sideways first". Empty where
// nothing cost anything worth saying (a tenth of a part). Of a failure not the time, unless it
// never touched.
std::string hint(const Measures& episode, const Score& score);

}  // namespace ferrule
