#include "controller/c_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string_view>

namespace ferrule {
namespace {

constexpr int kTwist = HandTwist::RowsAtCompileTime;

// The observed channels that are arguments of their own.
constexpr std::span<const ObservationChannel> scalars() {
  return std::span(kObservation).subspan(kWrenchChannels);
}

// The names of the functions' own variables and other arguments.
constexpr std::string_view kTaken[] = {
    "s", "wrench", "velocity", "z",     "a",    "b",        "g",      "sum",    "speed", "i",
    "k", "column", "f",        "since", "ramp", "approach", "slowed", "beyond", "size",  "outside"};
static_assert(std::none_of(kObservation.begin(), kObservation.end(),
                           [](const auto& c) {
                             return std::find(std::begin(kTaken), std::end(kTaken), c.name) !=
                                    std::end(kTaken);
                           }),
              "a channel has the name of a variable of the C header: give it another");

// The lines about the arguments, in the header's first comment.
std::string arguments_told() {
  std::string text =
      "     wrench    felt, relative to that at rest before the start: Fx Fy Fz [N], My Mz [N m]\n";
  for (const ObservationChannel& c : scalars())
    text += fmt::format("     {:<9} {}\n", c.name, c.meaning);
  return text +
         "     velocity  of the hand until the next call: x y z [m/s], tilts about y and z "
         "[rad/s]\n";
}

// The head of ferrule_command, in lines of at most 100 characters.
std::string command_head() {
  std::vector<std::string> arguments = {fmt::format("const double wrench[{}]", kWrenchChannels)};
  for (const ObservationChannel& c : scalars())
    arguments.push_back(fmt::format("double {}", c.name));
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

// Statements that keep compilers from warning of the arguments that are not `used`.
std::string unused_arguments(const std::function<bool(const ObservationChannel&)>& used) {
  std::string text;
  for (const ObservationChannel& c : scalars())
    if (!used(c)) text += fmt::format("  (void){};\n", c.name);
  return text;
}

// The tilts that no controller commands, after the translation.
std::string no_tilts() {
  std::string text;
  for (int i = kVelocity; i < kTwist; ++i) text += fmt::format("  velocity[{}] = 0;\n", i);
  return text;
}

// By how much, and within which limits it was trained; files of before do not state it.
std::string scaling_told(const TrainedOn& trained) {
  if (!trained.scaling) return {};
  return fmt::format(
      ":\n"
      "     motions by {:.17g}, forces by {:.17g};\n"
      "     trained at up to {:g} um/s and {:g} uN, both of the tip",
      trained.scaling->motion, trained.scaling->force, 1e6 * trained.speed_limit,
      1e6 * trained.force_limit);
}

// What comes before and after the numbers and the functions of one kind of controller.
std::string framed(const std::string& origin, const TrainedOn& trained, const std::string& period,
                   const std::string& body) {
  std::string from;  // nothing that could end the comment
  for (const char c : origin) from += c >= ' ' && c < 127 && c != '/' && c != '\\' ? c : '_';
  return "/* A controller of ferrule, from " + from +
         "\n"
         "\n"
         "   Call ferrule_start before the start, then ferrule_command once per period" +
         period + ":\n" + arguments_told() +
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

template <class Number>
std::string table(const char* type, const std::string& name, const Number* values,
                  std::size_t count) {
  return fmt::format("static const {} {}[{}] = {{\n    {}}};\n", type, name, count,
                     list(values, count));
}

// The velocities of a law, g being its gains.
std::string law_body(LawKind kind) {
  const auto is = [](const char* name) {
    return [name](const ObservationChannel& c) { return std::string_view(c.name) == name; };
  };
  if (kind == LawKind::insertion)
    return R"(  const double since = time < g[1] ? time / g[1] : 1;
  const double ramp = since * since * (2 - since) * (2 - since);
  const double approach = 1 - exp((depth - g[2]) / g[3]);
  const double slowed =
      1 + g[4] * (wrench[0] * wrench[0] + wrench[1] * wrench[1] + wrench[2] * wrench[2]);
  (void)s;
)" + unused_arguments([&](const auto& c) { return is("depth")(c) || is("time")(c); }) +
           R"(  velocity[0] = -g[0] * ramp * approach / slowed + g[5] * wrench[0];
  velocity[1] = g[6] * wrench[1] + g[8] + g[10] * depth;
  velocity[2] = g[7] * wrench[2] + g[9] + g[11] * depth;
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

// The arrays of a policy's members, the calls that evaluate them, and their widest layer.
struct MembersInC {
  std::string arrays, calls;
  Eigen::Index widest;
};

MembersInC members_in_c(const Policy& policy) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  MembersInC c{{}, {}, policy.inputs()};
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    const Network& network = policy.members[m];
    std::string in = "z";
    for (std::size_t i = 0; i < network.size(); ++i) {
      const RowMajor weight = network[i].weight;
      const bool last = i + 1 == network.size();
      const Eigen::Index rows = last ? kVelocity : weight.rows();
      c.widest = std::max(c.widest, rows);
      c.arrays += table("float", fmt::format("ferrule_weight_{}_{}", m, i), weight.data(),
                        static_cast<std::size_t>(rows * weight.cols())) +
                  table("float", fmt::format("ferrule_bias_{}_{}", m, i), network[i].bias.data(),
                        static_cast<std::size_t>(rows));
      const std::string out = i % 2 ? "b" : "a";
      c.calls += fmt::format(
          "  ferrule_layer(ferrule_weight_{0}_{1}, ferrule_bias_{0}_{1}, {2}, {3}, {4}, {5}, "
          "{6});\n",
          m, i, weight.cols(), rows, in, out, last ? 0 : 1);
      in = out;
    }
    c.calls += fmt::format("  for (i = 0; i < 3; ++i) sum[i] += {}[i];\n", in);
  }
  return c;
}

// The scaled value of a scalar, channel `i` of kPolicyInputs.
std::string scaled_in_c(std::size_t i) {
  return fmt::format("(float)(({0} - ferrule_mean[{1}]) / ferrule_scale[{1}])",
                     kPolicyInputs[i].name, i);
}

// The state of a policy, its start, and one layer of its networks.
std::string policy_functions() {
  std::string names = "wrenches";
  for (std::size_t i = kWrenchChannels; i < kPastChannels; ++i)
    names += std::string(", ") + kPolicyInputs[i].name;
  return fmt::format(R"(
typedef struct {{
  float past[FERRULE_RING][{0}]; /* scaled {1} */
  int now;                     /* the newest */
}} ferrule_state;

static inline void ferrule_start(ferrule_state* s) {{
  int n, i;
  for (n = 0; n < FERRULE_RING; ++n)
    for (i = 0; i < {0}; ++i) s->past[n][i] = (float)(-ferrule_mean[i] / ferrule_scale[i]);
  s->now = 0;
}}
)",
                     kPastChannels, names) +
         R"(
static inline void ferrule_layer(const float* weight, const float* bias, int inputs, int outputs,
                                 const float* in, float* out, int hidden) {
  int r, c;
  for (r = 0; r < outputs; ++r) {
    float sum = bias[r];
    for (c = 0; c < inputs; ++c) sum += weight[r * inputs + c] * in[c];
    out[r] = hidden ? tanhf(sum) : sum;
  }
}

)";
}

