// Controllers that a verb is given: files of any kind, and programs of somebody else's.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/verb.hpp"
#include "controller/controller_file.hpp"
#include "controller/trial.hpp"

namespace ferrule {

// How policies of somebody else's are asked: --policy, --policy-hz, --policy-timeout.
struct PolicyArguments {
  std::string command;  // of a program; empty: none
  double hz = 1000, timeout = 10;

  void add_to(CLI::App& verb);
  // Periods of the simulation from one question to the next. Throws BadInput where they are broken.
  std::uint64_t periods() const;
};

struct GivenController {
  std::string name;                    // the file or the command
  MakeController make;                 // asked in every period
  std::optional<ControllerFile> file;  // empty: somebody else's
  std::uint64_t periods = 1;           // from one answer of its own to the next
};

// What fit wrote, or TorchScript (*.pt), for trials under `seed`. Throws FileTrouble, BadInput.
GivenController given_file(const std::string& file, const PolicyArguments& how, std::uint64_t seed);
// Without demonstrations: straight in at constant velocity, as fast as the scene lets it, a blind
// spiral (controller/blind_spiral.hpp), or an operator of skill 0.8 who finds the bore by touch
// (controller/searching_operator.hpp).
inline constexpr const char *kStraight = "constant-velocity", *kSpiral = "spiral",
                            *kSearching = "searching-operator";
bool is_baseline(const std::string& name);
// In trials under `seed`.
MakeController baseline(const std::string& name, const Scene& scene, std::uint64_t seed);
// The program of --policy, for trials under `seed`.
GivenController given_program(const PolicyArguments& how, std::uint64_t seed);

// Why trials ended in which somebody else's failed, and how many of each.
std::map<std::string, std::size_t> failures(const std::vector<TrialResult>& results);
// Adds that to a row of JSON, where there are any; of CSV, whose columns are always the same, as
// one text.
void add_failures(const std::vector<TrialResult>& results, const Output& output, Json& row);
// Says it on stderr.
void tell_failures(const std::string& name, const std::vector<TrialResult>& results);
// Throws BadInput where it failed wherever it was asked.
void refuse_if_all_failed(const std::string& name, const std::vector<TrialResult>& results);

}  // namespace ferrule
