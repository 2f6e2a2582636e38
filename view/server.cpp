#include "view/server.hpp"

#include <fmt/format.h>
#include <sys/random.h>
#include <sys/resource.h>

#include <array>
#include <boost/algorithm/string/replace.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cerrno>
#include <cstring>
#include <deque>
#include <list>
#include <thread>

#include "sim/base/error.hpp"
#include "sim/base/json_fields.hpp"
#include "view/message.hpp"
#include "view/page_file.hpp"

namespace ferrule {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

// This machine's own, which no page elsewhere can give itself. [::1] comes by a tunnel.
constexpr std::array kNames = {"127.0.0.1", "localhost", "[::1]"};
constexpr int kNice = 5;                     // of its thread, behind the loop's
constexpr std::chrono::seconds kGoodbye{1};  // for pages to hear that the program ends

// 128 bits in hexadecimal.
std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t n = ::getrandom(bytes.data() + got, bytes.size() - got, 0);
    if (n < 0 && errno != EINTR)
      throw FileTrouble(std::string("no random numbers: ") + std::strerror(errno));
    if (n > 0) got += static_cast<std::size_t>(n);
  }
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

// Without saying by the time it takes how many letters are right.
bool same(std::string_view a, std::string_view b) noexcept {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differs |=
        static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  return differs == 0;
}

std::string_view view(beast::string_view text) noexcept {
  return {text.data(), text.size()};
}

// What a query says of `file`, percent-decoded; empty where it says nothing or nothing sensible.
std::string file_of(std::string_view query) {
  constexpr std::string_view kKey = "file=";
  std::string file;
  if (!query.starts_with(kKey)) return file;
  query.remove_prefix(kKey.size());
  for (std::size_t i = 0; i < query.size(); ++i) {
    if (query[i] != '%') {
      file += query[i];
      continue;
    }
    unsigned value = 0;
    for (const std::size_t at : {i + 1, i + 2}) {
      const char c = at < query.size() ? query[at] : '\0';
      const std::string_view digits = "0123456789abcdef";
      const auto digit = digits.find(static_cast<char>(c >= 'A' && c <= 'F' ? c + 32 : c));
      if (c == '\0' || digit == digits.npos) return {};
      value = 16 * value + static_cast<unsigned>(digit);
    }
    file += static_cast<char>(value);
    i += 2;
  }
  return file;
}

// The page's own policy, with sockets to this server alone ('self' is that of a page at [::1], for
// which a policy has no name), and in no frame, which a page cannot say of itself.
std::string served_policy(const std::string& page, std::uint16_t port) {
  return boost::replace_all_copy(policy_of(page), ":*", fmt::format(":{}", port)) +
         "; frame-ancestors 'none'";
}

Response respond(const Request& request, http::status status, std::string body,
                 const char* type = "text/plain; charset=utf-8") {
  Response response{status, request.version()};
  response.set(http::field::content_type, type);
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.keep_alive(false);
  response.body() = std::move(body);
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  return response;
}

}  // namespace

class Server::Work {
 public:
  Work(std::uint16_t port, Served served);
  ~Work();

  std::uint16_t port() const noexcept { return port_; }
  const std::string& token() const noexcept { return token_; }
  void send(SharedPayload payload);

 private:
  class Connection;
  class Client;

  void accept();
  void make_room();
  std::optional<Response> refusal(const Request& request) const;
  std::string_view path_of(const Request& request) const;  // after the token; null without it
  void pass(const SharedPayload& payload);

  Served served_;
  std::string token_ = random_token();
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer pause_{io_};
  asio::thread_pool slow_{1};
  std::uint16_t port_ = 0;
  std::list<std::weak_ptr<Connection>> connections_;  // oldest first
  std::vector<std::shared_ptr<Client>> clients_;
  std::uint64_t last_client_ = 0;
  std::thread thread_;
};

