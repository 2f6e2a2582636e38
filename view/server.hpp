// The window's server: HTTP and WebSocket (RFC 6455) on 127.0.0.1, by Boost.Beast, in one thread.
//
//   http://127.0.0.1:PORT/TOKEN/            the page
//   http://127.0.0.1:PORT/TOKEN/recorded    what is to be replayed, as JSON; ?file=NAME an episode
//   ws://127.0.0.1:PORT/TOKEN/live          texts and frames out, messages (view/message.hpp) in
//
// Who may talk to it: Host must be 127.0.0.1:PORT, localhost:PORT or [::1]:PORT (else a page
// elsewhere could reach it by a name of its own), Origin, which a WebSocket must have, http:// and
// that; TOKEN is 128 bits of the operating system's chance, compared in constant time. Methods are
// GET and HEAD; there is no path but these, and no file is opened by what a request says.
//
// Nobody can hold it up: kMostConnections at once (the oldest that has not said what it wants gives
// way), kMostClients of them sockets; headers of 8 kB within kHeaderTime; messages of kMostMessage
// bytes, kMostRate a second (the rest waits unread); a client that leaves kMostWaiting bytes unread
// is cut off.
//
// A client is closed with 1001 (going away) where the program ends in order, after all that it was
// to hear; one that was killed closes without a word.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ferrule {

// One message to a page.
struct Payload {
  enum class Kind { text, frames };
  Kind kind;
  std::string bytes;
  // Worth nothing once there is a newer one: left out where a client is slow.
  bool newest_only = false;
};
using SharedPayload = std::shared_ptr<const Payload>;

class Server {
 public:
  static constexpr std::size_t kMostConnections = 32, kMostClients = 8;
  static constexpr std::chrono::seconds kHeaderTime{5};
  static constexpr int kMostRate = 300;
  static constexpr std::size_t kMostWaiting = 16 << 20;

  // What it serves. All but `recorded` are called in the server's thread.
  struct Served {
    std::function<std::string()> page;  // HTML, for one who asks now
    // `file` is what the request says, empty where it says none. Empty: there is nothing. Called in
    // a thread that may take its time; throws BadInput, FileTrouble.
    std::function<std::optional<std::string>(const std::string& file)> recorded;
    // What a new client is told first.
    std::function<std::vector<SharedPayload>()> greeting;
    // Of client number `client`. Throws BadInput: the client is told.
    std::function<void(std::uint64_t client, std::string_view text)> message;
  };

  // Listens on `port`, 0: any that is free. Throws BadInput where it is taken.
  Server(std::uint16_t port, Served served);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server();

  std::uint16_t port() const noexcept;
  // http://127.0.0.1:PORT/TOKEN/
  std::string address() const;

  // To all clients, in this order, from any thread.
  void send(SharedPayload payload);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace ferrule
