#include "app/stopping.hpp"

#include <algorithm>

#include "app/validators.hpp"

namespace ferrule {

void StoppingArguments::add_to(CLI::App& verb) {
  verb.add_option(
          "--until-width", enough.width,
          "Stop when the 95 % interval of the success rate is narrower than this: 0.002 for "
          "0.2 percentage points; with --target, when both are known")
      ->check(number_between(1e-6, 1));
  verb.add_option("--target", enough.target,
                  "Stop when this success rate is shown or refuted, each wrong with a chance of at "
                  "most 5 %: 0.999 for 99.9 %; exit code 1 where it is refuted")
      ->check(number_between(1e-6, 0.999999));
}

CampaignSummary StoppingArguments::summary(const std::vector<TrialResult>& results) const {
  CampaignSummary s = summarise(results);
  if (enough.target) s.target = decide(*enough.target, results);
  return s;
}

bool StoppingArguments::whole(const std::vector<TrialResult>& results, std::size_t trials) const {
  const auto known = when(enough);
  return results.size() == trials || (known && std::any_of(results.begin(), results.end(), known));
}

}  // namespace ferrule
