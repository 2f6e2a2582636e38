// Controllers that a verb is given: files of any kind, and programs of somebody else's.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/output.hpp"
#include "controller/baseline.hpp"
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
  std::string name;                                // the name, the file or the command
  std::function<MakeController(const Scene&)> in;  // in trials of a scene; asked in every period
  std::optional<ControllerFile> file;              // empty: it is not one of ours
  std::uint64_t periods = 1;                       // from one answer of its own to the next
  std::string read{};                              // the file that it is in; empty: none
};

// What every verb takes as a controller.
inline constexpr const char* kControllers =
    "Controller: a file, a shipped one (search, tuned_by_hand), TorchScript, constant-velocity, "
    "spiral, or searching-operator";
inline constexpr const char* kControllerType = "NAME|FILE.json|FILE.pt";

// Of any of these, for trials under `seed`. Throws FileTrouble, BadInput.
GivenController given_controller(const std::string& name, const PolicyArguments& how,
                                 std::uint64_t seed);
// Of a file that fit wrote, or of a shipped one; of others throws BadInput with `why` they will not
// do.
ControllerFile own_controller(const std::string& name, const std::string& why);
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