// The inputs z of a policy from the arguments and the past.
std::string policy_inputs_in_c() {
  static_assert(kPastChannels >= kWrenchChannels);  // the wrench's come first
  std::string text = fmt::format(R"(  s->now = (s->now + 1) % FERRULE_RING;
  for (i = 0; i < {}; ++i)
    s->past[s->now][i] = (float)((wrench[i] - ferrule_mean[i]) / ferrule_scale[i]);
)",
                                 kWrenchChannels);
  for (std::size_t i = kWrenchChannels; i < kPastChannels; ++i)
    text += fmt::format("  s->past[s->now][{}] = {};\n", i, scaled_in_c(i));
  text += fmt::format(R"(  for (k = 0; k < FERRULE_SAMPLES; ++k) {{
    const int column = s->now - k * FERRULE_SPACING;
    for (i = 0; i < {0}; ++i) z[{0} * k + i] = s->past[column >= 0 ? column : column + FERRULE_RING][i];
  }}
)",
                      kPastChannels);
  for (std::size_t i = kPastChannels; i < kPolicyChannels; ++i)
    text += fmt::format("  z[FERRULE_INPUTS - {}] = {};\n", kPolicyChannels - i, scaled_in_c(i));
  return text;
}

}  // namespace

std::string c_header(const LawFile& file, const std::string& origin) {
  const Law law = file.law();
  const std::span<const Gain> gains = gain_table(law.kind());
  std::string body;
  for (std::size_t i = 0; i < gains.size(); ++i)
    body +=
        fmt::format("/* [{}] {}, {} [{}] */\n", i, gains[i].name, gains[i].symbol, gains[i].unit);
  body += table("double", "ferrule_gain", law.gains().data(), gains.size()) + R"(
typedef struct {
  int unused; /* this law remembers nothing */
} ferrule_state;

static inline void ferrule_start(ferrule_state* s) { s->unused = 0; }

)" + command_head() +
          "  const double* g = ferrule_gain;\n" + law_body(law.kind()) + no_tilts() + "}\n";
  return framed(origin, file.trained_on, "", body);
}

