// ferrule devices: what is connected and usable, and a look at what it sends.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

#include "app/connected.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr double kPush = 0.1;  // of the device's force, while it is tested [-]
constexpr const char* kAxisNames[] = {"X", "Y", "Z", "Rx", "Ry", "Rz"};

struct DevicesArguments {
  std::string device = "auto";
  double seconds = 0;
  bool test = false;
  Output output;
};

const char* state_name(const FoundDevice& device) {
  return !device.driver            ? "never used"
         : !device.missing.empty() ? "unusable"
         : device.permitted        ? "usable"
                                   : "forbidden";
}

int list_verb(const DevicesArguments& a) {
  const std::vector<FoundDevice> found = find_devices();
  Json list = Json::array();
  for (const FoundDevice& d : found) {
    list.push_back(device_json(d));
    if (!a.output.text()) continue;
    fmt::print("{}  {}  {:<11}  {:<10}  {}\n", d.info.path, list.back()["id"].get<std::string>(),
               d.driver ? d.driver->name : "-", state_name(d), printable(d.info.name, 100));
    if (d.forbidden())
      fmt::print(
          "  found, but not permitted; this udev rule lets the person at the machine open it:\n"
          "    {}\n  install it once, then plug the device in again:\n    {}\n",
          udev_rule(d.info), udev_command(d.info));
    if (!d.missing.empty()) fmt::print("  cannot be used: {}\n", d.missing);
    if (d.never) fmt::print("  {}: left alone\n", d.never);
  }
  if (a.output.text() && found.empty())
    fmt::print("no device is connected; --device {} tries without one\n", fake_names(" or "));
  if (a.output.text()) fmt::print("{}", Provenance().foot());
  print_result(a.output, {{"devices", list}}, "devices", {});
  return kDone;
}

// The hand on a fake device: axes swing, a button now and then.
void move_fake(FakeTransport& model, double t) {
  std::array<int, 6> counts{};
  for (std::size_t axis = 0; axis < counts.size(); ++axis)
    counts[axis] = static_cast<int>(std::lround(
        350 * elementary::sin(2 * std::numbers::pi * t / (2.0 + 0.3 * static_cast<double>(axis)))));
  model.deflect(counts);
  model.press(std::fmod(t, 1) > 0.8 ? 1 : 0);
  model.advance(t);
}

// A push along X and Y in turn, in parts of what the device can do.
HandWrench test_push(double t) {
  HandWrench wrench = HandWrench::Zero();
  wrench[std::fmod(t, 2) < 1 ? 0 : 1] = kPush * elementary::sin(2 * std::numbers::pi * t);
  return wrench;
}

// A device under test, and what it has sent.
struct Test {
  OpenDevice device;
  std::string name;
  std::unique_ptr<HidDevice> driver;
  RawCounts low, high;
  std::uint32_t pressed = 0;
  bool lost = false;
  double time = 0, shown = 0;  // [s]
  std::int64_t reports_shown = 0;
};

Test begun(const std::string& wanted) {
  Test t;
  t.device = open_device("--test", wanted);
  const HidInfo& info = t.device.transport->info();
  t.name = fmt::format("{} {} ({})", info.path, t.device.driver->name, info.name);
  t.driver = t.device.driver->make(*t.device.transport, {{1, 1, 1}, 1, HandPose::Zero()});
  t.low = t.high = t.driver->axes().counts();
  return t;
}

void introduce(const Test& t) {
  fmt::print("{}; Ctrl-C ends this\n", t.name);
  if (t.device.fake) fmt::print("this device is simulated, and so is the hand on it\n");
  if (t.device.driver->force)
    fmt::print("hold it: it pushes with {:.0f} % of its force, along X and Y in turn\n",
               100 * kPush);
}

// One tick.
HandSample pushed_and_read(Test& t) {
  if (t.device.fake) move_fake(*t.device.fake, t.time);
  HandSample sample = t.driver->read(t.time);
  t.lost = sample.lost;
  t.low = t.low.cwiseMin(sample.counts);
  t.high = t.high.cwiseMax(sample.counts);
  t.pressed |= t.driver->axes().buttons();
  t.driver->render(test_push(t.time));
  return sample;
}

