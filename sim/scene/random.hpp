// Random numbers from a counter-based generator (Philox4x32-10, Salmon et al. 2011) keyed by
// (seed, trial): trial k is trial k on any thread, rank or shard.
#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>
#include <numbers>

namespace ferrule {

// What a stream of numbers is for; streams of one trial are independent.
enum class Draw : std::uint32_t {
  start = 0,
  operator_hand = 1,
  split = 2,
  plan = 3,
  sensor = 4,
  parts = 5
};

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t trial, Draw draw) noexcept
      : key_{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}},
        counter_{{0, static_cast<std::uint32_t>(draw), static_cast<std::uint32_t>(trial),
                  static_cast<std::uint32_t>(trial >> 32)}} {}

  std::uint64_t bits() noexcept {
    const auto block = r123::Philox4x32()(counter_, key_);
    ++counter_[0];
    return (static_cast<std::uint64_t>(block[1]) << 32) | block[0];
  }

  // Uniform in (0, 1).
  double uniform() noexcept { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; }

  // Standard normal (Box and Muller 1958).
  double normal() noexcept {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
};

}  // namespace ferrule
