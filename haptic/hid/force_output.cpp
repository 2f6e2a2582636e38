#include "haptic/hid/force_output.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace ferrule {
namespace {

// Times that a device is asked for the effect it makes; some are slow (as Linux' hid-pidff has it).
constexpr int kMostAsked = 60;

PidReports reports_of(const HidInfo& info) {
  try {
    return PidReports(parse_report_descriptor(info.descriptor));
  } catch (const DeviceTrouble& trouble) {
    throw DeviceTrouble(info.path + ": " + trouble.what());
  }
}

}  // namespace

ForceOutput::ForceOutput(HidTransport& transport)
    : transport_(transport), reports_(reports_of(transport.info())) {
  running_ = true;
  try {
    start();
  } catch (...) {
    stop();
    throw;
  }
}

ForceOutput::~ForceOutput() {
  stop();
}

void ForceOutput::start() {
  if (const double said = reports_.said_duration(kDuration); !(said >= 0.1 && said <= 0.2))
    throw DeviceTrouble(transport_.info().path +
                        ": cannot end an effect by itself after 100 to 200 ms");
  // Effects of a program that died here before are gone after a reset. Not every device takes one.
  try_write(reports_.control(PidControl::reset));
  for (; made_ < axes(); ++made_) {
    const HidReport create = reports_.create_constant();
    HidReport answer = reports_.block_load_request();
    if (!transport_.send_feature(create.span()))
      throw DeviceTrouble(transport_.info().path + ": refuses to make an effect");
    PidBlockLoad load{PidBlockLoad::Status::error, 0};
    for (int i = 0; i < kMostAsked && load.status == PidBlockLoad::Status::error; ++i) {
      const int length = transport_.get_feature(answer.span());
      if (length <= 0) break;
      load = reports_.block_load(
          answer.span().first(std::min<std::size_t>(static_cast<std::size_t>(length), 65)));
      answer = reports_.block_load_request();
    }
    if (load.status == PidBlockLoad::Status::full)
      throw DeviceTrouble(transport_.info().path + ": has no room for another effect");
    if (load.status == PidBlockLoad::Status::error)
      throw DeviceTrouble(transport_.info().path + ": could not make an effect");
    Effect& effect = effects_[static_cast<std::size_t>(made_)];
    effect.block = load.block;
    effect.sent = reports_.set_constant_force(load.block, 0);
    write(reports_.set_effect(load.block, made_, kDuration), "Set Effect");
    write(effect.sent, "Set Constant Force");
  }
  if (const auto gain = reports_.full_device_gain()) write(*gain, "Device Gain");
  write(reports_.control(PidControl::enable), "Device Control");
  for (int i = 0; i < made_; ++i)
    write(reports_.operation(effects_[static_cast<std::size_t>(i)].block, PidOperation::start),
          "Effect Operation");
}

bool ForceOutput::update(double t, const std::array<double, 2>& force) noexcept {
  if (!running_) return false;
  if (std::all_of(force.begin(), force.begin() + made_,
                  [](double f) { return !(f != 0 && std::isfinite(f)); })) {
    bool arrived = true, changed = false;
    for (int i = 0; i < made_; ++i) {
      Effect& effect = effects_[static_cast<std::size_t>(i)];
      const HidReport none = reports_.set_constant_force(effect.block, 0);
      if (std::ranges::equal(none.span(), effect.sent.span())) continue;
      effect.sent = none;
      changed = true;
      arrived = try_write(none) && arrived;
    }
    if (changed) return arrived;
  }
  for (int i = 0; i < made_; ++i) {
    Effect& effect = effects_[static_cast<std::size_t>(i)];
    if (t - effect.started < kAgain) continue;
    effect.started = t;
    return try_write(reports_.operation(effect.block, PidOperation::start));
  }
  for (int i = 0; i < made_; ++i) {
    const auto axis = static_cast<std::size_t>((next_ + i) % made_);
    Effect& effect = effects_[axis];
    const HidReport wanted = reports_.set_constant_force(effect.block, force[axis]);
    if (std::ranges::equal(wanted.span(), effect.sent.span())) continue;
    effect.sent = wanted;
    next_ = static_cast<int>(axis) + 1;
    return try_write(wanted);
  }
  return true;
}

void ForceOutput::stop() noexcept {
  if (!running_) return;
  running_ = false;
  for (int i = 0; i < made_; ++i) {
    const int block = effects_[static_cast<std::size_t>(i)].block;
    try_write(reports_.set_constant_force(block, 0));
    try_write(reports_.operation(block, PidOperation::stop));
  }
  try_write(reports_.control(PidControl::stop_all));
  try_write(reports_.control(PidControl::disable));
  for (int i = 0; i < made_; ++i)
    if (const auto free = reports_.block_free(effects_[static_cast<std::size_t>(i)].block))
      try_write(*free);
  made_ = 0;
  try_write(reports_.control(PidControl::reset));
}

void ForceOutput::write(const HidReport& report, const char* what) {
  if (!try_write(report)) throw DeviceTrouble(transport_.info().path + ": refuses " + what);
}

bool ForceOutput::try_write(const HidReport& report) noexcept {
  return transport_.write(report.span());
}

}  // namespace ferrule
