#include <fmt/format.h>

#include <algorithm>

#include "controller/c_header.hpp"
#include "controller/c_text.hpp"

namespace ferrule {
namespace {

// The arrays of a policy's members, the calls that evaluate them, and their widest layer.
struct MembersInC {
  std::string arrays, calls;
  Eigen::Index widest;
};

MembersInC members_in_c(const Policy& policy) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  MembersInC c{{}, {}, policy.inputs()};
  const auto add = [&](const std::string& name, const RowMajor& numbers) {
    c.arrays += table(name, numbers.data(), static_cast<std::size_t>(numbers.size()));
  };
  for (std::size_t m = 0; m < policy.memories.size(); ++m) {
    const Gru& gru = policy.memories[m];
    add(fmt::format("ferrule_input_weight_{}", m), gru.input_weight);
    add(fmt::format("ferrule_input_bias_{}", m), gru.input_bias);
    add(fmt::format("ferrule_memory_weight_{}", m), gru.memory_weight);
    add(fmt::format("ferrule_memory_bias_{}", m), gru.memory_bias);
  }
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    const Network& network = policy.members[m];
    std::string in = "z";
    if (!policy.memories.empty()) {
      in = fmt::format("s->memory[{}]", m);
      c.calls += fmt::format(
          "  ferrule_remember(ferrule_input_weight_{0}, ferrule_input_bias_{0}, "
          "ferrule_memory_weight_{0}, ferrule_memory_bias_{0}, z, {1});\n",
          m, in);
    }
    for (std::size_t i = 0; i < network.size(); ++i) {
      const RowMajor weight = network[i].weight;
      const bool last = i + 1 == network.size();
      const Eigen::Index rows = last ? policy.answers() : weight.rows();
      c.widest = std::max(c.widest, rows);
      c.arrays += table(fmt::format("ferrule_weight_{}_{}", m, i), weight.data(),
                        static_cast<std::size_t>(rows * weight.cols())) +
                  table(fmt::format("ferrule_bias_{}_{}", m, i), network[i].bias.data(),
                        static_cast<std::size_t>(rows));
      const std::string out = i % 2 ? "b" : "a";
      c.calls += fmt::format(
          "  ferrule_layer(ferrule_weight_{0}_{1}, ferrule_bias_{0}_{1}, {2}, {3}, {4}, {5}, "
          "{6});\n",
          m, i, weight.cols(), rows, in, out, last ? 0 : 1);
      in = out;
    }
    c.calls += fmt::format("  for (i = 0; i < {}; ++i) sum[i] += {}[i];\n", policy.answers(), in);
  }
  return c;
}

// The scaled value of a scalar, channel `i` of kPolicyInputs.
std::string scaled_in_c(std::size_t i) {
  return fmt::format("(float)(({0} - ferrule_mean[{1}]) / ferrule_scale[{1}])",
                     kPolicyInputs[i].name, i);
}

// One layer of a network.
constexpr const char* kLayerInC = R"(
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
         kLayerInC;
}

