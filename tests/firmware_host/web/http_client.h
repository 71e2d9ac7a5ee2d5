// An HTTP client over a real socket, for the tests of the server: it can also send what no browser would, and
// read as slowly as it likes.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace hdrcam::test {

struct HttpReply {
  int status = 0;                              // 0: the server closed the connection without an answer
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
};

class HttpClient {
 public:
  explicit HttpClient(std::uint16_t port);  // on 127.0.0.1
  ~HttpClient();
  HttpClient(HttpClient&& other) noexcept;
  HttpClient& operator=(HttpClient&&) = delete;

  void send(std::string_view bytes);
  // The next answer; waits at most some seconds for each part of it.
  HttpReply receive();
  // GET with the Host that a browser sends.
  HttpReply get(const std::string& path);
  // Whether anything of an answer, or the end of the connection, comes within this time.
  bool hears_within(std::chrono::milliseconds time) const;

  // Up to one byte; false at the end of the connection. Waits.
  bool read_byte();
  // Everything up to the end of the connection, in bytes; throws where the server does not end it.
  std::size_t drained();
  // Whether the server has ended the connection; what it sent before is lost.
  bool closed();

 private:
  bool fill();

  int socket_ = -1;
  bool ended_ = false;  // by the server
  std::string received_;
};

std::string get_request(const std::string& path, const std::string& host = "127.0.0.1");

}  // namespace hdrcam::test
