#include "controller/c_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace ferrule {
namespace {

// The observed channels that are arguments of their own.
constexpr std::span<const ObservationChannel> scalars() {
  return std::span(kObservation).subspan(kWrenchChannels);
}

// The names of the functions' own variables and other arguments.
constexpr std::string_view kTaken[] = {
    "s",      "wrench", "velocity", "z",       "a", "b",     "g",    "sum",
    "speed",  "i",      "k",        "column",  "f", "since", "ramp", "approach",
    "slowed", "beyond", "size",     "outside", "h", "in",    "past", "displacement",
    "height"};
static_assert(std::none_of(kObservation.begin(), kObservation.end(),
                           [](const auto& c) {
                             return std::find(std::begin(kTaken), std::end(kTaken), c.name) !=
                                    std::end(kTaken);
                           }),
              "a channel has the name of a variable of the C header: give it another");

// The lines about the arguments, in the header's first comment; with those of one that remembers.
std::string arguments_told(bool remembers) {
  std::string text =
      "     wrench    felt, relative to that at rest before the start: Fx Fy Fz [N], My Mz [N m]\n";
  for (const ObservationChannel& c : scalars())
    text += fmt::format("     {:<9} {}\n", c.name, c.meaning);
  if (remembers)
    text +=
        "     displacement  of the hand since the start: x y z [m], tilts about y and z [rad]\n"
        "     height    of the hand before the bore's entrance [m], < 0 past it\n";
  return text +
         "     velocity  of the hand until the next call: x y z [m/s], tilts about y and z "
         "[rad/s]\n";
}

// By how much, and within which limits it was trained, where its file states them.
std::string scaling_told(const TrainedOn& trained) {
  if (!trained.scaling) return {};
  std::string text = fmt::format(":\n     motions by {:.17g}, forces by {:.17g}",
                                 trained.scaling->motion, trained.scaling->force);
  if (trained.speed_limit > 0)
    text += fmt::format(";\n     trained at up to {:g} um/s and {:g} uN, both of the tip",
                        1e6 * trained.speed_limit, 1e6 * trained.force_limit);
  return text;
}

std::string list(const double* values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += fmt::format("{}{:#.17g}", i == 0 ? "" : i % 4 == 0 ? ",\n    " : ", ", values[i]);
  return text;
}

std::string list(const float* values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += fmt::format("{}{:#.9g}f", i == 0 ? "" : i % 8 == 0 ? ",\n    " : ", ", values[i]);
  return text;
}

}  // namespace

std::string command_head(bool remembers) {
  std::vector<std::string> arguments = {fmt::format("const double wrench[{}]", kWrenchChannels)};
  for (const ObservationChannel& c : scalars())
    arguments.push_back(fmt::format("double {}", c.name));
  if (remembers)
    arguments.insert(arguments.end(), {fmt::format("const double displacement[{}]", kTwist),
                                       std::string("double height")});
  arguments.push_back(fmt::format("double velocity[{}]) {{", kTwist));
  std::string line = "static inline void ferrule_command(ferrule_state* s", text;
  const std::string indent(line.find('(') + 1, ' ');
  for (const std::string& argument : arguments) {
    line += ",";
    if (line.size() + 1 + argument.size() + 1 > 100) {
      text += line + "\n";
      line = indent + argument;
    } else {
      line += " " + argument;
    }
  }
  return text + line + "\n";
}

std::string unused_arguments(const std::function<bool(const ObservationChannel&)>& used) {
  std::string text;
  for (const ObservationChannel& c : scalars())
    if (!used(c)) text += fmt::format("  (void){};\n", c.name);
  return text;
}

std::string no_tilts(int answers) {
  std::string text;
  for (int i = answers; i < kTwist; ++i) text += fmt::format("  velocity[{}] = 0;\n", i);
  return text;
}

std::string framed(const std::string& origin, const TrainedOn& trained, const std::string& period,
                   const std::string& body, bool remembers) {
  std::string from;  // nothing that could end the comment
  for (const char c : origin) from += c >= ' ' && c < 127 && c != '/' && c != '\\' ? c : '_';
  return "/* A controller of ferrule, from " + from +
         "\n"
         "\n"
         "   Call ferrule_start before the start, then ferrule_command once per period" +
         period + ":\n" + arguments_told(remembers) +
         "   All in the hand's world: forces and motions of the tip, scaled up" +
         scaling_told(trained) +
         ". */\n"
         "#ifndef FERRULE_CONTROLLER_H\n"
         "#define FERRULE_CONTROLLER_H\n"
         "\n"
         "#include <math.h>\n"
         "\n" +
         body +
         "\n"
         "#endif\n";
}

std::string table(const std::string& name, const double* values, std::size_t count) {
  return fmt::format("static const double {}[{}] = {{\n    {}}};\n", name, count,
                     list(values, count));
}

std::string table(const std::string& name, const float* values, std::size_t count) {
  return fmt::format("static const float {}[{}] = {{\n    {}}};\n", name, count,
                     list(values, count));
}

}  // namespace ferrule