// A page's socket.
class Server::Work::Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Work& work, std::uint64_t number, beast::tcp_stream stream)
      : work_(work), number_(number), socket_(std::move(stream)), pause_(work.io_) {}

  void start(const Request& request) {
    auto timeouts = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeouts.handshake_timeout = kHeaderTime;
    timeouts.idle_timeout = std::chrono::seconds(20);
    timeouts.keep_alive_pings = true;
    socket_.set_option(timeouts);
    socket_.read_message_max(kMostMessage);
    socket_.auto_fragment(false);
    beast::get_lowest_layer(socket_).socket().set_option(tcp::no_delay(true));
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return self->leave();
      if (self->work_.clients_.size() >= kMostClients) return self->leave();
      self->work_.clients_.push_back(self);
      for (SharedPayload& payload : self->work_.served_.greeting()) self->put(std::move(payload));
      self->read();
    });
  }

  void put(SharedPayload payload) {
    if (left_) return;
    if (payload->newest_only)
      for (std::size_t i = writing_ ? 1 : 0; i < queue_.size(); ++i)
        if (queue_[i]->newest_only) {
          waiting_ += payload->bytes.size();
          waiting_ -= queue_[i]->bytes.size();
          queue_[i] = std::move(payload);
          return;
        }
    waiting_ += payload->bytes.size();
    queue_.push_back(std::move(payload));
    if (waiting_ > kMostWaiting) return leave();
    if (!writing_) write();
  }

  // Once it has been told what waits, the close of a program that ends.
  void say_goodbye() {
    ending_ = true;
    if (!writing_) write();
  }

  void leave() {
    if (left_) return;
    left_ = true;
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
    pause_.cancel();
    std::erase_if(work_.clients_, [this](const auto& other) { return other.get() == this; });
    if (ending_ && work_.clients_.empty()) work_.io_.stop();
  }

 private:
  void write() {
    if (left_) return;
    if (queue_.empty() && ending_)
      return socket_.async_close(websocket::close_code::going_away,
                                 [self = shared_from_this()](error_code) { self->leave(); });
    if (queue_.empty()) return;
    writing_ = true;
    const Payload& payload = *queue_.front();
    socket_.text(payload.kind == Payload::Kind::text);
    socket_.async_write(
        asio::buffer(payload.bytes),
        [self = shared_from_this(), kept = queue_.front()](error_code error, std::size_t) {
          if (error || self->left_) return self->leave();
          self->waiting_ -= kept->bytes.size();
          self->writing_ = false;
          self->queue_.pop_front();
          self->write();
        });
  }

  void read() {
    if (left_) return;
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t size) {
      if (error || !self->socket_.got_text()) return self->leave();
      self->take({static_cast<const char*>(self->buffer_.data().data()), size});
      self->buffer_.consume(self->buffer_.size());
      self->next();
    });
  }

  void take(std::string_view text) {
    try {
      work_.served_.message(number_, text);
    } catch (const BadInput& error) {
      const Json told = {{"type", "error"}, {"text", error.what()}};
      put(std::make_shared<Payload>(
          Payload{Payload::Kind::text, told.dump(-1, ' ', false, Json::error_handler_t::replace)}));
    }
  }

  // Reads on at once, or when the second is over in which it said enough.
  void next() {
    const auto now = std::chrono::steady_clock::now();
    if (now - since_ >= std::chrono::seconds(1)) {
      since_ = now;
      said_ = 0;
    }
    if (++said_ < kMostRate) return read();
    pause_.expires_at(since_ + std::chrono::seconds(1));
    pause_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->read();
    });
  }

  Work& work_;
  std::uint64_t number_;
  websocket::stream<beast::tcp_stream> socket_;
  asio::steady_timer pause_;
  beast::flat_buffer buffer_;
  std::deque<SharedPayload> queue_;
  std::size_t waiting_ = 0;  // bytes in it
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  int said_ = 0;
  bool writing_ = false, left_ = false, ending_ = false;
};

