// When the trials of evaluate and compare end before --trials: as soon as enough is known.
#pragma once

#include <CLI/CLI.hpp>

#include "controller/campaign.hpp"

namespace ferrule {

struct StoppingArguments {
  Enough enough;

  void add_to(CLI::App& verb);
  // Of the trials, with what they say of the target.
  CampaignSummary summary(const std::vector<TrialResult>& results) const;
  // Did the campaign end where it was to, not by Ctrl-C?
  bool whole(const std::vector<TrialResult>& results, std::size_t trials) const;
};

}  // namespace ferrule
