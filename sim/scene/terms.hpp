// The table of force terms: what readers of scenes, planner, tables and plots know of each. Its
// rows are in the order of `Term` (sim/laws/laws.hpp); a new law is a new row.
#pragma once

#include <string>

#include "sim/scene/scene.hpp"

namespace ferrule {

struct TermInfo {
  const char* name;   // in scenes, files and tables
  const char* label;  // in plots
  bool printed;       // does the paper print it?
  // Reads the law from the scene's laws.NAME; throws BadInput. Null for the wall, which is no
  // choice of the scene.
  void (*read)(JsonFields fields, Scene& scene);
  bool (*present)(const Laws& laws) noexcept;
  void (*leave_out)(Laws& laws) noexcept;
  std::string (*fidelity)(const World& world);  // how it is computed, of a world that has it
};

const TermInfo& info(Term term) noexcept;

}  // namespace ferrule