std::string c_header(const PolicyFile& file, const std::string& origin) {
  const Policy& policy = file.policy;
  const MembersInC members = members_in_c(policy);
  return framed(
      origin, file.trained_on, fmt::format(" of {:g} s", policy.period),
      table("double", "ferrule_mean", policy.mean.data(), kPolicyChannels) +
          table("double", "ferrule_scale", policy.scale.data(), kPolicyChannels) +
          table("double", "ferrule_velocity_mean", policy.velocity_mean.data(), kVelocity) +
          table("double", "ferrule_velocity_scale", policy.velocity_scale.data(), kVelocity) +
          members.arrays +
          fmt::format("\nenum {{\n"
                      "  FERRULE_SAMPLES = {},\n"
                      "  FERRULE_SPACING = {}, /* in periods */\n"
                      "  FERRULE_RING = {},\n"
                      "  FERRULE_INPUTS = {},\n"
                      "  FERRULE_WIDEST = {}\n"
                      "}};\n",
                      policy.samples, policy.spacing, (policy.samples - 1) * policy.spacing + 1,
                      policy.inputs(), members.widest) +
          policy_functions() + command_head() +
          R"(  float z[FERRULE_INPUTS], a[FERRULE_WIDEST], b[FERRULE_WIDEST];
  double sum[3] = {0, 0, 0}, speed;
  int i, k;
)" + unused_arguments([](const auto& c) { return c.policy != PolicyInput::none; }) +
          policy_inputs_in_c() + members.calls +
          fmt::format(R"(  for (i = 0; i < 3; ++i)
    velocity[i] = ferrule_velocity_mean[i] + ferrule_velocity_scale[i] * (sum[i] / {});
)",
                      policy.members.size()) +
          no_tilts() +
          fmt::format(
              R"(  speed = sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]);
  if (speed > {0:#.17g})
    for (i = 0; i < 3; ++i) velocity[i] *= {0:#.17g} / speed;
}}
)",
              policy.speed_limit));
}

std::string c_header(const SearchFile&, const std::string& origin) {
  throw BadInput(origin + ": a search by touch has no C header: laws and policies have");
}

std::string c_header(const ControllerFile& controller, const std::string& origin) {
  return std::visit([&](const auto& c) { return c_header(c, origin); }, controller);
}

}  // namespace ferrule
