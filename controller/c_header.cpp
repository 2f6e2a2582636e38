#include "controller/c_header.hpp"

#include <fmt/format.h>

#include <string_view>

#include "controller/c_text.hpp"

namespace ferrule {

extern const std::string_view kSearchInC;  // the files of controller/search, by CMakeLists.txt

namespace {

// The velocities of a law, g being its gains.
std::string law_body(LawKind kind) {
  const auto is = [](const char* name) {
    return [name](const ObservationChannel& c) { return std::string_view(c.name) == name; };
  };
  const bool guarded = kind == LawKind::guarded;
  if (is_insertion_law(kind))
    return R"(  const double since = time < g[1] ? time / g[1] : 1;
  const double ramp = since * since * (2 - since) * (2 - since);
  const double approach = 1 - exp((depth - g[2]) / g[3]);
  const double slowed =
      1 + g[4] * (wrench[0] * wrench[0] + wrench[1] * wrench[1] + wrench[2] * wrench[2]);
  (void)s;
)" + unused_arguments([&](const auto& c) { return is("depth")(c) || is("time")(c); }) +
           (guarded ? "  const double* yield = depth > 0 ? g + 12 : g + 6;\n"
                    : "  const double* yield = g + 6;\n") +
           R"(  velocity[0] = -g[0] * ramp * approach / slowed + g[5] * wrench[0];
  velocity[1] = yield[0] * wrench[1] + g[8] + g[10] * depth;
  velocity[2] = yield[1] * wrench[2] + g[9] + g[11] * depth;
)";
  std::string body = "  int i;\n  (void)s;\n" +
                     unused_arguments([](const auto&) { return false; }) +
                     "  for (i = 0; i < 3; ++i) {\n";
  body += kind == LawKind::saturated ? R"(    const double beyond = fabs(wrench[i]) - g[13];
    const double size = beyond > 0 ? beyond / (1 + g[14] * beyond) : 0;
    const double f = wrench[i] < 0 ? -size : size;
)"
                                     : "    const double f = wrench[i];\n";
  body += kind == LawKind::linear ? "    velocity[i] = g[i] + g[3 + i] * f;\n"
                                  : R"(    const double outside = exp(-depth / g[6]);
    velocity[i] = outside * (g[i] + g[3 + i] * f) + (1 - outside) * (g[7 + i] + g[10 + i] * f);
)";
  return body + "  }\n";
}

// The rates of tilt of a law that tilts.
std::string tilts(LawKind kind) {
  std::string body;
  for (std::size_t k = 0; k < kTiltGains.size(); ++k)
    body += fmt::format("  velocity[{0}] = g[{1}] * wrench[{0}];\n", 3 + k,
                        gain_table(kind).size() + k);
  return body;
}

}  // namespace

std::string c_header(const LawFile& file, const std::string& origin) {
  const Law law = file.law();
  std::string body;
  for (std::size_t i = 0; i < law.gains().size(); ++i) {
    const Gain& gain = gain_of(law.kind(), i);
    body += fmt::format("/* [{}] {}, {} [{}] */\n", i, gain.name, gain.symbol, gain.unit);
  }
  body += table("ferrule_gain", law.gains().data(), law.gains().size()) + R"(
typedef struct {
  int unused; /* this law remembers nothing */
} ferrule_state;

static inline void ferrule_start(ferrule_state* s) { s->unused = 0; }

)" + command_head() +
          "  const double* g = ferrule_gain;\n" + law_body(law.kind()) +
          (law.tilts() ? tilts(law.kind()) : no_tilts()) + "}\n";
  return framed(origin, file.trained_on, "", body);
}

std::string c_header(const SearchFile& file, const std::string& origin) {
  std::string body = fmt::format(
      "#include <stdbool.h>\n#include <string.h>\n\n{}\n"
      "static const ferrule_numbers ferrule_gain = {{\n",
      kSearchInC);
  for (std::size_t i = 0; i < kSearchGains.size(); ++i)
    body += fmt::format("    .{} = {:#.17g}, /* {} [{}] */\n", kSearchGains[i].name, file.gains[i],
                        kSearchGains[i].symbol, kSearchGains[i].unit);
  body += R"(};

typedef ferrule_search ferrule_state;

static inline void ferrule_start(ferrule_state* s) { ferrule_search_start(s, &ferrule_gain, NULL); }

)" + command_head(true) +
          R"(  const ferrule_observed o = {
      {wrench[0], {wrench[1], wrench[2]}, {wrench[3], wrench[4]}},
      {displacement[0], {displacement[1], displacement[2]}, {displacement[3], displacement[4]}},
      height,
      time,
      INFINITY};
  const ferrule_axes v = ferrule_search_command(s, o);
  (void)depth;
  velocity[0] = v.x;
  velocity[1] = v.across.y;
  velocity[2] = v.across.z;
  velocity[3] = v.about.y;
  velocity[4] = v.about.z;
}
)";
  return framed(origin, file.trained_on, " of 1 ms", body, true);
}

std::string c_header(const ControllerFile& controller, const std::string& origin) {
  return std::visit([&](const auto& c) { return c_header(c, origin); }, controller);
}

}  // namespace ferrule
