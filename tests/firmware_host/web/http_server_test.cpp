// The server of the live view over real sockets, on ports that the machine chooses.
#include "firmware_host/web/http_server.h"

#include <chrono>
#include <new>
#include <set>
#include <stdexcept>
#include <thread>

#include "tests/contracts/expect.h"
#include "tests/firmware_host/web/http_client.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::get_request;
using test::HttpClient;
using test::HttpReply;

namespace {

const std::string kToken = "0123456789abcdef";
constexpr std::size_t kLarge = 16 << 20;  // more than two sockets hold

std::unique_ptr<HttpServer> open_server(const HttpLimits& limits = {}) {
  std::vector<HttpRoute> routes;
  routes.push_back({"/hello", HttpAccess::Open, [](const HttpRequest& request) {
                      const auto name = request.query.find("name");
                      return HttpAnswer{
                          .type = "text/plain",
                          .body = http_body(name == request.query.end() ? "hello" : name->second)};
                    }});
  routes.push_back({"/large", HttpAccess::Open, [](const HttpRequest&) {
                      return HttpAnswer{.body = http_body(std::string(kLarge, 'x'))};
                    }});
  routes.push_back({"/act", HttpAccess::Token, [](const HttpRequest& request) {
                      return HttpAnswer{.body = http_body("did " + request.body)};
                    }});
  routes.push_back({"/fails", HttpAccess::Open,
                    [](const HttpRequest&) -> HttpAnswer { throw std::runtime_error("no such thing"); }});
  routes.push_back(
      {"/fills", HttpAccess::Open, [](const HttpRequest&) -> HttpAnswer { throw std::bad_alloc(); }});
  return value_of(HttpServer::open({"127.0.0.1", 0}, kToken, std::move(routes), limits));
}

HttpClient client_of(const HttpServer& server) { return HttpClient(server.address().port); }

std::string post_request(const std::string& body, const std::string& more_headers) {
  return "POST /act HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" +
         more_headers + "\r\n" + body;
}

HttpReply reply_to(const HttpServer& server, const std::string& request) {
  HttpClient client = client_of(server);
  client.send(request);
  return client.receive();
}

}  // namespace

TEST_CASE("the server answers request after request of a connection, with the arguments decoded") {
  const auto server = open_server();
  CHECK(server->address().port != 0);
  HttpClient client = client_of(*server);
  CHECK(client.get("/hello").body == "hello");
  const HttpReply reply = client.get("/hello?name=a%20b%26c&other=1");
  CHECK(reply.status == 200);
  CHECK(reply.body == "a b&c");
  CHECK(reply.headers.at("content-type") == "text/plain");
  CHECK(reply.headers.at("cache-control") == "no-store");
  CHECK(reply.headers.at("x-content-type-options") == "nosniff");
  CHECK(reply.headers.at("cross-origin-resource-policy") == "same-origin");
  CHECK(reply.headers.at("content-security-policy").find("default-src 'none'") != std::string::npos);
  CHECK(client.get("/nowhere").status == 404);
}

TEST_CASE("a request under a foreign name, or under none, is refused whatever it asks for") {
  const auto server = open_server();
  const auto status = [&](const std::string& request) { return reply_to(*server, request).status; };
  CHECK(status(get_request("/hello", "127.0.0.1:8080")) == 200);
  CHECK(status(get_request("/hello", "localhost")) == 200);
  CHECK(status(get_request("/hello", "example.org")) == 403);
  CHECK(status(get_request("/nowhere", "example.org")) == 403);
  CHECK(status("GET /hello HTTP/1.0\r\n\r\n") == 403);
  CHECK(status("POST /act HTTP/1.1\r\nHost: example.org\r\nContent-Length: 0\r\nAuthorization: Bearer " +
               kToken + "\r\n\r\n") == 403);
}

TEST_CASE("nothing acts without the token, and an action is no GET") {
  const auto server = open_server();
  const HttpReply none = reply_to(*server, post_request("x", ""));
  CHECK(none.status == 401);
  CHECK(none.headers.contains("www-authenticate"));
  for (const std::string wrong :
       {"Bearer ", "Bearer 0123456789abcdee", "Bearer 0123456789abcde", "Bearer 0123456789abcdef0"}) {
    INFO(wrong);
    const int status = reply_to(*server, post_request("x", "Authorization: " + wrong + "\r\n")).status;
    CHECK((status == 401 || status == 403));
  }
  CHECK(reply_to(*server, post_request("x", "Authorization: Basic " + kToken + "\r\n")).status == 401);
  const HttpReply right = reply_to(*server, post_request("this", "Authorization: Bearer " + kToken + "\r\n"));
  CHECK(right.status == 200);
  CHECK(right.body == "did this");
  CHECK(reply_to(*server, post_request("x", "Authorization: bearer " + kToken + "\r\n")).status ==
        200);  // RFC 9110
  CHECK(reply_to(*server, get_request("/act")).status == 405);
  CHECK(reply_to(*server, "POST /hello HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n").status ==
        405);
  CHECK(reply_to(*server, "DELETE /hello HTTP/1.1\r\nHost: localhost\r\n\r\n").status == 405);
}

