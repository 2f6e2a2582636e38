#include "bench/controllers.hpp"

#include <fmt/format.h>

#include "controller/law.hpp"
#include "controller/policy.hpp"
#include "sim/base/measure.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kObservations = 1000;

Policy drawn(std::size_t members, int units) {
  RandomStream random(1, static_cast<std::uint64_t>(units), Draw::plan);
  Policy p;
  p.samples = 3;
  p.spacing = 40;
  p.speed_limit = 1e3;  // beyond all answers
  p.scale.fill(1);
  p.velocity_scale.setOnes();
  for (std::size_t m = 0; m < members; ++m) {
    Network network;
    int inputs = p.inputs();
    for (const int outputs : {units, units, 2 * kVelocity}) {
      network.push_back({Eigen::MatrixXf(outputs, inputs), Eigen::VectorXf(outputs)});
      for (int r = 0; r < outputs; ++r) {
        network.back().bias[r] = static_cast<float>(0.1 * random.normal());
        for (int c = 0; c < inputs; ++c)
          network.back().weight(r, c) = static_cast<float>(random.normal() / std::sqrt(inputs));
      }
      inputs = outputs;
    }
    p.members.push_back(network);
  }
  return p;
}

Eigen::Vector3d in_double(const Policy& p, const Eigen::VectorXd& input) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Network& network : p.members) {
    Eigen::VectorXd h = input;
    for (std::size_t i = 0; i < network.size(); ++i) {
      h = (network[i].weight.cast<double>() * h + network[i].bias.cast<double>()).eval();
      if (i + 1 < network.size()) h = h.unaryExpr([](double x) { return std::tanh(x); }).eval();
    }
    mean += h.head<kVelocity>() / static_cast<double>(p.members.size());
  }
  return mean;
}

ControllerRow measured(const std::string& name, const std::string& shape, Controller& controller,
                       const std::vector<Observation>& states) {
  const double ns = nanoseconds_per_call([&](long i) {
    keep(controller.command(states[static_cast<std::size_t>(i) % states.size()]));
  });
  return {name, shape, ns, 0};
}

std::vector<Observation> drawn_states() {
  RandomStream random(2, 0, Draw::plan);
  std::vector<Observation> states(kObservations, Observation{HandWrench::Zero(), 0, 0});
  for (Observation& o : states) {
    for (int i = 0; i < kWrenchChannels; ++i) o.wrench[i] = random.normal();
    o.depth = random.uniform();
    o.time = random.uniform();
  }
  return states;
}

ControllerRow insertion_law(const std::vector<Observation>& states) {
  Law law(LawKind::insertion, {2.5e-3, 0.5, 0.012, 0.004, 0.2, 0, 0.9e-3, 0.9e-3, 0, 0, 0, 0});
  return measured("insertion law", "12 gains, double", law, states);
}

ControllerRow policy(std::size_t members, int units, const std::vector<Observation>& states) {
  const Policy p = drawn(members, units);
  PolicyController timed(p), exact(p);
  ControllerRow row =
      measured("policy", fmt::format("{} of {}x{}, float", members, units, units), timed, states);
  double error = 0, largest = 0;
  Eigen::VectorXd input(p.inputs());
  const Eigen::Index back = p.spacing;
  for (std::size_t n = 0; n < states.size(); ++n) {
    const Eigen::Vector3d v = exact.command(states[n]).head<3>();
    for (int i = 0; i < p.inputs(); ++i) {
      const ObservationChannel& channel = kPolicyInputs[p.channel(i)];
      const bool past = channel.policy == PolicyInput::past;
      const auto at = static_cast<Eigen::Index>(n) - (past ? i / kPastChannels * back : 0);
      input[i] = at < 0 ? 0 : channel.value(states[static_cast<std::size_t>(at)]);
    }
    const Eigen::Vector3d reference = in_double(p, input);
    error = std::max(error, (v - reference).norm());
    largest = std::max(largest, reference.norm());
  }
  row.relative_error = error / largest;
  return row;
}

}  // namespace

std::vector<ControllerRow> bench_controllers(const GoOn& go_on) {
  const std::vector<Observation> states = drawn_states();
  Cases<ControllerRow> cases;
  add_case(cases, [&] { return insertion_law(states); });
  struct Size {
    std::size_t members;
    int units;
  };
  for (const Size& size : {Size{1, 32}, Size{1, 64}, Size{1, 128}, Size{5, 64}})
    add_case(cases, [&states, size] { return policy(size.members, size.units, states); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
