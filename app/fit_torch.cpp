#include "app/fit_torch.hpp"

#include <fmt/format.h>

#include "app/plot.hpp"
#include "learn/fit_policy.hpp"

namespace ferrule {
namespace {

Plot training_plot(const std::vector<std::vector<Epoch>>& curves) {
  Axes axes{"epoch", "negative log likelihood per row", false, false, {}};
  for (std::size_t m = 0; m < curves.size(); ++m) {
    const std::string member = curves.size() > 1 ? fmt::format(" {}", m + 1) : std::string();
    Series training{"training" + member, {}, {}}, held_out{"held out" + member, {}, {}};
    for (std::size_t i = 0; i < curves[m].size(); ++i)
      for (Series* s : {&training, &held_out}) {
        s->x.push_back(static_cast<double>(i + 1));
        s->y.push_back(s == &training ? curves[m][i].training_loss : curves[m][i].held_out_loss);
      }
    axes.series.push_back(training);
    axes.series.push_back(held_out);
  }
  return {"Training: loss with input noise, and of the held-out episodes", {axes}};
}

}  // namespace

void add_fit_torch(CLI::App& verb, FitTorch& a) {
  verb.add_option("--ensemble", a.ensemble, "With torch: how many networks")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{100}));
  verb.add_option("--dagger", a.dagger,
                  "With torch: rounds of letting the policy insert and asking the simulated "
                  "operator what it would have done")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{0}, std::size_t{100}));
}

void refuse_fit_torch(const CLI::App& verb) {
  for (const char* option : {"--ensemble", "--dagger"})
    if (verb.count(option) > 0) throw CLI::ValidationError(option, "needs --method torch");
}

int fit_torch(const DemonstrationSet& set, const std::string& folder, const std::string& out,
              const std::string& plot, std::uint64_t seed, const FitTorch& a, bool json) {
  PolicySettings settings;
  settings.members = a.ensemble;
  settings.dagger_rounds = a.dagger;
  settings.seed = seed;
  PolicyFit fit;
  try {
    Progress progress("training", (a.dagger + 1) * a.ensemble *
                                      static_cast<std::size_t>(settings.training.epochs));
    fit = fit_policy(set, settings, [&](std::size_t done, const Epoch& e) {
      progress(done,
               fmt::format("  loss {:.3f}, held out {:.3f}", e.training_loss, e.held_out_loss));
    });
  } catch (const BadInput& error) {
    throw BadInput(folder + ": " + error.what());
  }
  write_policy(out, fit.file);
  if (!plot.empty()) write_svg(plot, training_plot(fit.curves));
  if (json) {
    print_json(parse_json(read_text(out), out));
    return kDone;
  }
  const PolicyFile& f = fit.file;
  fmt::print("{:<8} {:>7} {:>6} {:>14} {:>14}\n", "network", "epochs", "best", "loss", "held out");
  for (std::size_t m = 0; m < f.members.size(); ++m)
    fmt::print("{:<8} {:>7} {:>6} {:>14.4f} {:>14.4f}\n", m + 1, f.members[m].epochs,
               f.members[m].best_epoch, f.members[m].training_loss, f.members[m].held_out_loss);
  for (const DaggerRound& r : f.dagger)
    fmt::print("round: {} of {} inserted, {} rows added, held-out loss then {:.4f}\n", r.inserted,
               r.trials, r.rows, r.held_out_loss);
  fmt::print("reaction time {:.2f} s (identified, not imitated)\n", f.reaction_time);
  fmt::print("{} training episodes, {} held out, {} unsuccessful left out, {} rows\n",
             f.trained_on.episodes.size(), f.trained_on.held_out.size(), set.unsuccessful,
             f.trained_on.rows);
  fmt::print("velocity residual {:.4g} mm/s, held out {:.4g} mm/s (hand)\n", 1e3 * f.residual,
             1e3 * f.held_out_residual);
  fmt::print("wrote {}\n", out);
  return kDone;
}

}  // namespace ferrule
