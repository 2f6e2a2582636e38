#include "controller/safetensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "sim/base/error.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

std::string file_of(const std::string& header, const std::string& data) {
  const std::uint64_t length = header.size();
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &length, 8);
  return bytes + header + data;
}

std::string complaint(const std::string& bytes) {
  try {
    parse_safetensors(bytes, "w");
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(Safetensors, AreReadBackExactly) {
  RandomStream random(1, 0, Draw::plan);
  Tensors tensors;
  for (const auto& [name, shape] : std::map<std::string, std::vector<std::size_t>>{
           {"a.weight", {3, 4}}, {"b", {5}}, {"none", {0, 7}}, {"number", {}}}) {
    Tensor t{shape, {}};
    std::size_t count = 1;
    for (const std::size_t extent : shape) count *= extent;
    for (std::size_t i = 0; i < count; ++i) t.values.push_back(static_cast<float>(random.normal()));
    tensors[name] = t;
  }
  const Tensors back = parse_safetensors(safetensors_bytes(tensors, {{"format", "x"}}), "w");
  ASSERT_EQ(back.size(), tensors.size());
  for (const auto& [name, tensor] : tensors) {
    EXPECT_EQ(back.at(name).shape, tensor.shape);
    EXPECT_EQ(back.at(name).values, tensor.values);
  }
}

// A file written out by hand, byte by byte.
TEST(Safetensors, AreTheFormat) {
  const std::string header = R"({"x":{"dtype":"F32","shape":[1,2],"data_offsets":[0,8]}})";
  const std::string data("\x00\x00\x80\x3f\x00\x00\x20\xc1", 8);  // 1, -10
  const Tensors t = parse_safetensors(file_of(header, data), "w");
  EXPECT_EQ(t.at("x").values, (std::vector<float>{1, -10}));
  EXPECT_EQ(t.at("x").shape, (std::vector<std::size_t>{1, 2}));
  const std::string ours = safetensors_bytes(t, {});
  EXPECT_EQ(ours.substr(ours.size() - 8), data);
  std::uint64_t length = 0;
  std::memcpy(&length, ours.data(), 8);
  EXPECT_EQ(length % 8, 0u);
  EXPECT_EQ(length + 16, ours.size());
}

TEST(Safetensors, HostileOnesAreRefusedWithTheReason) {
  const auto array = [](const char* dtype, const char* shape, const char* offsets) {
    return std::string("{\"dtype\":\"") + dtype + "\",\"shape\":" + shape +
           ",\"data_offsets\":" + offsets + "}";
  };
  const auto one = [&](const char* dtype, const char* shape, const char* offsets) {
    return "{\"x\":" + array(dtype, shape, offsets) + "}";
  };
  const std::string eight(8, '\0');
  const auto says = [](const std::string& bytes, const char* reason) {
    EXPECT_NE(complaint(bytes).find(reason), std::string::npos) << complaint(bytes);
  };
  EXPECT_EQ(complaint(file_of(one("F32", "[2]", "[0,8]"), eight)), "");
  says("", "shorter than 8 bytes");
  says(std::string(8, '\xff'), "longer than the file");
  says(std::string("\x10\0\0\0\0\0\0\0{}", 10), "longer than the file");
  says(file_of("[1]", ""), "must be an object");
  says(file_of("{\"x\":", ""), "not valid JSON");
  says(file_of("{\"x\":" + std::string(100000, '['), ""), "nested deeper");
  says(file_of(one("F64", "[1]", "[0,8]"), eight), "x.dtype = \"F64\"");
  says(file_of(one("F32", "[3]", "[0,8]"), eight), "span the shape's 3 numbers");
  says(file_of(one("F32", "[2]", "[0,12]"), eight), "within the file's data of 8 bytes");
  says(file_of(one("F32", "[2]", "[8,0]"), eight), "x.data_offsets");
  says(file_of(one("F32", "[-2]", "[0,8]"), eight), "x.shape");
  says(file_of(one("F32", "[4611686018427387904,4]", "[0,0]"), eight), "x.shape");
  says(file_of(one("F32", "[65536,65536,65536,65536]", "[0,0]"), eight), "x.shape");
  says(file_of(one("F32", "[2.0]", "[0,8]"), eight), "x.shape");
  says(file_of(one("F32", "[2]", "[0]"), eight), "x.data_offsets");
  says(file_of(one("F32", "[1]", "[4,8]"), eight), "must begin where the array before");
  says(file_of(one("F32", "[1]", "[0,4]"), eight), "4 bytes behind its last array");
  says(file_of("{\"x\":" + array("F32", "[2]", "[0,8]") + ",\"y\":" + array("F32", "[1]", "[4,8]") +
                   "}",
               eight),
       "y.data_offsets: must begin");
  says(file_of("{\"x\":" + array("F32", "[1]", "[0,4]") + ",\"x\":" + array("F32", "[1]", "[4,8]") +
                   "}",
               eight),
       "there twice");
  says(file_of(one("F32", "[2]", "[0,8]"), std::string("\0\0\xc0\x7f\0\0\0\0", 8)), "not finite");
  says(file_of(one("F32", "[2]", "[0,8]"), std::string("\0\0\x80\xff\0\0\0\0", 8)), "not finite");
}

// Whatever is done to a file, it is read or refused in one line.
TEST(Safetensors, AnyCorruptionIsReadOrRefused) {
  Tensors tensors = {{"a", {{2, 3}, {1, 2, 3, 4, 5, 6}}}, {"b", {{2}, {7, 8}}}};
  const std::string good = safetensors_bytes(tensors, {{"format", "test"}});
  RandomStream random(7, 0, Draw::plan);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.bits() % n); };
  const std::string digits = "0123456789-\",[]{}:";
  std::size_t refused = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    std::string bad = good;
    for (std::size_t k = 1 + below(3); k > 0 && !bad.empty(); --k) {
      const std::size_t at = below(bad.size());
      switch (below(5)) {
        case 0:
          bad[at] = static_cast<char>(random.bits());
          break;
        case 1:
          bad[at] = digits[below(digits.size())];
          break;
        case 2:
          bad.resize(1 + at);
          break;
        case 3:
          bad.insert(at, 1 + below(9), digits[below(digits.size())]);
          break;
        default:
          bad.erase(at, 1 + below(9));
      }
    }
    try {
      for (const auto& [name, tensor] : parse_safetensors(bad, "w")) {
        EXPECT_LE(tensor.values.size(), bad.size() / 4);
        for (const float x : tensor.values) EXPECT_TRUE(std::isfinite(x));
      }
    } catch (const BadInput& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(refused, 10000u);
}

}  // namespace
}  // namespace ferrule
