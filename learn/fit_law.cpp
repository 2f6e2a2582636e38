#include "learn/fit_law.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "learn/choose_law.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kFewestEpisodes = 3;

std::vector<Samples> samples_of(const std::vector<const Demonstration*>& demonstrations,
                                double reaction) {
  std::vector<Samples> all;
  for (const Demonstration* d : demonstrations) all.push_back(samples(*d, reaction));
  return all;
}

std::size_t rows(const std::vector<Samples>& episodes) {
  std::size_t n = 0;
  for (const Samples& episode : episodes) n += episode.size();
  return n;
}

double greatest_depth(const std::vector<Samples>& episodes) {
  double depth = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) depth = std::max(depth, s.depth);
  return depth;
}

double root_mean_square_error(const Law& law, const std::vector<Samples>& episodes) {
  double sum = 0, n = 0;
  for (const Samples& episode : episodes)
    if (!episode.empty()) {
      sum += mean_square_error(law, episode) * static_cast<double>(episode.size());
      n += static_cast<double>(episode.size());
    }
  return n > 0 ? std::sqrt(sum / n) : NAN;
}

// Of the velocities, all axes together [m^2/s^2].
double variance(const std::vector<Samples>& episodes) {
  const double n = static_cast<double>(rows(episodes));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) mean += s.velocity / n;
  double sum = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) sum += (s.velocity - mean).squaredNorm() / n;
  return sum;
}

}  // namespace

FitReport fit_law(const DemonstrationSet& set, std::uint64_t seed, std::optional<LawKind> kind) {
  if (set.demonstrations.size() < kFewestEpisodes)
    throw BadInput(
        fmt::format("too few demonstrations: {} successful ({} unsuccessful left out); {} are "
                    "needed",
                    set.demonstrations.size(), set.unsuccessful, kFewestEpisodes));
  const Split parts = split(set.demonstrations, seed);

  FitReport report;
  ControllerFile& c = report.controller;
  c.reaction_time = reaction_time(parts.training);
  const std::vector<Samples> train = samples_of(parts.training, c.reaction_time);
  const std::vector<Samples> test = samples_of(parts.testing, c.reaction_time);
  refuse_uninformative(train);
  const LawScales scales{set.speed_scale, greatest_depth(train)};

  if (!kind) {
    c.cross_validation = cross_validate(train, scales);
    kind = simplest_within_one_standard_error(c.cross_validation);
  }
  const LawSolution solution = solve_law(*kind, train, scales);
  if (!std::isfinite(solution.cost))
    throw BadInput("the fit did not converge from any start: " + solution.summary);
  c.kind = *kind;
  c.gains = law_gains(*kind, train, scales, solution);
  c.trained_on = {set.scenes, trained_episodes(parts.training), trained_episodes(parts.testing),
                  rows(train), seed};
  c.residual = root_mean_square_error(c.law(), train);
  c.held_out_residual = root_mean_square_error(c.law(), test);
  report.summary = solution.summary;
  report.iterations = solution.iterations;
  report.explained = 1 - c.residual * c.residual / variance(train);
  return report;
}

}  // namespace ferrule