TEST_CASE("a body that is too long, or of unknown length, is refused before it is read") {
  const auto server = open_server({.body_bytes = 100});
  const std::string token = "Authorization: Bearer " + kToken + "\r\n";
  CHECK(reply_to(*server, post_request(std::string(100, 'x'), token)).status == 200);
  CHECK(reply_to(*server, post_request(std::string(101, 'x'), token)).status == 413);
  CHECK(
      reply_to(*server, "POST /act HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n" +
                            token + "\r\n")
          .status >= 400);
  CHECK(reply_to(*server, "POST /act HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n" + token +
                              "\r\n5\r\nabcde\r\n0\r\n\r\n")
            .status == 411);
}

TEST_CASE("a header that never ends is refused at its limit") {
  const auto server = open_server({.header_bytes = 4096, .patience = std::chrono::minutes(10)});
  HttpClient client = client_of(*server);
  client.send("GET /hello HTTP/1.1\r\nHost: localhost\r\n");
  for (int i = 0; i < 1000; ++i) client.send("X-Filler: " + std::string(100, 'x') + "\r\n");
  CHECK(client.hears_within(std::chrono::seconds(30)));
  const HttpReply reply = client.receive();
  CHECK((reply.status == 0 || reply.status >= 400));
  CHECK(client_of(*server).get("/hello").status == 200);
}

TEST_CASE("a client that sends or reads a byte now and then is cut off, and nobody else waits for it") {
  const auto server = open_server({.patience = std::chrono::milliseconds(700)});
  HttpClient reader = client_of(*server), sender = client_of(*server);
  reader.send(get_request("/large"));
  sender.send("GET /hello HTTP/1.1\r\nHost: loc");
  int rounds = 0;
  for (; rounds < 300 && !sender.closed(); ++rounds) {
    sender.send("a");
    (void)reader.read_byte();
    CHECK(client_of(*server).get("/hello").status == 200);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  CHECK(rounds < 300);
  CHECK(reader.drained() < kLarge);  // it came first, so its time was up first
}

TEST_CASE("a client above the limit of connections waits until one leaves") {
  const auto server = open_server({.connections = 2});
  auto first = std::make_unique<HttpClient>(server->address().port);
  HttpClient second = client_of(*server);
  CHECK(first->get("/hello").status == 200);
  CHECK(second.get("/hello").status == 200);
  HttpClient third = client_of(*server);
  third.send(get_request("/hello"));
  CHECK_FALSE(third.hears_within(std::chrono::milliseconds(200)));
  first.reset();
  CHECK(third.receive().status == 200);
}

TEST_CASE("a route that throws costs its client the answer, and nobody else anything") {
  const auto server = open_server();
  HttpClient client = client_of(*server);
  const HttpReply reply = client.get("/fails");
  CHECK(reply.status == 500);
  CHECK(reply.body == R"({"error":"internal error: no such thing"})");
  const HttpReply without_memory = client.get("/fills");
  CHECK(without_memory.status == 500);
  CHECK(without_memory.body == R"({"error":"no memory is left; end other programs and try again"})");
  CHECK(client.get("/hello").body == "hello");
  CHECK(client_of(*server).get("/hello").body == "hello");
}

TEST_CASE("a port that is taken and an address of another machine are errors that say so") {
  const auto server = open_server();
  const auto taken = HttpServer::open(server->address(), kToken, {}, {});
  require_error(taken, ErrorCode::Busy);
  CHECK(taken.error().message.find(to_text(server->address())) != std::string::npos);
  for (const char* away : {"192.0.2.1", "no-such-machine.invalid"})  // as before a network is up
    require_error(HttpServer::open({away, 0}, kToken, {}, {}), ErrorCode::NotFound);
}

TEST_CASE("the server ends at once, whatever its clients are doing") {
  auto server = open_server();
  HttpClient reader = client_of(*server), idle = client_of(*server);
  reader.send(get_request("/large"));
  CHECK(reader.read_byte());
  server.reset();
  CHECK(reader.drained() < kLarge);
  CHECK(idle.drained() == 0);
}

TEST_CASE("no two tokens are alike") {
  std::set<std::string> tokens;
  for (int i = 0; i < 20; ++i) tokens.insert(random_token());
  CHECK(tokens.size() == 20);
  CHECK(tokens.begin()->size() == 32);
}
