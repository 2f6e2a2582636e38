#include "app/law_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "learn/samples.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kPoints = 1500;  // drawn of a panel
constexpr int kLine = 200;
constexpr std::size_t kBins = 60;

Series points(const std::string& name) {
  return {name, {}, {}, Series::points};
}

void add(Series& series, double x, double y) {
  series.x.push_back(x);
  series.y.push_back(y);
}

Eigen::Vector3d answer(const Law& law, const Sample& s) {
  return law_velocity(law.kind(), law.gains().data(), s);
}

// Largest of `value` over all samples.
template <class Value>
double largest(const std::vector<Samples>& episodes, Value value) {
  double most = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) most = std::max(most, value(s));
  return most;
}

// Velocity [mm/s] along `axis` against the force along it, apart outside and in the bore; the law
// without other forces at both ends of the depth.
Axes lateral(const std::vector<Samples>& episodes, const Law& law, int axis) {
  std::size_t rows = 0;
  for (const Samples& episode : episodes) rows += episode.size();
  const std::size_t stride = std::max<std::size_t>(1, rows / kPoints);
  Series outside = points("outside"), inside = points("in the bore");
  std::size_t n = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode)
      if (n++ % stride == 0)
        add(s.depth > 0 ? inside : outside, s.wrench[axis], 1e3 * s.velocity[axis]);
  const auto size = [axis](const Sample& s) { return std::abs(s.wrench[axis]); };
  const double force = largest(episodes, size);
  const double depth = largest(episodes, [](const Sample& s) { return s.depth; });
  const double time = largest(episodes, [](const Sample& s) { return s.time; });
  Series law_outside{"law, outside", {}, {}, Series::line};
  Series law_inside{fmt::format("law, {:.3g} mm deep", 1e3 * depth), {}, {}, Series::line};
  for (int k = -kLine; k <= kLine; ++k) {
    HandWrench f = HandWrench::Zero();
    f[axis] = force * k / kLine;
    for (const auto& [series, d] : {std::pair{&law_outside, 0.0}, {&law_inside, depth}})
      add(*series, f[axis], 1e3 * answer(law, {{f, d, time}, Eigen::Vector3d::Zero()})[axis]);
  }
  return {fmt::format("felt F_{} [N], hand", "xyz"[axis]),
          fmt::format("v_{} [mm/s]", "xyz"[axis]),
          false,
          false,
          {outside, inside, law_outside, law_inside}};
}

// Velocity along x against the depth inside: the demonstrations, and the law's answers to the same
// forces, their mean in each of kBins parts of the depth.
Axes axial(const std::vector<Samples>& episodes, const Law& law) {
  std::size_t rows = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) rows += s.depth > 0;
  const std::size_t stride = std::max<std::size_t>(1, rows / kPoints);
  const double depth = largest(episodes, [](const Sample& s) { return s.depth; });
  Series data = points("demonstrations"), line{"law, mean answer", {}, {}, Series::line};
  std::array<double, kBins> sum{}, count{};
  std::size_t n = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) {
      if (!(s.depth > 0)) continue;
      if (n++ % stride == 0) add(data, 1e3 * s.depth, 1e3 * s.velocity.x());
      const auto bin = std::min(kBins - 1, static_cast<std::size_t>(s.depth / depth * kBins));
      sum[bin] += answer(law, s).x();
      ++count[bin];
    }
  for (std::size_t bin = 0; bin < kBins; ++bin)
    add(line, 1e3 * depth * (static_cast<double>(bin) + 0.5) / kBins, 1e3 * sum[bin] / count[bin]);
  return {"depth of the hand in the bore [mm]", "v_x [mm/s]", false, false, {data, line}};
}

// Velocity along x over the time of one demonstration, and the law's answer to the same forces.
Axes over_time(const Samples& episode, const Law& law) {
  Series data = points("one demonstration"), line{"law, same forces", {}, {}, Series::line};
  for (const Sample& s : episode) {
    add(data, s.time, 1e3 * s.velocity.x());
    add(line, s.time, 1e3 * answer(law, s).x());
  }
  return {"time [s]", "v_x [mm/s]", false, false, {data, line}};
}

}  // namespace

Plot law_plot(const DemonstrationSet& set, const LawFile& controller) {
  std::vector<Samples> episodes;
  for (const Demonstration& d : set.demonstrations)
    episodes.push_back(samples(d, controller.reaction_time));
  // That of median length is shown over time.
  std::vector<Samples> by_length = episodes;
  const auto middle = by_length.begin() + static_cast<std::ptrdiff_t>(by_length.size() / 2);
  std::nth_element(by_length.begin(), middle, by_length.end(),
                   [](const Samples& a, const Samples& b) { return a.size() < b.size(); });
  const Law law = controller.law();
  return {fmt::format("The {} law over {} demonstrations, in the hand's world", name(law.kind()),
                      episodes.size()),
          {lateral(episodes, law, 1), lateral(episodes, law, 2), axial(episodes, law),
           over_time(*middle, law)},
          860,
          300};
}

}  // namespace ferrule
