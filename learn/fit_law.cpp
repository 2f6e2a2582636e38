#include "learn/fit_law.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "learn/choose_law.hpp"
#include "learn/free_course.hpp"
#include "learn/tilt_yields.hpp"

namespace ferrule {
namespace {

constexpr const char* kLawOption = "--law";

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

// Empty: to be chosen.
std::optional<LawKind> law_kind(const std::string& law) {
  for (const LawKind kind : kLaws)
    if (law == name(kind)) return kind;
  return std::nullopt;
}

std::string cross_validation_text(const LawFile& c) {
  if (c.cross_validation.empty()) return {};
  std::string text = fmt::format("{:<14} {:>5} {:>22} {:>16}\n", "law", "gains",
                                 "error, unseen [mm/s]", "standard error");
  for (const CrossValidated& law : c.cross_validation)
    text += fmt::format("{:<14} {:>5} {:>22.5g} {:>16.2g}{}\n", name(law.kind),
                        gain_table(law.kind).size(), 1e3 * law.error, 1e3 * law.standard_error,
                        law.kind == c.kind ? "  chosen" : "");
  return text;
}

std::string gains_text(const LawFile& c) {
  std::string text = fmt::format("{:<14} {:>14} {:>14} {:>14}  {}\n", "gain", "value", "95 % low",
                                 "95 % high", "unit");
  const auto shown = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.6g}", x) : std::string("open");
  };
  for (std::size_t i = 0; i < c.gains.size(); ++i)
    text += fmt::format("{:<14} {:>14.6g} {:>14} {:>14}  {}\n", gain_of(c.kind, i).name,
                        c.gains[i].value, shown(c.gains[i].low), shown(c.gains[i].high),
                        gain_of(c.kind, i).unit);
  return text;
}

Learned learn_law(const DemonstrationSet& set, const LearnerSettings& settings,
                  const LearnerProgress& progress) {
  const LawFit fit =
      fit_law(set, settings.seed, law_kind(settings.options.at(kLawOption)), progress);
  const LawFile& c = fit.controller;
  std::string text = cross_validation_text(c);
  text += fmt::format("law: {}\n", name(c.kind)) + gains_text(c);
  text += fmt::format("reaction time {:.2f} s (identified, not imitated)\n", c.reaction_time);
  text += fmt::format("{} training episodes, {} held out, {} unsuccessful left out, {} rows\n",
                      c.trained_on.episodes.size(), c.trained_on.held_out.size(), set.unsuccessful,
                      c.trained_on.rows);
  text += fmt::format(
      "velocity residual {:.4g} mm/s, held out {:.4g} mm/s (hand); {:.1f} % explained\n{}\n",
      1e3 * c.residual, 1e3 * c.held_out_residual, 100 * fit.explained, fit.summary);
  return {c, text};
}

}  // namespace

LawFit fit_law(const DemonstrationSet& set, std::uint64_t seed, std::optional<LawKind> kind,
               const LearnerProgress& progress) {
  refuse_too_few(set);
  const Split parts = split(set.demonstrations, seed);

  LawFit report;
  LawFile& c = report.controller;
  c.reaction_time = reaction_time(parts.training);
  const std::vector<Samples> train = samples_of(parts.training, c.reaction_time);
  const std::vector<Samples> test = samples_of(parts.testing, c.reaction_time);
  refuse_uninformative(train);
  const LawScales scales{set.speed_scale, greatest_depth(train)};

  const SolveProgress told = [&](std::size_t done, std::size_t all) {
    report.controller.trained_on.partial = progress && !progress(done, all, "");
    return !report.controller.trained_on.partial;
  };
  if (!kind) {
    c.cross_validation = cross_validate(train, scales, told);
    kind = simplest_within_one_standard_error(c.cross_validation);
  }
  LawSolution solution = solve_law(*kind, train, scales, Effort::exact, told);
  if (!std::isfinite(solution.cost))
    throw BadInput("the fit did not converge from any start: " + solution.summary);
  const FreeCourse free = free_course(*kind, solution.gains, train);
  solution = solve_beside(*kind, train, scales, solution, determined(free), told);
  const bool partial = c.trained_on.partial;
  c.kind = *kind;
  c.gains = with_yields(law_gains(*kind, train, scales, solution), free);
  for (const FittedGain& gain : tilt_yields(train).gains) c.gains.push_back(gain);
  c.trained_on = trained_on(set, parts.training, parts.testing, seed);
  c.trained_on.rows = rows(train);
  c.trained_on.partial = partial;
  c.residual = root_mean_square_error(c.law(), train);
  c.held_out_residual = root_mean_square_error(c.law(), test);
  report.summary = solution.summary;
  report.iterations = solution.iterations;
  report.explained = 1 - c.residual * c.residual / variance(train);
  return report;
}

Learner law_learner() {
  Learner learner{.name = "law",
                  .method = "ceres",
                  .options = {{kLawOption,
                               "Which; auto: chosen by cross-validation over episodes",
                               name(LawKind::insertion),
                               {"auto"}}},
                  .variants = {},
                  .files = [](const std::string& file) { return std::vector{file}; },
                  .learn = learn_law};
  for (const LawKind kind : kLaws) {
    learner.options[0].choices.push_back(name(kind));
    learner.variants.push_back(
        {name(kind), std::string("ceres, ") + name(kind), {{kLawOption, name(kind)}}});
  }
  return learner;
}

}  // namespace ferrule
