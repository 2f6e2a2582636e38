// The report of a demo: one HTML file that opens from disk and needs no network.
#pragma once

#include "app/provenance.hpp"
#include "app/recording.hpp"
#include "controller/campaign.hpp"
#include "learn/fit_law.hpp"

namespace ferrule {

struct DemoReport {
  const Scene* scene = nullptr;
  Provenance provenance;
  std::string scene_arguments;  // that the program was called with
  std::uint64_t seed = 0;
  struct OfSkill {
    double skill;
    Recorded recorded;
  };
  std::vector<OfSkill> recorded;
  std::string shown;  // file of the demonstration that is drawn
  LawFit fit;
  std::vector<TrialResult> learned, baseline;
  double record_seconds = 0, fit_seconds = 0, evaluate_seconds = 0;

  // Of the trials: apart from that of the demonstrations, so that no trial starts where one did.
  std::uint64_t trial_seed() const noexcept { return seed + 1'000'003; }
};

// Throws FileTrouble.
void write_report(const std::string& file, const DemoReport& report);
std::string report_text(const DemoReport& report);
Json report_json(const DemoReport& report);

}  // namespace ferrule
