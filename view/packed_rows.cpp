#include "view/packed_rows.hpp"

#include <bit>
#include <boost/beast/zlib/deflate_stream.hpp>

namespace ferrule {
namespace {

constexpr std::size_t kBytes = 4;  // of a number

std::string planes(const std::vector<Frame>& frames) {
  const std::size_t rows = frames.size();
  std::string bytes(rows * kFrameColumns * kBytes, '\0');
  for (std::size_t column = 0; column < kFrameColumns; ++column) {
    char* const begin = bytes.data() + column * rows * kBytes;
    std::uint32_t before = 0;
    for (std::size_t n = 0; n < rows; ++n) {
      const auto bits = std::bit_cast<std::uint32_t>(frames[n][column]);
      for (std::size_t plane = 0; plane < kBytes; ++plane)
        begin[plane * rows + n] = static_cast<char>((bits - before) >> (8 * plane) & 0xff);
      before = bits;
    }
  }
  return bytes;
}

std::string deflated(const std::string& bytes) {
  namespace zlib = boost::beast::zlib;
  constexpr int kLevel = 6, kWindow = 15, kMemory = 8;
  zlib::deflate_stream stream;
  stream.reset(kLevel, kWindow, kMemory, zlib::Strategy::normal);
  std::string out(stream.upper_bound(bytes.size()) + 64, '\0');
  zlib::z_params params;
  params.next_in = bytes.data();
  params.avail_in = bytes.size();
  params.next_out = out.data();
  params.avail_out = out.size();
  boost::beast::error_code error;
  stream.write(params, zlib::Flush::finish, error);
  if (error != zlib::error::end_of_stream)
    throw std::logic_error("packed_rows: " + error.message());
  out.resize(params.total_out);
  return out;
}

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u;
    };
    const unsigned three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return text;
}

}  // namespace

std::string packed_rows(const std::vector<Frame>& frames) {
  return base64(deflated(planes(frames)));
}

}  // namespace ferrule
