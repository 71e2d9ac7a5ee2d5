// A small HTTP/1.1 server (libmicrohttpd) that a camera can afford: one thread of low priority answers
// everybody, and nothing that a client does can make it hold more. A client has one answer at a time, whole
// and in memory; one that reads slowly waits for itself alone, and one that takes longer than `patience` for
// a request and its answer is cut off. A request is answered only where its Host may mean this machine
// (http_address.h), and a route that acts only with the token. Thread-bound; the server's own thread calls
// the routes, one at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "firmware_host/web/http_address.h"
#include "hal/core/result.h"

struct MHD_Daemon;

namespace hdrcam {

struct HttpRequest {
  std::string path;
  std::map<std::string, std::string, std::less<>> query = {};
  std::string body = {};
};

// Bytes may be shared between answers: twenty clients hold one picture.
using HttpBody = std::shared_ptr<const std::vector<std::byte>>;
HttpBody http_body(std::string_view text);

struct HttpAnswer {
  int status = 200;
  const char* type = "application/json";
  HttpBody body = {};  // may be null
  std::vector<std::pair<const char*, std::string>> headers = {};
};
// {"error": sentence}
HttpAnswer http_error(int status, std::string_view sentence);

enum class HttpAccess {
  Open,   // GET and HEAD
  Token,  // POST with "Authorization: Bearer TOKEN"
};

struct HttpRoute {
  std::string path;
  HttpAccess access = HttpAccess::Open;
  std::function<HttpAnswer(const HttpRequest&)> answer;  // 500 where it throws
};

struct HttpLimits {
  unsigned connections = 64;  // further clients wait until one leaves
  std::size_t header_bytes = 16384;
  std::size_t body_bytes = 4096;
  std::chrono::milliseconds patience{20'000};  // from the end of one answer to the end of the next
};

class HttpServer {
 public:
  // Listens, and answers until it is destroyed. token: not empty. Errors: Busy where another program has the
  // port, Permission, NotFound where this machine does not have the address now, Io.
  static Result<std::unique_ptr<HttpServer>> open(const HttpAddress& address, std::string token,
                                                  std::vector<HttpRoute> routes, const HttpLimits& limits);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // With the port that it has got.
  const HttpAddress& address() const { return address_; }

 private:
  friend struct HttpCallbacks;
  struct Client {  // a connection
    int socket = -1;
    std::chrono::steady_clock::time_point since;  // the end of its last answer
  };

  HttpServer(HttpAddress address, std::string token, std::vector<HttpRoute> routes, const HttpLimits& limits);
  Result<void> start(int listening);
  void serve();
  void cut_off_the_slow();

  const HttpAddress address_;
  const std::string token_;
  const std::vector<HttpRoute> routes_;
  const HttpLimits limits_;
  MHD_Daemon* daemon_ = nullptr;
  std::vector<std::unique_ptr<Client>> clients_;  // of the server's thread
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

// 128 random bits in hexadecimal digits.
std::string random_token();

}  // namespace hdrcam
