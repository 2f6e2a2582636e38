#include "view/input_log.hpp"

#include <algorithm>

#include "insertion/hand_device.hpp"
#include "sim/base/control_period.hpp"
#include "view/browser_device.hpp"

namespace ferrule {
namespace {

constexpr const char* kFormat = "ferrule input log";
constexpr std::int64_t kVersion = 1;
constexpr std::int64_t kMostRows = std::int64_t{24} * 3600 * 1000;  // a day
constexpr std::size_t kLongestLine = 1000;
constexpr std::size_t kSha1 = 40;

// The page's hand, told what to say.
class LoggedHand : public Device {
 public:
  LoggedHand(const InputLog& log, double speed, const HandPose& start)
      : log_(log), device_(hand_, speed, start) {}

  // What the rows were read from, and once more, which finishes it.
  HandSample read(double t) override {
    const bool over = run_ == log_.held.size();
    hand_.say(over ? std::array<std::int16_t, 3>{} : log_.held[run_].counts, over);
    if (!over && ++row_ == log_.held[run_].rows) {
      ++run_;
      row_ = 0;
    }
    return device_.read(t);
  }
  void render(const HandWrench&) override {}
  const Mapping* mapping() const noexcept override { return device_.mapping(); }

 private:
  const InputLog& log_;
  BrowserHand hand_;
  BrowserDevice device_;
  std::size_t run_ = 0;
  std::int64_t row_ = 0;  // of the run
};

HeldCounts parse_held(const JsonFields& fields, const Json& run) {
  const auto whole = [](const Json& x, std::int64_t low, std::int64_t high) {
    return x.is_number_integer() && x >= low && x <= high;
  };
  constexpr std::int64_t full = BrowserHand::kFull;
  if (!run.is_array() || run.size() != 4 || !whole(run[0], 1, kMostRows) ||
      !std::all_of(run.begin() + 1, run.end(),
                   [&](const Json& x) { return whole(x, -full, full); }))
    fields.refuse("counts",
                  "must be a list of [rows, X, Y, Z], whole numbers, each count within 10000");
  HeldCounts held{run[0], {}};
  for (std::size_t axis = 0; axis < held.counts.size(); ++axis) held.counts[axis] = run[1 + axis];
  return held;
}

}  // namespace

std::int64_t InputLog::rows() const noexcept {
  std::int64_t sum = 0;
  for (const HeldCounts& each : held) sum += each.rows;
  return sum;
}

void InputLog::add(const RawCounts& counts) {
  HeldCounts now{1, {}};
  for (std::size_t axis = 0; axis < now.counts.size(); ++axis)
    now.counts[axis] = static_cast<std::int16_t>(counts[static_cast<Eigen::Index>(axis)]);
  if (held.empty() || held.back().counts != now.counts)
    held.push_back(now);
  else
    ++held.back().rows;
}

Json to_json(const InputLog& log) {
  Json counts = Json::array();
  for (const HeldCounts& each : log.held)
    counts.push_back({each.rows, each.counts[0], each.counts[1], each.counts[2]});
  return {{"format", kFormat},
          {"format_version", kVersion},
          {"ferrule_version", log.info.version},
          {"build", log.info.build},
          {"scene", Json::parse(log.info.scene)},
          {"seed", log.info.seed},
          {"trial", log.info.trial},
          {"operator", log.info.operator_},
          {"trainee", log.info.trainee},
          {"date", log.info.date},
          {"session", log.info.session},
          {"outcome", name(log.info.outcome)},
          {"why", log.info.why},
          {"counts", counts},
          {"rows_sha1", log.rows_sha1}};
}

InputLog parse_input_log(const Json& json, const std::string& file) {
  JsonFields fields(json, file);
  fields.choice("format", {kFormat});
  fields.integer("format_version", kVersion, kVersion);
  InputLog log;
  EpisodeInfo& info = log.info;
  info.version = fields.line("ferrule_version", kLongestLine);
  info.build = fields.line("build", kLongestLine);
  info.scene = fields.raw("scene").dump();
  info.seed = static_cast<std::uint64_t>(fields.integer("seed", 0, INT64_MAX));
  info.trial = static_cast<std::uint64_t>(fields.integer("trial", 0, INT64_MAX));
  info.operator_ = fields.line("operator", kLongestLine);
  info.trainee = fields.line("trainee", kLongestLine);
  info.date = fields.line("date", kLongestLine);
  info.session = fields.line("session", kLongestLine);
  std::vector<std::string> outcomes;
  for (int i = 0; i < kOutcomes; ++i) outcomes.push_back(name(static_cast<Outcome>(i)));
  info.outcome = static_cast<Outcome>(fields.choice("outcome", outcomes));
  info.why = fields.line("why", kLongestLine);
  info.period = kControlPeriod;
  const Json& runs = fields.raw("counts");
  if (!runs.is_array() || runs.empty())
    fields.refuse("counts", "must be a list of [rows, X, Y, Z]");
  for (const Json& run : runs) log.held.push_back(parse_held(fields, run));
  if (log.rows() > kMostRows) fields.refuse("counts", "must be of a day at most");
  log.rows_sha1 = fields.line("rows_sha1", kSha1);
  fields.finish();
  return log;
}

std::unique_ptr<Device> logged_hand(const InputLog& log, const TrialSetup& trial) {
  return std::make_unique<LoggedHand>(log, device_range(*trial.scene, 1).speed, trial.hand());
}

}  // namespace ferrule
