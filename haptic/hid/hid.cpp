#include "haptic/hid/hid.hpp"

#include <hidapi.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace ferrule {
namespace {

std::string narrow(const wchar_t* text) {
  std::string result;
  for (; text && *text; ++text)
    if (*text >= 32 && *text < 127) result += static_cast<char>(*text);
  return result;
}

// hidapi 0.13 has no call for it; the kernel shows it to everyone.
std::vector<std::uint8_t> read_descriptor(const std::string& path) {
  const std::string node = std::filesystem::path(path).filename().string();
  std::ifstream file("/sys/class/hidraw/" + node + "/device/report_descriptor", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Hidapi : public HidTransport {
 public:
  explicit Hidapi(const HidInfo& device) : HidTransport(device) {
    errno = 0;
    if (handle_ = hid_open_path(device.path.c_str()); handle_) return;
    // hidapi forgets what was wrong after the open.
    const int error = errno;
    throw DeviceTrouble(device.path + ": cannot be opened: " +
                        (error ? std::strerror(error) : narrow(hid_error(nullptr))));
  }
  ~Hidapi() override { hid_close(handle_); }

  int read(std::span<std::uint8_t> report, int timeout) noexcept override {
    return hid_read_timeout(handle_, report.data(), report.size(), timeout);
  }
  bool write(std::span<const std::uint8_t> report) noexcept override {
    return hid_write(handle_, report.data(), report.size()) >= 0;
  }
  bool send_feature(std::span<const std::uint8_t> report) noexcept override {
    return hid_send_feature_report(handle_, report.data(), report.size()) >= 0;
  }
  int get_feature(std::span<std::uint8_t> report) noexcept override {
    return hid_get_feature_report(handle_, report.data(), report.size());
  }

 private:
  hid_device* handle_;
};

}  // namespace

std::vector<HidInfo> list_hid() {
  std::vector<HidInfo> all;
  hid_device_info* const list = hid_enumerate(0, 0);
  // A device with several application collections is listed once for each.
  for (const hid_device_info* d = list; d; d = d->next) {
    if (std::any_of(all.begin(), all.end(), [&](const HidInfo& i) { return i.path == d->path; }))
      continue;
    all.push_back({d->path, d->vendor_id, d->product_id, d->usage_page, d->usage,
                   narrow(d->product_string), read_descriptor(d->path)});
  }
  hid_free_enumeration(list);
  std::sort(all.begin(), all.end(),
            [](const HidInfo& a, const HidInfo& b) { return a.path < b.path; });
  return all;
}

std::unique_ptr<HidTransport> open_hid(const HidInfo& info) {
  return std::make_unique<Hidapi>(info);
}

}  // namespace ferrule
