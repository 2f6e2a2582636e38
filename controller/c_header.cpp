#include "controller/c_header.hpp"

#include <fmt/format.h>

namespace ferrule {
namespace {

// What comes before and after the numbers and the functions of one kind of controller.
std::string framed(const std::string& origin, const std::string& period, const std::string& body) {
  std::string told;  // nothing that could end the comment
  for (const char c : origin) told += c >= ' ' && c < 127 && c != '/' && c != '\\' ? c : '_';
  return "/* A controller of ferrule, from " + told +
         "\n"
         "\n"
         "   Call ferrule_start before the start, then ferrule_command once per period" +
         period +
         ":\n"
         "     wrench    felt, relative to that at rest before the start: Fx Fy Fz [N], My Mz [N "
         "m]\n"
         "     depth     of the hand past the bore's entrance [m], >= 0\n"
         "     time      since the start [s]\n"
         "     velocity  of the hand until the next call: x y z [m/s], tilts about y and z "
         "[rad/s]\n"
         "   All in the hand's world: forces and motions of the tip, scaled up. */\n"
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

}  // namespace

std::string c_header(const Law& law, const std::string& origin) {
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

static inline void ferrule_command(ferrule_state* s, const double wrench[5], double depth,
                                   double time, double velocity[5]) {
  const double* g = ferrule_gain;
)";
  if (law.kind() == LawKind::insertion) {
    body += R"(  const double since = time < g[1] ? time / g[1] : 1;
  const double ramp = since * since * (2 - since) * (2 - since);
  const double approach = 1 - exp((depth - g[2]) / g[3]);
  const double slowed =
      1 + g[4] * (wrench[0] * wrench[0] + wrench[1] * wrench[1] + wrench[2] * wrench[2]);
  (void)s;
  velocity[0] = -g[0] * ramp * approach / slowed + g[5] * wrench[0];
  velocity[1] = g[6] * wrench[1] + g[8] + g[10] * depth;
  velocity[2] = g[7] * wrench[2] + g[9] + g[11] * depth;
)";
  } else {
    body += "  int i;\n  (void)s;\n  (void)depth;\n  (void)time;\n  for (i = 0; i < 3; ++i) {\n";
    body += law.kind() == LawKind::saturated ? R"(    const double beyond = fabs(wrench[i]) - g[13];
    const double size = beyond > 0 ? beyond / (1 + g[14] * beyond) : 0;
    const double f = wrench[i] < 0 ? -size : size;
)"
                                             : "    const double f = wrench[i];\n";
    body += law.kind() == LawKind::linear ? "    velocity[i] = g[i] + g[3 + i] * f;\n"
                                          : R"(    const double outside = exp(-depth / g[6]);
    velocity[i] = outside * (g[i] + g[3 + i] * f) + (1 - outside) * (g[7 + i] + g[10 + i] * f);
)";
    body += "  }\n";
  }
  return framed(origin, "", body + "  velocity[3] = 0;\n  velocity[4] = 0;\n}\n");
}

std::string c_header(const Policy& policy, const std::string& origin) {
  std::string body =
      table("double", "ferrule_mean", policy.mean.data(), kInputs) +
      table("double", "ferrule_scale", policy.scale.data(), kInputs) +
      table("double", "ferrule_velocity_mean", policy.velocity_mean.data(), kVelocity) +
      table("double", "ferrule_velocity_scale", policy.velocity_scale.data(), kVelocity);
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::string members;
  Eigen::Index widest = policy.inputs();
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    const Network& network = policy.members[m];
    std::string in = "z";
    for (std::size_t i = 0; i < network.size(); ++i) {
      const RowMajor weight = network[i].weight;
      const bool last = i + 1 == network.size();
      const Eigen::Index rows = last ? kVelocity : weight.rows();
      widest = std::max(widest, rows);
      body += table("float", fmt::format("ferrule_weight_{}_{}", m, i), weight.data(),
                    static_cast<std::size_t>(rows * weight.cols())) +
              table("float", fmt::format("ferrule_bias_{}_{}", m, i), network[i].bias.data(),
                    static_cast<std::size_t>(rows));
      const std::string out = i % 2 ? "b" : "a";
      members += fmt::format(
          "  ferrule_layer(ferrule_weight_{0}_{1}, ferrule_bias_{0}_{1}, {2}, {3}, {4}, {5}, "
          "{6});\n",
          m, i, weight.cols(), rows, in, out, last ? 0 : 1);
      in = out;
    }
    members += fmt::format("  for (i = 0; i < 3; ++i) sum[i] += {}[i];\n", in);
  }
  return framed(
      origin, fmt::format(" of {:g} s", policy.period),
      body +
          fmt::format("\nenum {{\n"
                      "  FERRULE_SAMPLES = {},\n"
                      "  FERRULE_SPACING = {}, /* in periods */\n"
                      "  FERRULE_RING = {},\n"
                      "  FERRULE_INPUTS = {},\n"
                      "  FERRULE_WIDEST = {}\n"
                      "}};\n",
                      policy.samples, policy.spacing, (policy.samples - 1) * policy.spacing + 1,
                      policy.inputs(), widest) +
          R"(
typedef struct {
  float past[FERRULE_RING][5]; /* scaled wrenches */
  int now;                     /* the newest */
} ferrule_state;

static inline void ferrule_start(ferrule_state* s) {
  int n, i;
  for (n = 0; n < FERRULE_RING; ++n)
    for (i = 0; i < 5; ++i) s->past[n][i] = (float)(-ferrule_mean[i] / ferrule_scale[i]);
  s->now = 0;
}

static inline void ferrule_layer(const float* weight, const float* bias, int inputs, int outputs,
                                 const float* in, float* out, int hidden) {
  int r, c;
  for (r = 0; r < outputs; ++r) {
    float sum = bias[r];
    for (c = 0; c < inputs; ++c) sum += weight[r * inputs + c] * in[c];
    out[r] = hidden ? tanhf(sum) : sum;
  }
}

static inline void ferrule_command(ferrule_state* s, const double wrench[5], double depth,
                                   double time, double velocity[5]) {
  float z[FERRULE_INPUTS], a[FERRULE_WIDEST], b[FERRULE_WIDEST];
  double sum[3] = {0, 0, 0}, speed;
  int i, k;
  (void)time;
  s->now = (s->now + 1) % FERRULE_RING;
  for (i = 0; i < 5; ++i)
    s->past[s->now][i] = (float)((wrench[i] - ferrule_mean[i]) / ferrule_scale[i]);
  for (k = 0; k < FERRULE_SAMPLES; ++k) {
    const int column = s->now - k * FERRULE_SPACING;
    for (i = 0; i < 5; ++i) z[5 * k + i] = s->past[column >= 0 ? column : column + FERRULE_RING][i];
  }
  z[FERRULE_INPUTS - 1] = (float)((depth - ferrule_mean[5]) / ferrule_scale[5]);
)" + members +
          fmt::format(
              R"(  for (i = 0; i < 3; ++i)
    velocity[i] = ferrule_velocity_mean[i] + ferrule_velocity_scale[i] * (sum[i] / {});
  velocity[3] = 0;
  velocity[4] = 0;
  speed = sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]);
  if (speed > {:#.17g})
    for (i = 0; i < 3; ++i) velocity[i] *= {:#.17g} / speed;
}}
)",
              policy.members.size(), policy.speed_limit, policy.speed_limit));
}

}  // namespace ferrule
