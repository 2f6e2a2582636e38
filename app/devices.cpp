// ferrule devices: what is connected and usable, and a look at what it sends.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

#include "app/connected.hpp"
#include "app/verb.hpp"
#include "haptic/hid/force_stick.hpp"
#include "haptic/hid/space_mouse.hpp"
#include "insertion/hand_device.hpp"

namespace ferrule {
namespace {

constexpr double kPush = 0.1;  // of the device's force, while it is tested [-]
constexpr const char* kAxisNames[] = {"X", "Y", "Z", "Rx", "Ry", "Rz"};

struct Arguments {
  std::string device = "auto";
  double seconds = 0;
  bool test = false, json = false;
};

const char* state_name(const FoundDevice& device) {
  return !device.kind              ? "never used"
         : !device.missing.empty() ? "unusable"
         : device.permitted        ? "usable"
                                   : "forbidden";
}

int list_verb(const Arguments& a) {
  const std::vector<FoundDevice> found = find_devices();
  Json list = Json::array();
  for (const FoundDevice& d : found) {
    list.push_back(device_json(d));
    if (a.json) continue;
    fmt::print("{}  {}  {:<11}  {:<10}  {}\n", d.info.path, list.back()["id"].get<std::string>(),
               d.kind ? name(*d.kind) : "-", state_name(d), d.info.name);
    if (d.forbidden())
      fmt::print(
          "  found, but not permitted; this udev rule lets whoever sits at the machine open it:\n"
          "    {}\n  once, and then plug it in again:\n    {}\n",
          udev_rule(d.info), udev_command(d.info));
    if (!d.missing.empty()) fmt::print("  cannot be used: {}\n", d.missing);
    if (!d.kind)
      fmt::print("  a mouse, keyboard or receiver of a maker of SpaceMice: left alone\n");
  }
  if (a.json)
    print_json({{"devices", list}});
  else if (found.empty())
    fmt::print("no device is connected; --device fake:spacemouse or fake:pid tries without one\n");
  return kDone;
}

// A device under test: its driver, and what to show of it.
struct Tested {
  std::string name;
  std::unique_ptr<HidTransport> transport;
  FakeFirmware* fake = nullptr;  // the transport, if it is one
  std::unique_ptr<Device> driver;
  const AxisReader* axes = nullptr;
  const ForceStick* stick = nullptr;
  const SpaceMouse* mouse = nullptr;
};

Tested open_tested(const std::string& wanted) {
  Tested t;
  DeviceKind kind;
  if (const auto model = fake_model(wanted)) {
    auto firmware = std::make_unique<FakeFirmware>(*model);
    t.fake = firmware.get();
    t.transport = std::move(firmware);
    kind = fake_kind(*model);
  } else if (wanted.starts_with("fake:")) {
    throw BadInput("--test " + wanted + ": must be fake:spacemouse or fake:pid");
  } else {
    const FoundDevice found = choose_device(wanted);
    t.transport = open_hid(found.info);
    kind = *found.kind;
  }
  t.name =
      fmt::format("{} {} ({})", t.transport->info().path, name(kind), t.transport->info().name);
  if (kind == DeviceKind::space_mouse) {
    auto mouse = std::make_unique<SpaceMouse>(*t.transport, 1.0, 1.0, HandPose::Zero());
    t.axes = &mouse->axes();
    t.mouse = mouse.get();
    t.driver = std::move(mouse);
  } else {
    auto stick = std::make_unique<ForceStick>(*t.transport, 1.0, 1.0, HandPose::Zero());
    t.axes = &stick->axes();
    t.stick = stick.get();
    t.driver = std::move(stick);
  }
  return t;
}

// The hand on a fake device: axes swing, a button now and then.
void move_fake(FakeFirmware& firmware, double t) {
  std::array<int, 6> counts{};
  for (std::size_t axis = 0; axis < counts.size(); ++axis)
    counts[axis] = static_cast<int>(std::lround(
        350 * std::sin(2 * std::numbers::pi * t / (2.0 + 0.3 * static_cast<double>(axis)))));
  firmware.deflect(counts);
  firmware.press(std::fmod(t, 1) > 0.8 ? 1 : 0);
  firmware.advance(t);
}

int test_verb(const Arguments& a) {
  using Clock = std::chrono::steady_clock;
  Tested device = open_tested(a.device);
  if (!a.json) {
    fmt::print("{}; Ctrl-C ends this\n", device.name);
    if (device.fake) fmt::print("this device is simulated: nobody's hand is on it\n");
    if (device.stick)
      fmt::print("hold it: it pushes with {:.0f} % of its force, along X and Y in turn\n",
                 100 * kPush);
  }
  watch_for_interrupt();
  const bool terminal = ::isatty(STDOUT_FILENO);
  const auto begin = Clock::now();
  RawCounts low = device.axes->counts(), high = low;
  std::uint32_t pressed = 0;
  bool lost = false;
  double t = 0, shown = 0;
  std::int64_t reports_shown = 0;
  for (std::int64_t tick = 0; !interrupted() && !lost; ++tick) {
    t = std::chrono::duration<double>(Clock::now() - begin).count();
    if (a.seconds > 0 && t >= a.seconds) break;
    if (device.fake) move_fake(*device.fake, t);
    const HandSample sample = device.driver->read(t);
    lost = sample.lost;
    low = low.cwiseMin(sample.counts);
    high = high.cwiseMax(sample.counts);
    pressed |= device.axes->buttons();
    const double push = kPush * std::sin(2 * std::numbers::pi * t);
    HandWrench wrench = HandWrench::Zero();
    wrench[std::fmod(t, 2) < 1 ? 0 : 1] = push;
    device.driver->render(wrench);
    const double between = terminal ? 0.1 : 1.0;  // [s]
    if (!a.json && t - shown >= between) {
      fmt::print("{}{:6.1f} s", terminal ? "\r\033[K" : "", t);
      for (std::size_t axis = 0; axis < kRawAxes; ++axis)
        if (device.axes->places()[axis].there)
          fmt::print("  {} {:6}", kAxisNames[axis], sample.counts[static_cast<Eigen::Index>(axis)]);
      fmt::print("  buttons {:08b}  {:4.0f} reports/s", device.axes->buttons() & 0xFFu,
                 static_cast<double>(device.axes->reports() - reports_shown) / (t - shown));
      if (device.stick)
        fmt::print("  force X {:+.2f} Y {:+.2f}", device.stick->force()[0],
                   device.stick->force()[1]);
      fmt::print("{}", terminal ? "" : "\n");
      if (std::fflush(stdout) != 0) break;  // nobody reads it
      shown = t;
      reports_shown = device.axes->reports();
    }
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick + 1));
  }
  device.driver.reset();  // without force before anything is said
  Json axes = Json::object();
  for (std::size_t axis = 0; axis < kRawAxes; ++axis)
    if (low[static_cast<Eigen::Index>(axis)] != high[static_cast<Eigen::Index>(axis)])
      axes[kAxisNames[axis]] = {{"min", low[static_cast<Eigen::Index>(axis)]},
                                {"max", high[static_cast<Eigen::Index>(axis)]}};
  if (a.json) {
    print_json({{"device", device.name},
                {"time_s", t},
                {"axes_moved", axes},
                {"buttons", pressed},
                {"lost", lost}});
  } else {
    fmt::print("{}", terminal ? "\n" : "");
  }
  if (lost) throw DeviceTrouble(device.transport->info().path + ": the device was lost");
  return kDone;
}

}  // namespace

Json device_json(const FoundDevice& device) {
  const HidInfo& info = device.info;
  Json json = {{"path", info.path},
               {"id", fmt::format("{:04x}:{:04x}", info.vendor, info.product)},
               {"name", info.name},
               {"kind", device.kind ? Json(name(*device.kind)) : Json(nullptr)},
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
  auto a = std::make_shared<Arguments>();
  auto* test = verb->add_option("--test", a->device,
                                "Show axes, buttons, rate and forces of the first usable device, "
                                "or of this one")
                   ->expected(0, 1)
                   ->type_name("auto|PATH|fake:spacemouse|fake:pid");
  verb->add_option("--seconds", a->seconds, "End the test by itself")
      ->needs(test)
      ->check(number_between(0.01, 1e6));
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, test, &run] {
    a->test = test->count() > 0;
    if (a->device.empty()) a->device = "auto";
    run = [a] { return a->test ? test_verb(*a) : list_verb(*a); };
  });
}

}  // namespace ferrule
