#include "sim/base/random.hpp"

#include <Random123/philox.h>

#include <cmath>
#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

// FNV-1a (Fowler, Noll and Vo), with the highest bit set: no Draw has it.
Draw stream_of(std::string_view key) noexcept {
  std::uint32_t hash = 2166136261u;
  for (const char c : key) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return static_cast<Draw>(hash | 0x80000000u);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t trial, Draw draw) noexcept
    : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
      counter_{0, static_cast<std::uint32_t>(draw), static_cast<std::uint32_t>(trial),
               static_cast<std::uint32_t>(trial >> 32)} {}

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t trial, std::string_view key) noexcept
    : RandomStream(seed, trial, stream_of(key)) {}

std::array<std::uint32_t, 4> RandomStream::block() noexcept {
  const r123::Philox4x32::ctr_type counter{{counter_[0], counter_[1], counter_[2], counter_[3]}};
  const r123::Philox4x32::key_type key{{key_[0], key_[1]}};
  const auto block = r123::Philox4x32()(counter, key);
  ++counter_[0];
  return {block[0], block[1], block[2], block[3]};
}

std::uint64_t RandomStream::bits() noexcept {
  const auto words = block();
  return (static_cast<std::uint64_t>(words[1]) << 32) | words[0];
}

double RandomStream::uniform() noexcept {
  return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53;
}

double RandomStream::normal() noexcept {
  const double radius = std::sqrt(-2 * elementary::log(uniform()));
  return radius * elementary::cos(2 * std::numbers::pi * uniform());
}

}  // namespace ferrule
