// ferrule fit --method torch.
#pragma once

#include "app/verb.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// What only this method takes.
struct FitTorch {
  std::size_t ensemble = 1, dagger = 0;
};

void add_fit_torch(CLI::App& verb, FitTorch& arguments);
// Throws CLI::ValidationError if one of them was given.
void refuse_fit_torch(const CLI::App& verb);

int fit_torch(const DemonstrationSet& set, const std::string& folder, const std::string& out,
              const std::string& plot, std::uint64_t seed, const FitTorch& arguments, bool json);

}  // namespace ferrule
