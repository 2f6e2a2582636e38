// What a page may send: bytes of a WebSocket, read as the window's server reads them, and the
// messages in them.
#include <boost/beast/_experimental/test/stream.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "tests/fuzz/from.hpp"
#include "view/message.hpp"

namespace ferrule::fuzz {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr const char* kUpgrade =
    "GET /live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n";

// A frame by a client, masked with zeros.
std::string frame(const std::string& text, unsigned char first = 0x81) {
  std::string bytes{static_cast<char>(first)};
  if (text.size() < 126)
    bytes += static_cast<char>(0x80 | text.size());
  else
    (bytes += "\xfe") += {static_cast<char>(text.size() >> 8), static_cast<char>(text.size())};
  return bytes + std::string(4, '\0') + text;
}

}  // namespace

std::vector<std::string> examples() {
  const std::string hand = R"({"type":"hand","v":[-0.5,0.25,1],"buttons":1,"seq":12,"t":16.7})";
  return {frame(hand) + frame(hand) + frame(R"({"type":"stop"})"),
          frame(R"({"type":"fit","episodes":["episode_0001.h5"]})"),
          frame(R"({"type":"rate",)", 0x01) + frame(R"("stars":5})", 0x80),
          frame("ping", 0x89) + frame("", 0x8a) + frame("\x03\xe8", 0x88),
          frame(std::string(300, '[')),
          hand};
}

void read(const std::string& bytes) {
  try {
    parse_message(bytes);
  } catch (const BadInput&) {
  }
  boost::asio::io_context io;
  beast::test::stream in(io), out(io);
  in.connect(out);
  in.append(kUpgrade);
  websocket::stream<beast::test::stream&> socket(in);
  socket.read_message_max(kMostMessage);
  beast::error_code error;
  socket.accept(error);
  if (error) std::abort();
  in.append(bytes);
  in.close_remote();
  while (!error) {
    beast::flat_buffer buffer;
    const std::size_t size = socket.read(buffer, error);
    if (error) break;
    try {
      parse_message({static_cast<const char*>(buffer.data().data()), size});
    } catch (const BadInput&) {
    }
  }
}

}  // namespace ferrule::fuzz
