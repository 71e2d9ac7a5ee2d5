#include "tests/firmware_host/web/http_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace hdrcam::test {
namespace {

constexpr int kPatience_ms = 30'000;  // a busy machine is not a broken server

bool readable(int socket, int wait_ms) {
  pollfd waiting{socket, POLLIN, 0};
  return poll(&waiting, 1, wait_ms) == 1;
}

}  // namespace

HttpClient::HttpClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("the server is not there");
}

HttpClient::~HttpClient() {
  if (socket_ >= 0) close(socket_);
}

HttpClient::HttpClient(HttpClient&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), received_(std::move(other.received_)) {}

void HttpClient::send(std::string_view bytes) {
  (void)::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

bool HttpClient::fill() {
  if (!readable(socket_, kPatience_ms)) return false;
  char part[65536];
  const ssize_t got = recv(socket_, part, sizeof part, 0);
  ended_ = got <= 0;
  if (got > 0) received_.append(part, static_cast<std::size_t>(got));
  return got > 0;
}

HttpReply HttpClient::receive() {
  constexpr std::string_view kEnd = "\r\n\r\n";
  while (received_.find(kEnd) == std::string::npos)
    if (!fill()) return {};
  HttpReply reply;
  const std::size_t end = received_.find(kEnd);
  std::istringstream header(received_.substr(0, end));
  received_.erase(0, end + kEnd.size());
  std::string line, version;
  std::getline(header, line);
  std::istringstream(line) >> version >> reply.status;
  while (std::getline(header, line)) {
    const std::size_t colon = line.find(':');
    std::string name = line.substr(0, colon);
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    std::string value = line.substr(colon + 2);
    if (value.ends_with('\r')) value.pop_back();
    reply.headers[name] = value;
  }
  const auto length = reply.headers.find("content-length");
  const std::size_t bytes = length == reply.headers.end() ? 0 : std::stoul(length->second);
  while (received_.size() < bytes)
    if (!fill()) return {};
  reply.body = received_.substr(0, bytes);
  received_.erase(0, bytes);
  return reply;
}

HttpReply HttpClient::get(const std::string& path) {
  send(get_request(path));
  return receive();
}

bool HttpClient::hears_within(std::chrono::milliseconds time) const {
  return readable(socket_, static_cast<int>(time.count()));
}

bool HttpClient::read_byte() {
  char byte = 0;
  return readable(socket_, kPatience_ms) && recv(socket_, &byte, 1, 0) == 1;
}

std::size_t HttpClient::drained() {
  while (fill()) {
  }
  if (!ended_) throw std::runtime_error("the server keeps the connection and stays silent");
  return received_.size();
}

bool HttpClient::closed() {
  char part[4096];
  while (readable(socket_, 0))
    if (recv(socket_, part, sizeof part, 0) <= 0) return true;
  return false;
}

std::string get_request(const std::string& path, const std::string& host) {
  return "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n";
}

}  // namespace hdrcam::test
