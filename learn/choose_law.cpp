#include "learn/choose_law.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

constexpr std::size_t kFolds = 5;
constexpr std::size_t kFoldStride = 5;  // of rows that laws are fitted to

// Errors of one law, episode by episode [m/s]; empty without a solution in some fold.
std::vector<double> errors(LawKind kind, const std::vector<Samples>& episodes,
                           const LawScales& scales, const SolveProgress& progress) {
  const std::size_t folds = std::min(kFolds, episodes.size());
  std::vector<double> all;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<Samples> others;
    for (std::size_t e = 0; e < episodes.size(); ++e)
      if (e % folds != fold) others.push_back(thinned(episodes[e], kFoldStride));
    const LawSolution solution = solve_law(kind, others, scales, Effort::rough, progress);
    if (!std::isfinite(solution.cost)) return {};
    const Law law(kind, solution.gains);
    for (std::size_t e = fold; e < episodes.size(); e += folds)
      if (!episodes[e].empty()) all.push_back(std::sqrt(mean_square_error(law, episodes[e])));
  }
  return all;
}

}  // namespace

std::vector<CrossValidated> cross_validate(const std::vector<Samples>& episodes,
                                           const LawScales& scales, const SolveProgress& progress) {
  std::vector<CrossValidated> laws;
  bool stopped = false;
  const SolveProgress watch = [&](std::size_t, std::size_t) {
    stopped |= progress && !progress(laws.size(), std::size(kLaws));
    return !stopped;
  };
  for (const LawKind kind : kLaws) {
    std::vector<double> all;
    if (!stopped) all = errors(kind, episodes, scales, watch);
    if (stopped) all.clear();
    const double n = static_cast<double>(all.size());
    double mean = 0, variance = 0;
    for (const double error : all) mean += error / n;
    for (const double error : all) variance += (error - mean) * (error - mean) / (n - 1);
    laws.push_back({kind, all.empty() ? NAN : mean, all.empty() ? NAN : std::sqrt(variance / n)});
  }
  return laws;
}

LawKind simplest_within_one_standard_error(const std::vector<CrossValidated>& laws) {
  const CrossValidated* best = nullptr;
  for (const CrossValidated& law : laws)
    if (std::isfinite(law.error) && (!best || law.error < best->error)) best = &law;
  if (!best) throw BadInput("no law could be fitted in every fold of the cross-validation");
  for (const CrossValidated& law : laws)  // fewest gains first
    if (law.error <= best->error + best->standard_error) return law.kind;
  return best->kind;
}

}  // namespace ferrule
