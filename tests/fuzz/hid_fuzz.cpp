// Report descriptors and reports from anywhere: nothing may crash, read outside, or overflow.
//
// The input is a descriptor (its length in the first two bytes) and then reports (each after a byte
// of length). It starts from the descriptors of the firmware model:
//   CXX=clang++ cmake -S . -B build-fuzz -G Ninja -DFERRULE_FUZZ=ON && ninja -C build-fuzz hid_fuzz
//   build-fuzz/tests/hid_fuzz -max_total_time=60
#include <cstdlib>

#include "haptic/hid/axis_reader.hpp"
#include "haptic/hid/fake_firmware.hpp"
#include "haptic/hid/pid_reports.hpp"

using namespace ferrule;

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void serve(const PidReports& reports, std::span<const std::uint8_t> bytes) {
  const int number = bytes.empty() ? 1 : bytes[0];
  for (const HidReport& report :
       {reports.create_constant(), reports.block_load_request(),
        reports.set_effect(number, number % 2, 0.15),
        reports.set_constant_force(number, 0.01 * number),
        reports.operation(number, PidOperation::start), reports.control(PidControl::stop_all)})
    require(report.size <= 65);
  reports.block_free(number);
  reports.full_device_gain();
  const PidBlockLoad load = reports.block_load(bytes);
  require(load.status != PidBlockLoad::Status::success || load.block > 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::uint8_t> rest(data, size);
  if (size < 2) return 0;
  const std::size_t length = std::min<std::size_t>(rest[0] | rest[1] << 8, size - 2);
  const auto bytes = rest.subspan(2, length);
  rest = rest.subspan(2 + length);
  try {
    const HidDescriptor descriptor = parse_report_descriptor(bytes);
    AxisReader reader(descriptor);
    std::optional<PidReports> reports;
    if (PidReports::in(descriptor)) {
      try {
        reports.emplace(descriptor);
      } catch (const DeviceTrouble&) {
      }
    }
    while (!rest.empty()) {
      const std::size_t n = std::min<std::size_t>(rest[0], rest.size() - 1);
      const auto report = rest.subspan(1, n);
      reader.take(report);
      for (const HidField& field : descriptor.fields) get_field(field, report, field.count - 1u);
      if (reports) serve(*reports, report);
      rest = rest.subspan(1 + n);
    }
  } catch (const DeviceTrouble&) {
  }
  return 0;
}

// Where nothing is given to start from: the descriptors of the firmware model with some bytes
// changed.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  if (seed % 64 != 0) return LLVMFuzzerMutate(data, size, most);
  constexpr FakeModel kModels[] = {FakeModel::space_mouse_split, FakeModel::space_mouse_combined,
                                   FakeModel::pid_18, FakeModel::pid_22};
  const auto bytes = FakeFirmware::describe(kModels[seed / 64 % 4]).descriptor;
  if (bytes.size() + 2 > most) return LLVMFuzzerMutate(data, size, most);
  data[0] = static_cast<std::uint8_t>(bytes.size());
  data[1] = static_cast<std::uint8_t>(bytes.size() >> 8);
  std::copy(bytes.begin(), bytes.end(), data + 2);
  return bytes.size() + 2;
}