// One request, until it is answered or a client.
class Server::Work::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Work& work, tcp::socket socket) : work_(work), stream_(std::move(socket)) {
    parser_.header_limit(8192);
    parser_.body_limit(0);
  }

  void start() {
    stream_.expires_after(kHeaderTime);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](error_code error, std::size_t) {
                       if (error) return self->refuse_broken(error);
                       self->answer();
                     });
  }

  void close() {
    error_code ignored;
    stream_.socket().close(ignored);
  }

 private:
  void refuse_broken(error_code error) {
    using E = http::error;
    if (error == E::end_of_stream || error == beast::error::timeout ||
        error.category() != http::make_error_code(E::bad_method).category())
      return close();
    write(respond(Request(), http::status::bad_request, "not a request\n"));
  }

  void answer() {
    const Request& request = parser_.get();
    if (std::optional<Response> refused = work_.refusal(request)) return write(std::move(*refused));
    const std::string_view whole = work_.path_of(request);
    const std::string_view path = whole.substr(0, whole.find('?'));
    const std::string_view query = whole.size() > path.size() ? whole.substr(path.size() + 1) : "";
    if (path == "/live") return upgrade();
    if (path == "/recorded") return recorded(file_of(query));
    if (path == "/") {
      std::string html = work_.served_.page();
      const std::string policy = served_policy(html, work_.port_);
      Response page =
          respond(request, http::status::ok, std::move(html), "text/html; charset=utf-8");
      page.set("Content-Security-Policy", policy);
      return write(std::move(page));
    }
    write(respond(request, http::status::not_found, "there is no such page\n"));
  }

  void upgrade() {
    const Request& request = parser_.get();
    if (!websocket::is_upgrade(request))
      return write(respond(request, http::status::upgrade_required, "a WebSocket is here\n"));
    if (work_.clients_.size() >= kMostClients)
      return write(respond(request, http::status::service_unavailable, "too many windows\n"));
    stream_.expires_never();
    std::make_shared<Client>(work_, ++work_.last_client_, std::move(stream_))->start(request);
  }

  void recorded(const std::string& file) {
    stream_.expires_never();
    asio::post(work_.slow_, [self = shared_from_this(), file] {
      Response response;
      const Request& request = self->parser_.get();
      try {
        std::optional<std::string> json = self->work_.served_.recorded(file);
        response = json ? respond(request, http::status::ok, std::move(*json), "application/json")
                        : respond(request, http::status::not_found, "nothing recorded\n");
      } catch (const std::exception& error) {
        response =
            respond(request, http::status::service_unavailable, std::string(error.what()) + "\n");
      }
      asio::post(self->work_.io_, [self, answer = std::make_shared<Response>(std::move(response))] {
        self->write(std::move(*answer));
      });
    });
  }

  void write(Response response) {
    const auto kept = std::make_shared<Response>(std::move(response));
    stream_.expires_after(std::chrono::seconds(60));
    http::async_write(stream_, *kept,
                      [self = shared_from_this(), kept](error_code error, std::size_t) {
                        if (error) return self->close();
                        error_code ignored;
                        self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                        self->stream_.expires_after(std::chrono::seconds(1));
                        self->drain();
                      });
  }

  // What still comes is taken away: closing before that would throw the answer away.
  void drain() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(4096),
                            [self = shared_from_this()](error_code error, std::size_t size) {
                              self->drained_ += size;
                              if (error || self->drained_ > kMostDrained) return self->close();
                              self->drain();
                            });
  }

  static constexpr std::size_t kMostDrained = 1 << 20;

  Work& work_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{16384};
  http::request_parser<http::empty_body> parser_;
  std::size_t drained_ = 0;
};

Server::Work::Work(std::uint16_t port, Served served) : served_(std::move(served)) {
  try {
    const tcp::endpoint here(asio::ip::address_v4::loopback(), port);
    acceptor_.open(here.protocol());
    acceptor_.set_option(asio::socket_base::reuse_address(true));
    acceptor_.bind(here);
    acceptor_.listen();
    port_ = acceptor_.local_endpoint().port();
  } catch (const boost::system::system_error& error) {
    throw BadInput(fmt::format("--port {}: {}", port, error.code().message()));
  }
  accept();
  thread_ = std::thread([this] {
    ::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread, on Linux
    io_.run();
  });
}

