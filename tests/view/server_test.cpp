#include "view/server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "sim/base/error.hpp"
#include "view/message.hpp"

namespace ferrule {
namespace {

class Socket {
 public:
  explicit Socket(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(fd_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
    timeval patience{10, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { ::close(fd_); }

  bool connected() const { return connected_; }
  bool say(const std::string& bytes) const {
    return ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes.size());
  }
  // All until the other end is closed, or what comes until `end`.
  std::string hear(const std::string& end = "") const {
    std::string all;
    char bytes[4096];
    ssize_t n;
    while ((end.empty() || all.find(end) == all.npos) &&
           (n = ::recv(fd_, bytes, sizeof bytes, 0)) > 0)
      all.append(bytes, static_cast<std::size_t>(n));
    return all;
  }

 private:
  int fd_;
  bool connected_;
};

std::string host_of(const Server& server) {
  return "127.0.0.1:" + std::to_string(server.port());
}

std::string token_of(const Server& server) {
  const std::string address = server.address();
  return address.substr(address.size() - 33, 32);
}

std::string upgrade_to(const Server& server, const std::string& origin) {
  return "GET /" + token_of(server) + "/live HTTP/1.1\r\nHost: " + host_of(server) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n" +
         origin + "\r\n";
}

class ServerTest : public ::testing::Test {
 protected:
  std::string host() const { return host_of(server); }
  std::string token() const { return token_of(server); }
  std::string ask(const std::string& request) const {
    const Socket socket(server.port());
    socket.say(request);
    return socket.hear();
  }
  std::string get(const std::string& target, const std::string& more = "") const {
    return ask("GET " + target + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more + "\r\n");
  }
  std::string upgrade(const std::string& origin) const { return upgrade_to(server, origin); }
  static int status(const std::string& answer) {
    return answer.size() < 12 ? 0 : std::stoi(answer.substr(9, 3));
  }

  std::atomic<int> messages = 0;
  Server server{0,
                {[] { return std::string("<title>the page</title>"); },
                 [](const std::string& file) -> std::optional<std::string> {
                   if (file.empty()) return std::nullopt;
                   if (file == "trouble") throw BadInput("no such episode");
                   return "{\"file\":\"" + file + "\"}";
                 },
                 [] {
                   return std::vector{std::make_shared<const Payload>(
                       Payload{Payload::Kind::text, "hello", false})};
                 },
                 [this](std::uint64_t, std::string_view text) {
                   parse_message(text);
                   ++messages;
                 }}};
};

TEST_F(ServerTest, ServesThePageUnderItsTokenAlone) {
  const std::string page = get("/" + token() + "/");
  EXPECT_EQ(status(page), 200);
  EXPECT_NE(page.find("the page"), page.npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), page.npos);
  std::string wrong = token();
  wrong[31] = wrong[31] == '0' ? '1' : '0';
  for (const std::string& target :
       {std::string("/"), "/" + wrong + "/", "/" + token(), "/" + token() + "x/",
        "/" + token().substr(1) + "/", std::string("/..."), std::string("//")})
    EXPECT_EQ(status(get(target)), 404) << target;
  for (const std::string& target : {std::string("*"), token() + "/", "http://x/" + token() + "/"}) {
    const int refused = status(get(target));
    EXPECT_TRUE(refused == 400 || refused == 404) << target << " " << refused;
  }
  EXPECT_EQ(status(get("/" + token() + "/?x=1")), 200);
}

TEST_F(ServerTest, TokensAreNotRepeated) {
  EXPECT_EQ(token().size(), 32u);
  EXPECT_EQ(token().find_first_not_of("0123456789abcdef"), std::string::npos);
  const Server other(0, {});
  EXPECT_NE(other.address().substr(other.address().size() - 33, 32), token());
}

TEST_F(ServerTest, NothingOutsideThePageIsServed) {
  for (const char* path :
       {"/../../../../etc/passwd", "/..%2f..%2fetc/passwd", "/index.html", "/./", "/%2e%2e/",
        "/recorded/../../x", "//etc/passwd", "/live/..", "/page.html"}) {
    const std::string answer = get("/" + token() + path);
    EXPECT_EQ(status(answer), 404) << path;
    EXPECT_EQ(answer.find("root:"), answer.npos);
  }
  EXPECT_EQ(status(get("/" + token() + "/live")), 426);
}

TEST_F(ServerTest, AnotherHostOrOriginIsRefused) {
  const std::string head = "GET /" + token() + "/ HTTP/1.1\r\n";
  for (const std::string& other :
       {std::string("Host: evil.example\r\n"), "Host: evil.example:" + host().substr(10) + "\r\n",
        std::string("Host: 127.0.0.1\r\n"), std::string("Host: 127.0.0.1:1\r\n"),
        "Host: " + host() + ".evil.example\r\n", "Host: " + host() + "\r\nHost: evil.example\r\n",
        std::string()}) {
    const int refused = status(ask(head + other + "\r\n"));
    EXPECT_TRUE(refused == 421 || refused == 400) << other << refused;
  }
  for (const std::string name : {"localhost", "[::1]"})
    EXPECT_EQ(status(ask(head + "Host: " + name + host().substr(9) + "\r\nOrigin: http://" + name +
                         host().substr(9) + "\r\n\r\n")),
              200);
  const std::string own = "http://" + host();
  EXPECT_EQ(status(get("/" + token() + "/", "Origin: " + own + "\r\n")), 200);
  for (const std::string& origin : {std::string("null"), std::string("http://evil.example"),
                                    "https://" + host(), own + ".evil.example", std::string()})
    EXPECT_EQ(status(get("/" + token() + "/", "Origin: " + origin + "\r\n")), 403) << origin;
}

// One line says what to do, and nothing of the token.
TEST_F(ServerTest, AnotherPortOrNameIsToldWhereTheWindowIs) {
  const std::string port = host().substr(10);
  for (const std::string other : {"localhost:9000", "127.0.0.1:9000", "[::1]:9000", "bench:1"}) {
    const std::string answer = ask("GET /" + token() + "/ HTTP/1.1\r\nHost: " + other + "\r\n\r\n");
    const std::string body = answer.substr(answer.find("\r\n\r\n") + 4);
    EXPECT_EQ(status(answer), 421) << other;
    EXPECT_NE(body.find("ssh -L " + port + ":127.0.0.1:" + port), body.npos) << body;
    EXPECT_EQ(body.find('\n'), body.size() - 1) << body;
    EXPECT_EQ(answer.find(token()), answer.npos);
  }
}

// Only what the page says of itself, with this server's port, and in no frame.
TEST(Server, ThePolicyIsThatOfThePage) {
  const std::string meta =
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src "
      "'sha256-AbC+/0='; style-src 'sha256-d='; connect-src 'self' ws://localhost:*\">";
  for (const bool has : {true, false}) {
    const Server server(
        0, {[&] { return (has ? meta : "") + "<script>script-src 'unsafe-inline';"; }, {}, {}, {}});
    const Socket socket(server.port());
    socket.say("GET /" + token_of(server) + "/ HTTP/1.1\r\nHost: " + host_of(server) + "\r\n\r\n");
    const std::string answer = socket.hear();
    const std::string head = answer.substr(0, answer.find("\r\n\r\n") + 2);
    const std::string own =
        "script-src 'sha256-AbC+/0='; style-src 'sha256-d='; connect-src 'self' ws://localhost:" +
        std::to_string(server.port()) + "; ";
    EXPECT_NE(head.find("Content-Security-Policy: default-src 'none'; " + (has ? own : "") +
                        "frame-ancestors 'none'\r\n"),
              head.npos)
        << head;
  }
}

TEST_F(ServerTest, AWebSocketNeedsItsOwnOrigin) {
  EXPECT_EQ(status(ask(upgrade(""))), 403);
  EXPECT_EQ(status(ask(upgrade("Origin: http://evil.example\r\n"))), 403);
  const Socket socket(server.port());
  socket.say(upgrade("Origin: http://" + host() + "\r\n"));
  EXPECT_EQ(status(socket.hear("hello")), 101);
}

TEST_F(ServerTest, OtherMethodsAreRefused) {
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "CONNECT", "TRACE", "PATCH"})
    EXPECT_EQ(status(ask(std::string(method) + " /" + token() + "/ HTTP/1.1\r\nHost: " + host() +
                         "\r\n\r\n")),
              405)
        << method;
  const std::string head = ask("HEAD /" + token() + "/ HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  EXPECT_EQ(status(head), 200);
  EXPECT_TRUE(head.ends_with("\r\n\r\n"));
  const std::string body = ask("GET /" + token() + "/ HTTP/1.1\r\nHost: " + host() +
                               "\r\nContent-Length: 5\r\n\r\n12345");
  EXPECT_NE(status(body), 200);
}

TEST_F(ServerTest, WhatIsNoRequestIsRefusedAndTheServerGoesOn) {
  for (const std::string& bytes :
       {std::string("\r\n\r\n\r\n"), std::string("\0\1\2\3\r\n\r\n", 8), std::string("GET\r\n\r\n"),
        "GET / HTTP/9.9\r\nHost: " + host() + "\r\n\r\n", std::string(100000, 'a'),
        "GET / HTTP/1.1\r\nHost: " + host() + "\r\nX: " + std::string(9000, 'x') + "\r\n\r\n",
        "GET /" + std::string(20000, 'x') + " HTTP/1.1\r\n\r\n"}) {
    const Socket socket(server.port());
    socket.say(bytes);
    ::usleep(1000);
    EXPECT_NE(status(socket.hear("\r\n\r\n")), 200);
  }
  EXPECT_EQ(status(get("/" + token() + "/")), 200);
}

TEST_F(ServerTest, RecordedAnswersWhatItsFunctionSays) {
  const std::string path = "/" + token() + "/recorded";
  EXPECT_EQ(status(get(path)), 404);
  EXPECT_NE(get(path + "?file=episode_0001.h5").find("{\"file\":\"episode_0001.h5\"}"),
            std::string::npos);
  EXPECT_NE(get(path + "?file=a%20b%2E").find("{\"file\":\"a b.\"}"), std::string::npos);
  EXPECT_EQ(status(get(path + "?file=%zz")), 404);
  EXPECT_EQ(status(get(path + "?other=x")), 404);
  EXPECT_EQ(status(get(path + "?file=trouble")), 503);
}

TEST_F(ServerTest, ManyThatSayNothingDoNotKeepAPageOut) {
  std::vector<std::unique_ptr<Socket>> silent;
  for (std::size_t i = 0; i < 3 * Server::kMostConnections; ++i)
    silent.push_back(std::make_unique<Socket>(server.port()));
  EXPECT_EQ(status(get("/" + token() + "/")), 200);
}

TEST_F(ServerTest, ThereAreOnlySoManyClients) {
  std::vector<std::unique_ptr<Socket>> clients;
  int accepted = 0;
  for (std::size_t i = 0; i < 2 * Server::kMostClients; ++i) {
    const auto& socket = clients.emplace_back(std::make_unique<Socket>(server.port()));
    socket->say(upgrade("Origin: http://" + host() + "\r\n"));
    accepted += status(socket->hear("\r\n\r\n")) == 101;
  }
  EXPECT_EQ(accepted, static_cast<int>(Server::kMostClients));
  clients.clear();
  ::usleep(100000);
  EXPECT_EQ(status(get("/" + token() + "/")), 200);
}

// A frame of `text` by a client, masked with zeros.
std::string frame(const std::string& text, unsigned char first = 0x81) {
  std::string bytes{static_cast<char>(first)};
  if (text.size() < 126) {
    bytes += static_cast<char>(0x80 | text.size());
  } else {
    bytes += static_cast<char>(0x80 | 126);
    bytes += static_cast<char>(text.size() >> 8);
    bytes += static_cast<char>(text.size() & 0xff);
  }
  return bytes + std::string(4, '\0') + text;
}

TEST_F(ServerTest, ClientsThatBreakTheRulesAreCutOff) {
  std::string unmasked = frame(R"({"type":"stop"})");
  unmasked[1] = static_cast<char>(unmasked[1] & 0x7f);
  for (const std::string& bytes :
       {frame(std::string(5000, ' ')), frame("\x01\x02", 0x82), frame("x", 0x83), unmasked,
        frame("\xff\xfe"), std::string(1000, '\xff')}) {
    const Socket socket(server.port());
    socket.say(upgrade("Origin: http://" + host() + "\r\n"));
    ASSERT_EQ(status(socket.hear("hello")), 101);
    socket.say(bytes);
    socket.hear();  // until it is closed
  }
  EXPECT_EQ(messages, 0);
  const Socket good(server.port());
  good.say(upgrade("Origin: http://" + host() + "\r\n"));
  good.hear("hello");
  good.say(frame("nonsense"));
  EXPECT_NE(good.hear("message:").find("\"error\""), std::string::npos);
  good.say(frame(R"({"type":"stop"})"));
  for (int i = 0; i < 1000 && messages == 0; ++i) ::usleep(1000);
  EXPECT_EQ(messages, 1);
}

// Of a flood no more is read in a second than a page may say.
using ServerTestInSeconds = ServerTest;
TEST_F(ServerTestInSeconds, AFloodIsReadSlowly) {
  const Socket socket(server.port());
  socket.say(upgrade("Origin: http://" + host() + "\r\n"));
  socket.hear("hello");
  const std::string one = frame(R"({"type":"stop"})");
  std::string many;
  for (int i = 0; i < 5 * Server::kMostRate; ++i) many += one;
  const auto begin = std::chrono::steady_clock::now();
  socket.say(many);
  while (messages < 3 * Server::kMostRate) ::usleep(1000);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_GT(took.count(), 1);
  EXPECT_EQ(status(get("/" + token() + "/")), 200);
}

// One that does not read is cut off, and the others get all.
TEST_F(ServerTest, OneThatDoesNotReadHoldsNobodyUp) {
  const Socket stuck(server.port()), reader(server.port());
  for (const Socket* socket : {&stuck, &reader}) {
    socket->say(upgrade("Origin: http://" + host() + "\r\n"));
    ASSERT_EQ(status(socket->hear("hello")), 101);
  }
  std::thread reads([&] { reader.hear("the last"); });
  constexpr std::size_t kOne = 1 << 20;
  for (std::size_t sent = 0; sent < 3 * Server::kMostWaiting; sent += kOne) {
    server.send(std::make_shared<const Payload>(
        Payload{Payload::Kind::text, std::string(kOne, 'x'), false}));
    ::usleep(3000);
  }
  server.send(std::make_shared<const Payload>(Payload{Payload::Kind::text, "the last", false}));
  reads.join();
  EXPECT_EQ(status(get("/" + token() + "/")), 200);
}

TEST(Server, AClientHearsAllAndThenThatTheProgramEnds) {
  const auto text = [](std::string words) {
    return std::make_shared<const Payload>(Payload{Payload::Kind::text, std::move(words), false});
  };
  auto server = std::make_unique<Server>(
      0, Server::Served{{}, {}, [&] { return std::vector<SharedPayload>{text("hello")}; }, {}});
  const Socket socket(server->port());
  socket.say(upgrade_to(*server, "Origin: http://" + host_of(*server) + "\r\n"));
  socket.hear("hello");
  constexpr std::size_t kMuch = 4 << 20;
  server->send(text(std::string(kMuch, 'x')));
  server->send(text("the last"));
  std::string heard;
  std::thread reads([&] { heard = socket.hear(); });
  server.reset();
  reads.join();
  // A close of two bytes: 1001, going away.
  const std::size_t last = heard.find("the last");
  ASSERT_NE(last, heard.npos);
  EXPECT_GT(last, kMuch);
  EXPECT_EQ(heard.substr(last + 8), "\x88\x02\x03\xe9");
}

TEST(Server, APortThatIsTakenIsRefused) {
  const Server first(0, {});
  EXPECT_THROW(Server(first.port(), {}), BadInput);
}

}  // namespace
}  // namespace ferrule
