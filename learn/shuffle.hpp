// Episodes in an order drawn by chance, for splitting or choosing among them.
#pragma once

#include <numeric>
#include <utility>
#include <vector>

#include "sim/base/random.hpp"

namespace ferrule {

// A permutation of 0 to n - 1.
inline std::vector<std::size_t> shuffled(std::size_t n, std::uint64_t seed) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  RandomStream random(seed, 0, Draw::split);
  for (std::size_t i = n; i-- > 1;) std::swap(order[i], order[random.bits() % (i + 1)]);
  return order;
}

}  // namespace ferrule
