// A learner: from demonstrations to a controller. What `ferrule fit` and `ferrule compare` need of
// each is one row of the table in learn/candidates.cpp.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "controller/controller_file.hpp"
#include "learn/demonstrations.hpp"
#include "learn/torch_policy.hpp"

namespace ferrule {

// An option of `ferrule fit` that one learner takes.
struct LearnerOption {
  const char* flag;
  const char* help;
  std::string value;                 // unless it is given
  std::vector<std::string> choices;  // what it may be; empty: a whole number from `least` to `most`
  std::size_t least = 0, most = 0;
  static constexpr std::size_t kSeed = INT64_MAX;  // as `most`: it is a seed
};

struct LearnerSettings {
  std::uint64_t seed = 1;  // of the split into training and held-out episodes, and of what is drawn
  std::map<std::string, std::string> options{};  // the value of each of the learner's, by flag

  std::size_t number(const char* flag) const { return std::stoul(options.at(flag), nullptr, 0); }
};

struct Learned {
  ControllerFile controller;
  std::string report;                        // lines for people
  std::vector<std::vector<Epoch>> curves{};  // the training of each network, if there are any
};

// `done` steps of `all`; `note`: how it goes. False ends the learning with the best so far, marked
// as partial (TrainedOn).
using LearnerProgress =
    std::function<bool(std::size_t done, std::size_t all, const std::string& note)>;

struct Learner {
  const char* name;    // what it learns
  const char* method;  // the same in controller files
  std::vector<LearnerOption> options;
  // What `ferrule compare` sets side by side: the key of each, its name in tables, and the options
  // that are not as they are unless given.
  struct Variant {
    std::string key, name;
    std::map<std::string, std::string> options;
  };
  std::vector<Variant> variants;
  // Options with which what it learns has no memory; empty: its form is fixed, and no network's.
  std::map<std::string, std::string> memoryless{};
  // The files that it writes for a controller `file`. Throws BadInput where that name will not do.
  std::vector<std::string> (*files)(const std::string& file);
  // Throws BadInput where the demonstrations are too few or tell nothing.
  Learned (*learn)(const DemonstrationSet& set, const LearnerSettings& settings,
                   const LearnerProgress& progress);
  bool drawn = true;  // whether there is a plot of what it learned
};

}  // namespace ferrule