Server::Work::~Work() {
  slow_.join();
  asio::post(io_, [this] {
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
    for (const auto& weak : connections_)
      if (const auto connection = weak.lock()) connection->close();
    if (clients_.empty()) return io_.stop();
    for (const auto& client : std::vector(clients_)) client->say_goodbye();
    pause_.expires_after(kGoodbye);
    pause_.async_wait([this](error_code) {
      for (const auto& client : std::vector(clients_)) client->leave();
      io_.stop();
    });
  });
  thread_.join();
}

void Server::Work::make_room() {
  std::erase_if(connections_, [](const auto& weak) { return weak.expired(); });
  while (connections_.size() >= kMostConnections) {
    if (const auto oldest = connections_.front().lock()) oldest->close();
    connections_.pop_front();
  }
}

void Server::Work::accept() {
  acceptor_.async_accept([this](error_code error, tcp::socket socket) {
    if (!acceptor_.is_open()) return;
    if (error) {  // no more files: some will be closed
      pause_.expires_after(std::chrono::milliseconds(100));
      pause_.async_wait([this](error_code ended) {
        if (!ended) accept();
      });
      return;
    }
    make_room();
    const auto connection = std::make_shared<Connection>(*this, std::move(socket));
    connections_.push_back(connection);
    connection->start();
    accept();
  });
}

std::optional<Response> Server::Work::refusal(const Request& request) const {
  const auto refuse = [&](http::status status, const std::string& why) {
    return respond(request, status, why + "\n");
  };
  const auto ours = [&](std::string_view host) {
    for (const char* name : kNames)
      if (host == fmt::format("{}:{}", name, port_)) return true;
    return false;
  };
  if (request.count(http::field::host) != 1 || !ours(view(request[http::field::host])))
    return refuse(
        http::status::misdirected_request,
        fmt::format("this window is at 127.0.0.1:{0} alone: open the address that ferrule "
                    "printed; from another machine forward this very port, ssh -L "
                    "{0}:127.0.0.1:{0} MACHINE (--port chooses it)",
                    port_));
  const std::size_t origins = request.count(http::field::origin);
  std::string_view origin = view(request[http::field::origin]);
  constexpr std::string_view kScheme = "http://";
  const bool own = origins == 1 && origin.starts_with(kScheme) && ours(origin.substr(7));
  if ((origins > 0 || websocket::is_upgrade(request)) && !own)
    return refuse(http::status::forbidden,
                  "this window answers its own page alone, not one of another origin");
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return refuse(http::status::method_not_allowed, "GET and HEAD alone");
  if (!path_of(request).data()) return refuse(http::status::not_found, "there is no such page");
  return std::nullopt;
}

std::string_view Server::Work::path_of(const Request& request) const {
  std::string_view target = view(request.target());
  if (target.size() < 2 + token_.size() || target[0] != '/') return {};
  if (!same(target.substr(1, token_.size()), token_)) return {};
  target.remove_prefix(1 + token_.size());
  return target[0] == '/' ? target : std::string_view();
}

void Server::Work::send(SharedPayload payload) {
  asio::post(io_, [this, payload = std::move(payload)] { pass(payload); });
}

void Server::Work::pass(const SharedPayload& payload) {
  for (const auto& client : std::vector(clients_)) client->put(payload);
}

Server::Server(std::uint16_t port, Served served)
    : work_(std::make_unique<Work>(port, std::move(served))) {}
Server::~Server() = default;

std::uint16_t Server::port() const noexcept {
  return work_->port();
}
std::string Server::address() const {
  return fmt::format("http://127.0.0.1:{}/{}/", work_->port(), work_->token());
}
void Server::send(SharedPayload payload) {
  work_->send(std::move(payload));
}

}  // namespace ferrule
