#include "controller/safetensors.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kLengthBytes = 8;
constexpr std::uint64_t kLongestHeader = 1 << 20;
constexpr std::uint64_t kMostElements = 1 << 28;  // and bytes of one array
constexpr const char* kMetadata = "__metadata__";

struct Range {
  std::uint64_t from, to;
  std::string name;
};

// A list of whole numbers from 0 to kMostElements.
std::vector<std::uint64_t> whole_numbers(JsonFields& fields, const std::string& key) {
  const std::string expected = "must be a list of whole numbers, none above 2^28";
  const Json& list = fields.raw(key);
  if (!list.is_array() || list.size() > 8) fields.refuse(key, expected);
  std::vector<std::uint64_t> numbers;
  for (const Json& each : list) {
    if (!each.is_number_unsigned() || each.get<std::uint64_t>() > kMostElements)
      fields.refuse(key, expected);
    numbers.push_back(each);
  }
  return numbers;
}

// Throws BadInput unless the ranges follow each other from 0 to `size` without overlaps and gaps.
void expect_whole(std::vector<Range> ranges, std::uint64_t size, const std::string& file) {
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) {
    return std::pair(a.from, a.to) < std::pair(b.from, b.to);
  });
  std::uint64_t end = 0;
  for (const Range& range : ranges) {
    if (range.from != end)
      throw BadInput(file + ": " + range.name +
                     ".data_offsets: must begin where the array before " + "ends, at " +
                     std::to_string(end));
    end = range.to;
  }
  if (end != size)
    throw BadInput(file + ": has " + std::to_string(size - end) + " bytes behind its last array");
}

}  // namespace

std::string safetensors_bytes(const Tensors& tensors,
                              const std::map<std::string, std::string>& metadata) {
  Json header = Json::object();
  if (!metadata.empty()) header[kMetadata] = metadata;
  std::string data;
  for (const auto& [name, tensor] : tensors) {
    const std::size_t from = data.size();
    data.append(reinterpret_cast<const char*>(tensor.values.data()),
                tensor.values.size() * sizeof(float));
    header[name] = {
        {"dtype", "F32"}, {"shape", tensor.shape}, {"data_offsets", {from, data.size()}}};
  }
  std::string text = header.dump();
  text.append((kLengthBytes - text.size() % kLengthBytes) % kLengthBytes, ' ');  // aligns the data
  std::string bytes(kLengthBytes, '\0');
  const std::uint64_t length = text.size();
  std::memcpy(bytes.data(), &length, kLengthBytes);
  return bytes + text + data;
}

Tensors parse_safetensors(const std::string& bytes, const std::string& file) {
  std::uint64_t length = 0;
  if (bytes.size() < kLengthBytes)
    throw BadInput(file + ": not a safetensors file: shorter than 8 bytes");
  std::memcpy(&length, bytes.data(), kLengthBytes);
  if (length > kLongestHeader || length > bytes.size() - kLengthBytes)
    throw BadInput(file + ": not a safetensors file: its header of " + std::to_string(length) +
                   " bytes is longer than the file, or than 1 MiB");
  const Json header = parse_json(bytes.substr(kLengthBytes, length), file);
  const char* data = bytes.data() + kLengthBytes + length;
  const std::uint64_t size = bytes.size() - kLengthBytes - length;

  JsonFields arrays(header, file);
  Tensors tensors;
  std::vector<Range> ranges;
  for (const auto& [name, _] : header.items()) {
    if (!std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 127; }))
      throw BadInput(file + ": the name of an array must be of printable ASCII characters");
    JsonFields fields = arrays.object(name);
    if (name == kMetadata) continue;
    fields.choice("dtype", {"F32"});
    Tensor tensor;
    std::uint64_t count = 1;
    for (const std::uint64_t extent : whole_numbers(fields, "shape")) {
      tensor.shape.push_back(extent);
      if (extent > 0 && count > kMostElements / extent)
        fields.refuse("shape", "must be of at most 2^28 numbers");
      count *= extent;
    }
    const std::vector<std::uint64_t> offsets = whole_numbers(fields, "data_offsets");
    fields.finish();
    if (offsets.size() != 2 || offsets[0] > offsets[1] || offsets[1] > size)
      fields.refuse("data_offsets", "must be [from, to] within the file's data of " +
                                        std::to_string(size) + " bytes");
    if (offsets[1] - offsets[0] != count * sizeof(float))
      fields.refuse("data_offsets",
                    "must span the shape's " + std::to_string(count) + " numbers of 4 bytes");
    tensor.values.resize(count);
    if (count > 0) std::memcpy(tensor.values.data(), data + offsets[0], count * sizeof(float));
    if (!std::all_of(tensor.values.begin(), tensor.values.end(),
                     [](float x) { return std::isfinite(x); }))
      throw BadInput(file + ": " + name + ": holds a number that is not finite");
    ranges.push_back({offsets[0], offsets[1], name});
    tensors[name] = std::move(tensor);
  }
  expect_whole(std::move(ranges), size, file);
  return tensors;
}

}  // namespace ferrule
