#include "view/packed_rows.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <cmath>
#include <random>

namespace ferrule {
namespace {

std::string from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 0xff);
  }
  return bytes;
}

std::vector<Frame> unpacked(const std::string& text, std::size_t rows) {
  const std::string packed = from_base64(text);
  std::string bytes(rows * sizeof(Frame), '\0');
  boost::beast::zlib::inflate_stream stream;
  boost::beast::zlib::z_params params;
  params.next_in = packed.data();
  params.avail_in = packed.size();
  params.next_out = bytes.data();
  params.avail_out = bytes.size();
  boost::beast::error_code error;
  stream.write(params, boost::beast::zlib::Flush::finish, error);
  EXPECT_EQ(error, boost::beast::zlib::error::end_of_stream) << error.message();
  EXPECT_EQ(params.total_out, bytes.size());
  std::vector<Frame> frames(rows);
  for (std::size_t column = 0; column < kFrameColumns; ++column) {
    std::uint32_t sum = 0;
    for (std::size_t n = 0; n < rows; ++n) {
      for (std::size_t plane = 0; plane < 4; ++plane)
        sum += static_cast<std::uint32_t>(
                   static_cast<unsigned char>(bytes[(4 * column + plane) * rows + n]))
               << (8 * plane);
      frames[n][column] = std::bit_cast<float>(sum);
    }
  }
  return frames;
}

TEST(PackedRows, NothingIsLost) {
  for (const std::size_t rows : {1, 2, 7, 400}) {
    std::vector<Frame> frames(rows);
    std::mt19937 random(static_cast<unsigned>(rows));
    std::normal_distribution<double> normal;
    for (Frame& frame : frames)
      for (std::size_t i = 0; i < frame.size(); ++i)
        frame[i] =
            static_cast<float>(normal(random) * std::pow(10.0, static_cast<double>(i % 40) - 20));
    frames.back()[3] = NAN;
    frames.front()[4] = -INFINITY;
    const std::vector<Frame> found = unpacked(packed_rows(frames), rows);
    for (std::size_t n = 0; n < rows; ++n)
      for (std::size_t i = 0; i < frames[n].size(); ++i)
        ASSERT_EQ(std::bit_cast<std::uint32_t>(found[n][i]),
                  std::bit_cast<std::uint32_t>(frames[n][i]));
  }
}

TEST(PackedRows, WhatDoesNotChangeTakesNextToNothing) {
  Frame still;
  still.fill(1.2345f);
  EXPECT_LT(packed_rows(std::vector<Frame>(1000, still)).size(), 1000 * sizeof(Frame) / 200);
  EXPECT_TRUE(unpacked(packed_rows({}), 0).empty());
}

}  // namespace
}  // namespace ferrule