// The same of one with a memory.
std::string memory_functions() {
  return std::string(R"(
typedef struct {
  float memory[FERRULE_MEMBERS][FERRULE_UNITS];
  double velocity[5]; /* the last answer */
  int periods;        /* since then */
} ferrule_state;

static inline void ferrule_start(ferrule_state* s) {
  int m, i;
  for (m = 0; m < FERRULE_MEMBERS; ++m)
    for (i = 0; i < FERRULE_UNITS; ++i) s->memory[m][i] = 0;
  s->periods = 0;
}
)") + kLayerInC +
         R"(/* A gated recurrent unit: the rows of the reset gate, of the update gate, of what is new. */
static inline void ferrule_remember(const float* input_weight, const float* input_bias,
                                    const float* memory_weight, const float* memory_bias,
                                    const float* z, float* h) {
  float in[3 * FERRULE_UNITS], past[3 * FERRULE_UNITS];
  int i;
  ferrule_layer(input_weight, input_bias, FERRULE_INPUTS, 3 * FERRULE_UNITS, z, in, 0);
  ferrule_layer(memory_weight, memory_bias, FERRULE_UNITS, 3 * FERRULE_UNITS, h, past, 0);
  for (i = 0; i < 2 * FERRULE_UNITS; ++i) in[i] = 0.5f + 0.5f * tanhf(0.5f * (in[i] + past[i]));
  for (i = 0; i < FERRULE_UNITS; ++i) {
    const float f = in[FERRULE_UNITS + i];
    h[i] = (1 - f) * tanhf(in[2 * FERRULE_UNITS + i] + in[i] * past[2 * FERRULE_UNITS + i]) + f * h[i];
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

// The inputs z of one that remembers, at every FERRULE_SPACING-th call; at the others it goes on.
std::string memory_inputs_in_c() {
  return fmt::format(R"(  if (s->periods > 0) {{
    s->periods = (s->periods + 1) % FERRULE_SPACING;
    for (i = 0; i < {0}; ++i) velocity[i] = s->velocity[i];
    return;
  }}
  s->periods = 1 % FERRULE_SPACING;
  for (i = 0; i < {1}; ++i) z[i] = (float)((wrench[i] - ferrule_mean[i]) / ferrule_scale[i]);
  for (i = 0; i < {0}; ++i)
    z[{1} + i] =
        (float)((displacement[i] - ferrule_mean[{1} + i]) / ferrule_scale[{1} + i]);
  z[{2}] = (float)((height - ferrule_mean[{2}]) / ferrule_scale[{2}]);
)",
                     kTwist, kWrenchChannels, kMemoryChannels - 1);
}

std::string sizes_in_c(const Policy& policy, Eigen::Index widest) {
  std::string sizes = policy.memories.empty()
                          ? fmt::format("  FERRULE_SAMPLES = {},\n  FERRULE_RING = {},\n",
                                        policy.samples, (policy.samples - 1) * policy.spacing + 1)
                          : fmt::format("  FERRULE_MEMBERS = {},\n  FERRULE_UNITS = {},\n",
                                        policy.members.size(), policy.memories.front().units());
  return fmt::format(
      "\nenum {{\n"
      "{}"
      "  FERRULE_SPACING = {}, /* in periods */\n"
      "  FERRULE_INPUTS = {},\n"
      "  FERRULE_WIDEST = {}\n"
      "}};\n",
      sizes, policy.spacing, policy.inputs(), widest);
}

}  // namespace

std::string c_header(const PolicyFile& file, const std::string& origin) {
  const Policy& policy = file.policy;
  const bool remembers = !policy.memories.empty();
  const MembersInC members = members_in_c(policy);
  const auto answers = static_cast<std::size_t>(policy.answers());
  std::string body =
      table("ferrule_mean", policy.mean.data(), policy.channels().size()) +
      table("ferrule_scale", policy.scale.data(), policy.channels().size()) +
      table("ferrule_velocity_mean", policy.velocity_mean.data(), answers) +
      table("ferrule_velocity_scale", policy.velocity_scale.data(), answers) + members.arrays +
      sizes_in_c(policy, members.widest) + (remembers ? memory_functions() : policy_functions()) +
      command_head(remembers) +
      fmt::format(
          "  float z[FERRULE_INPUTS], a[FERRULE_WIDEST], b[FERRULE_WIDEST];\n"
          "  double sum[{}] = {{0}}, speed;\n"
          "  int i{};\n",
          answers, remembers ? "" : ", k") +
      unused_arguments([&](const auto& c) { return !remembers && c.policy != PolicyInput::none; }) +
      (remembers ? memory_inputs_in_c() : policy_inputs_in_c()) + members.calls +
      fmt::format(R"(  for (i = 0; i < {}; ++i)
    velocity[i] = ferrule_velocity_mean[i] + ferrule_velocity_scale[i] * (sum[i] / {});
)",
                  answers, policy.members.size()) +
      no_tilts(policy.answers()) +
      fmt::format(
          R"(  speed = sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]);
  if (speed > {0:#.17g})
    for (i = 0; i < 3; ++i) velocity[i] *= {0:#.17g} / speed;
)",
          policy.speed_limit);
  if (remembers) body += "  for (i = 0; i < 5; ++i) s->velocity[i] = velocity[i];\n";
  return framed(origin, file.trained_on, fmt::format(" of {:g} s", policy.period), body + "}\n",
                remembers);
}

}  // namespace ferrule
