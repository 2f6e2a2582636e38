#include "app/recording.hpp"

#include <fmt/format.h>

#include <array>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/status_line.hpp"
#include "insertion/hand_device.hpp"

namespace ferrule {
namespace {

EpisodeInfo info_of(const TrialSetup& trial, const Device& device, const EpisodePlace& place) {
  EpisodeInfo info = episode_info(*trial.scene, device, trial.seed, trial.trial);
  info.operator_ = place.operator_;
  if (!place.sitting) return info;
  info.trainee = place.sitting->trainee;
  info.session = place.sitting->began;
  info.date = date_now();
  return info;
}

// Takes away what the device has reported so far. Throws DeviceTrouble where it is gone.
void put_aside(const OpenDevice& device) {
  if (device.fake) return;
  std::array<std::uint8_t, 64> report;
  int length;
  do length = device.transport->read(report, 0);
  while (length > 0);
  if (length < 0) throw DeviceTrouble(device.transport->info().path + ": the device was lost");
}

// What there is to do before an episode: at a terminal, to wait for the key that starts it. Empty:
// the operator ended the recording instead. Throws DeviceTrouble.
std::unique_ptr<Device> begin_by_hand(const OpenDevice& device, const HandSettings& settings,
                                      const TrialSetup& trial, const EpisodePlace& place,
                                      Keys& keys) {
  if (keys.there()) {
    const std::string question =
        episode_name(place.claim.number()) + ": space starts it, q ends the recording";
    // What the device reports meanwhile is not of this episode.
    if (keys.ask(question, " q", [&] { put_aside(device); }) != ' ') return nullptr;
    fmt::print(stderr, "recording: space ends it, d discards it\n");
  }
  return hand_on(device, settings, *trial.scene, trial.start);
}

// Asks the operator for a rating, or whether to discard it.
void rate(Recorded& recorded, Keys& keys) {
  const char key =
      keys.ask(std::string(name(recorded.end.outcome)) +
                   ": 1 (poor) to 5 (good) rates it, space keeps it as it is, d discards it",
               " dq12345");
  recorded.discarded = key == 'd';
  recorded.last = recorded.last || key == 'q';
  if (key >= '1' && key <= '5') recorded.rating = key - '0';
}

// Its file; of a long recording it takes some seconds.
std::string finished(Recorder& recorder, Outcome outcome) {
  Progress progress("writing", 1);
  return recorder.finish(outcome,
                         [&](std::size_t done, std::size_t all) { progress(done, "", all); });
}

}  // namespace

Recorded record_one(const TrialSetup& trial, Device& device, EpisodePlace place) {
  const EpisodeInfo info = info_of(trial, device, place);
  auto recorder = std::make_unique<Recorder>(std::move(place.claim), info);
  std::vector<PhaseBegin> phases;
  const InsertionEnd end = record_insertion(trial, device, *recorder, [&] {
    if (place.phase) note_phase(phases, recorder->rows() - 1, place.phase());
    return !interrupted();
  });
  recorder->info().phases = phases_text(phases);
  recorder->end(end.outcome);
  Recorded recorded{{}, end, info.period};
  recorded.writing = std::move(recorder);
  return recorded;
}

void Recorded::wait() {
  if (writing) file = writing->written();
  writing.reset();
}

std::string operator_name(const OpenDevice& device) {
  const HidInfo& info = device.transport->info();
  if (device.fake) return std::string("simulated hand, ") + device.driver->fake_name;
  return fmt::format("{} {:04x}:{:04x}", device.driver->name, info.vendor, info.product);
}

std::unique_ptr<Device> hand_on(const OpenDevice& device, const HandSettings& settings,
                                const Scene& scene, const State& start) {
  const double full_force = settings.profile.max_force;
  const Driver& driver = *device.driver;
  if (device.fake) return fake_hand(driver, driver.fake(), scene, start, settings.gain, full_force);
  try {
    return driver.make(*device.transport, driver_settings(scene, start, settings.gain, full_force));
  } catch (const DeviceTrouble&) {
    put_aside(device);  // says so where it is gone
    throw;
  }
}

std::optional<Recorded> record_by_hand(const OpenDevice& device, const HandSettings& settings,
                                       const TrialSetup& trial, EpisodePlace place, Keys& keys) {
  std::unique_ptr<Device> hand = begin_by_hand(device, settings, trial, place, keys);
  if (!hand) return std::nullopt;
  EpisodeInfo info = info_of(trial, *hand, place);
  std::optional<ForceFeedback> feedback;
  if (const ForceDriver* const force = device.driver->force) {
    info.period = settings.profile.period;
    if (settings.coupling) info.coupling = coupling_text(*settings.coupling);
    feedback.emplace(settings.profile, settings.coupling, trial.hand(), force->report_period,
                     force->motors(device.transport->info()));
  }
  Recorder recorder(std::move(place.claim), info);
  bool discard = false, last = false;
  std::optional<StatusLine> status(std::in_place, *trial.scene);
  const auto [end, timing] = run_in_time(
      trial, *hand,
      {.period = info.period,
       .past_success = place.sitting && place.sitting->goes_on,
       .feedback = feedback ? &*feedback : nullptr},
      [&](const RowVector& row, const RawCounts& counts) {
        recorder.add(row, counts);
        (*status)(row);
      },
      [&] {
        const char key = keys.pressed();
        discard = discard || key == 'd';
        last = last || key == 'q';
        return discard ? Request::stop : last || key == ' ' ? Request::finish : Request::go_on;
      },
      interrupted);
  hand.reset();  // disables the motors before anything is asked
  status.reset();
  if (feedback && feedback->stage() == ForceGuard::Stage::waiting)
    fmt::print(stderr,
               "note: the device rendered no force: the force was never small enough to begin\n");
  Recorded recorded{{}, end, info.period, timing};
  recorder.flush();
  recorded.discarded = discard;
  recorded.last = last;
  if (keys.there() && !discard && !interrupted()) rate(recorded, keys);
  if (recorded.discarded || recorder.rows() == 0) {
    recorder.discard();
    return recorded;
  }
  recorder.info().why = end.why;
  recorder.info().loop = loop_json(timing, info.period).dump();
  recorder.info().rating = recorded.rating;
  recorded.file = finished(recorder, end.outcome);
  return recorded;
}

}  // namespace ferrule