// False: nobody reads it.
bool show(Test& t, const HandSample& sample, bool terminal) {
  const AxisReader& axes = t.driver->axes();
  fmt::print("{}{:6.1f} s", terminal ? "\r\033[K" : "", t.time);
  for (std::size_t axis = 0; axis < kRawAxes; ++axis)
    if (axes.places()[axis].there)
      fmt::print("  {} {:6}", kAxisNames[axis], sample.counts[static_cast<Eigen::Index>(axis)]);
  fmt::print("  buttons {:08b}  {:4.0f} reports/s", axes.buttons() & 0xFFu,
             static_cast<double>(axes.reports() - t.reports_shown) / (t.time - t.shown));
  if (t.device.driver->force)
    fmt::print("  force X {:+.2f} Y {:+.2f}", t.driver->force()[0], t.driver->force()[1]);
  fmt::print("{}", terminal ? "" : "\n");
  t.shown = t.time;
  t.reports_shown = axes.reports();
  return std::fflush(stdout) == 0;
}

Json moved_axes(const Test& t) {
  Json axes = Json::object();
  for (std::size_t axis = 0; axis < kRawAxes; ++axis)
    if (const auto k = static_cast<Eigen::Index>(axis); t.low[k] != t.high[k])
      axes[kAxisNames[axis]] = {{"min", t.low[k]}, {"max", t.high[k]}};
  return axes;
}

int test_verb(const DevicesArguments& a) {
  using SteadyClock = std::chrono::steady_clock;
  Test t = begun(a.device);
  if (a.output.text()) introduce(t);
  const bool terminal = ::isatty(STDOUT_FILENO);
  const double between = terminal ? 0.1 : 1.0;  // shown [s]
  const auto begin = SteadyClock::now();
  for (std::int64_t tick = 0; !interrupted() && !t.lost; ++tick) {
    t.time = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    if (a.seconds > 0 && t.time >= a.seconds) break;
    const HandSample sample = pushed_and_read(t);
    if (a.output.text() && t.time - t.shown >= between && !show(t, sample, terminal)) break;
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick + 1));
  }
  t.driver.reset();  // without force before anything is said
  if (a.output.text()) fmt::print("{}{}", terminal ? "\n" : "", Provenance().foot());
  Json json = {{"device", t.name},
               {"time_s", t.time},
               {"axes_moved", moved_axes(t)},
               {"buttons", t.pressed},
               {"lost", t.lost}};
  json["table"] = Json::array();
  for (const auto& [axis, range] : json["axes_moved"].items()) {
    Json row = {{"axis", axis}};
    row.update(range);
    json["table"].push_back(row);
  }
  print_result(a.output, json, "table", {});
  if (t.lost) throw DeviceTrouble(t.device.transport->info().path + ": the device was lost");
  return kDone;
}

}  // namespace

Json device_json(const FoundDevice& device) {
  const HidInfo& info = device.info;
  Json json = {{"path", info.path},
               {"id", fmt::format("{:04x}:{:04x}", info.vendor, info.product)},
               {"name", info.name},
               {"kind", device.driver ? Json(device.driver->name) : Json(nullptr)},
               {"state", state_name(device)}};
  if (!device.missing.empty()) json["reason"] = device.missing;
  if (device.forbidden()) {
    json["udev_rule"] = udev_rule(info);
    json["command"] = udev_command(info);
  }
  return json;
}

void add_devices(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("devices", "What is connected and usable; --test shows it live");
  auto a = std::make_shared<DevicesArguments>();
  auto* test = verb->add_option("--test", a->device,
                                "Show axes, buttons, rate and forces of the first usable device, "
                                "or of this one")
                   ->expected(0, 1)
                   ->type_name("auto|PATH|" + fake_names("|"));
  verb->add_option("--seconds", a->seconds, "End the test by itself")
      ->needs(test)
      ->check(number_between(0.01, 1e6));
  add_output(*verb, a->output);
  add_examples(*verb, {"devices", "devices --test fake:spacemouse"});
  verb->callback([a, test, &run] {
    a->test = test->count() > 0;
    if (a->device.empty()) a->device = "auto";
    run.verb = [a] { return a->test ? test_verb(*a) : list_verb(*a); };
  });
}

}  // namespace ferrule
