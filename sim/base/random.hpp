// Random numbers from a counter-based generator (Philox4x32-10, Salmon et al. 2011) keyed by
// (seed, trial): trial k is trial k on any thread, rank or shard.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace ferrule {

// What a stream of numbers is for; streams of one trial are independent.
enum class Draw : std::uint32_t {
  start = 0,
  operator_hand = 1,
  split = 2,
  plan = 3,
  sensor = 4,
  parts = 5,
  operator_eye = 6,
  entrance = 7,
  roll = 8,
  bore = 9,
  particle = 10,
  concentricity = 11,
  mating = 12,
  bootstrap = 13
};

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t trial, Draw draw) noexcept;
  // For the number of a dotted key: whatever else is drawn, it is drawn alike.
  RandomStream(std::uint64_t seed, std::uint64_t trial, std::string_view key) noexcept;

  std::uint64_t bits() noexcept;
  // Uniform in (0, 1).
  double uniform() noexcept;
  // Standard normal (Box and Muller 1958).
  double normal() noexcept;

  // The bits as the distributions of libraries take them.
  using result_type = std::uint64_t;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return ~result_type{0}; }
  result_type operator()() noexcept { return bits(); }

 private:
  friend class RandomWords;
  std::array<std::uint32_t, 4> block() noexcept;

  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
};

// The bits of a stream in words, four for the price of one: for much chance of few digits.
class RandomWords {
 public:
  explicit RandomWords(const RandomStream& stream) noexcept : stream_(stream) {}

  using result_type = std::uint32_t;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return ~result_type{0}; }
  result_type operator()() noexcept {
    if (next_ == words_.size()) {
      words_ = stream_.block();
      next_ = 0;
    }
    return words_[next_++];
  }

 private:
  RandomStream stream_;
  std::array<std::uint32_t, 4> words_{};
  std::size_t next_ = words_.size();
};

}  // namespace ferrule
