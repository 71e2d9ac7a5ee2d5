#include "firmware_host/web/http_server.h"

#include <fmt/format.h>
#include <microhttpd.h>
#include <netdb.h>
#include <netinet/in.h>
#include <strings.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "hal/core/json_text.h"
#include "hal/core/parse_number.h"
#include "hal/core/thread_name.h"
#include "hal/core/thread_priority.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kBearer = "Bearer ";

// Sent with every answer: nothing is cached, no other site may embed it, and the page may load its own parts
// only.
constexpr std::pair<const char*, const char*> kHeaders[] = {
    {"Cache-Control", "no-store"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
     "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
};

struct Addresses {
  addrinfo* first = nullptr;
  ~Addresses() {
    if (first != nullptr) freeaddrinfo(first);
  }
};

Error cannot_listen(const HttpAddress& address, int error) {
  const std::string where = to_text(address);
  switch (error) {
    case EADDRINUSE:
      return {ErrorCode::Busy, fmt::format("another program listens on {}; choose another port", where),
              error};
    case EACCES:
      return {ErrorCode::Permission,
              fmt::format("no permission to listen on {}; ports below 1024 need privileges", where), error};
    case EADDRNOTAVAIL:  // it may be there later: a network that is not up yet
      return {
          ErrorCode::NotFound,
          fmt::format("this machine does not have the address of {}; 'ip address' lists those it has", where),
          error};
    default:
      return {ErrorCode::Io, fmt::format("cannot listen on {}: {}", where, std::strerror(error)), error};
  }
}

Result<void> look_up(const HttpAddress& address, Addresses& found) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE;
  const int error =
      getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &wanted, &found.first);
  if (error == 0) return {};
  return Error{ErrorCode::NotFound,
               fmt::format("there is no machine '{}' to listen on: {}", address.host, gai_strerror(error))};
}

std::uint16_t port_of(int bound_socket) {
  sockaddr_storage got{};
  socklen_t size = sizeof got;
  (void)getsockname(bound_socket, reinterpret_cast<sockaddr*>(&got), &size);
  return ntohs(got.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&got)->sin6_port
                                         : reinterpret_cast<sockaddr_in*>(&got)->sin_port);
}

// A bound, listening socket, and the port that it got in `address`.
Result<int> listen_on(HttpAddress& address) {
  Addresses found;
  TRY(look_up(address, found));
  const addrinfo& chosen = *found.first;
  const int listening = socket(chosen.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listening < 0) return cannot_listen(address, errno);
  const int yes = 1;
  (void)setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  constexpr int kBacklog = 32;
  if (bind(listening, chosen.ai_addr, chosen.ai_addrlen) != 0 || listen(listening, kBacklog) != 0) {
    const Error error = cannot_listen(address, errno);
    close(listening);
    return error;
  }
  address.port = port_of(listening);
  return listening;
}

// Takes the same time wherever two texts of one length differ.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different |= static_cast<unsigned>(a[i] ^ b[i]);
  return different == 0;
}

std::string_view header_of(MHD_Connection* connection, const char* name) {
  const char* const value = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
  return value == nullptr ? std::string_view() : value;
}

MHD_Result send(MHD_Connection* connection, const HttpAnswer& answer) {
  auto* const held = new HttpBody(answer.body ? answer.body : http_body(""));
  auto* const bytes = const_cast<std::byte*>((*held)->data());  // which the library only reads
  MHD_Response* const response = MHD_create_response_from_buffer_with_free_callback_cls(
      (*held)->size(), bytes, [](void* body) { delete static_cast<HttpBody*>(body); }, held);
  if (response == nullptr) return delete held, MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, answer.type);
  for (const auto& [name, value] : kHeaders) MHD_add_response_header(response, name, value);
  for (const auto& [name, value] : answer.headers) MHD_add_response_header(response, name, value.c_str());
  const MHD_Result queued = MHD_queue_response(connection, static_cast<unsigned>(answer.status), response);
  MHD_destroy_response(response);
  return queued;
}

// A request whose body is still arriving.
struct Arriving {
  HttpRequest request;
  const HttpRoute* route = nullptr;
};

}  // namespace

// What libmicrohttpd calls, on the server's thread. The library is C: nothing that is thrown passes through
// it.
struct HttpCallbacks {
  // The answer to a request that is refused by its header alone.
  static std::optional<HttpAnswer> refusal(const HttpServer& server, MHD_Connection* connection,
                                           const HttpRoute* route, std::string_view method) {
    if (!host_allowed(header_of(connection, MHD_HTTP_HEADER_HOST), server.address_))
      return http_error(403, "this server answers to its address and to localhost only");
    if (route == nullptr) return http_error(404, "there is no such page");
    const bool acts = route->access == HttpAccess::Token;
    const bool fits = acts ? method == "POST" : method == "GET" || method == "HEAD";
    if (!fits) {
      HttpAnswer answer = http_error(405, acts ? "this is for POST" : "this is for GET");
      answer.headers.emplace_back("Allow", acts ? "POST" : "GET, HEAD");
      return answer;
    }
    if (!header_of(connection, MHD_HTTP_HEADER_TRANSFER_ENCODING).empty())
      return http_error(411, "a body needs its Content-Length");
    if (const auto length = header_of(connection, MHD_HTTP_HEADER_CONTENT_LENGTH); !length.empty()) {
      const auto bytes = parse_number<std::size_t>(length);
      if (!bytes || *bytes > server.limits_.body_bytes)
        return http_error(413, fmt::format("a body has at most {} bytes", server.limits_.body_bytes));
    }
    return acts ? refused_without_token(server, connection) : std::nullopt;
  }

  static std::optional<HttpAnswer> refused_without_token(const HttpServer& server,
                                                         MHD_Connection* connection) {
    const std::string_view given = header_of(connection, MHD_HTTP_HEADER_AUTHORIZATION);
    if (given.size() < kBearer.size() || ::strncasecmp(given.data(), kBearer.data(), kBearer.size()) != 0) {
      HttpAnswer answer =
          http_error(401, "this needs the token of the run, which was given or printed at its start");
      answer.headers.emplace_back("WWW-Authenticate", "Bearer");
      return answer;
    }
    if (!same_secret(given.substr(kBearer.size()), server.token_))
      return http_error(403, "this is not the token of the run, which was given or printed at its start");
    return std::nullopt;
  }

  // Where it throws the connection is closed.
  static MHD_Result take(void* self, MHD_Connection* connection, const char* path, const char* method,
                         const char*, const char* upload, std::size_t* upload_size, void** context) {
    MHD_Result taken = MHD_NO;
    const auto& server = *static_cast<const HttpServer*>(self);
    (void)thrown_by(
        [&] { taken = take_part(server, connection, path, method, upload, upload_size, context); });
    return taken;
  }

  static MHD_Result take_part(const HttpServer& server, MHD_Connection* connection, const char* path,
                              const char* method, const char* upload, std::size_t* upload_size,
                              void** context) {
    auto* arriving = static_cast<Arriving*>(*context);
    if (arriving == nullptr) {
      const auto route = std::ranges::find(server.routes_, std::string_view(path), &HttpRoute::path);
      const HttpRoute* const found = route == server.routes_.end() ? nullptr : &*route;
      if (const auto refused = refusal(server, connection, found, method)) return send(connection, *refused);
      *context = arriving = new Arriving{{.path = path}, found};
      MHD_get_connection_values(connection, MHD_GET_ARGUMENT_KIND, add_argument, &arriving->request.query);
      return MHD_YES;
    }
    if (*upload_size > 0) {
      if (arriving->request.body.size() + *upload_size > server.limits_.body_bytes) return MHD_NO;
      arriving->request.body.append(upload, *upload_size);
      *upload_size = 0;
      return MHD_YES;
    }
    return send(connection, answer_to(*arriving));
  }

  // What a route throws does not end the run.
  static HttpAnswer answer_to(const Arriving& arrived) {
    try {
      return arrived.route->answer(arrived.request);
    } catch (const std::bad_alloc&) {
      return http_error(500, "no memory is left; end other programs and try again");
    } catch (const std::exception& failure) {
      return http_error(500, fmt::format("internal error: {}", failure.what()));
    }
  }

  static MHD_Result add_argument(void* query, MHD_ValueKind, const char* name, const char* value) {
    auto& arguments = *static_cast<decltype(HttpRequest::query)*>(query);
    const auto thrown = thrown_by([&] { arguments[name] = value == nullptr ? "" : value; });
    return thrown == nullptr ? MHD_YES : MHD_NO;
  }

  static void completed(void*, MHD_Connection* connection, void** context, MHD_RequestTerminationCode) {
    delete static_cast<Arriving*>(*context);
    *context = nullptr;
    const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    if (info != nullptr && info->socket_context != nullptr)
      static_cast<HttpServer::Client*>(info->socket_context)->since = Clock::now();
  }

  static void connected(void* self, MHD_Connection* connection, void** context,
                        MHD_ConnectionNotificationCode what) {
    auto& clients = static_cast<HttpServer*>(self)->clients_;
    if (what == MHD_CONNECTION_NOTIFY_STARTED) {
      const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
      (void)thrown_by([&] {
        clients.push_back(std::make_unique<HttpServer::Client>(
            HttpServer::Client{info == nullptr ? -1 : info->connect_fd, Clock::now()}));
        *context = clients.back().get();
      });
    } else {
      std::erase_if(clients, [&](const auto& client) { return client.get() == *context; });
    }
  }
};

HttpBody http_body(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
}

HttpAnswer http_error(int status, std::string_view sentence) {
  return {.status = status, .body = http_body(json_text(nlohmann::json{{"error", sentence}}))};
}

HttpServer::HttpServer(HttpAddress address, std::string token, std::vector<HttpRoute> routes,
                       const HttpLimits& limits)
    : address_(std::move(address)), token_(std::move(token)), routes_(std::move(routes)), limits_(limits) {}

Result<std::unique_ptr<HttpServer>> HttpServer::open(const HttpAddress& address, std::string token,
                                                     std::vector<HttpRoute> routes,
                                                     const HttpLimits& limits) {
  HDRCAM_CHECK(!token.empty());
  HttpAddress got = address;
  const int listening = TRY(listen_on(got));
  std::unique_ptr<HttpServer> server(
      new HttpServer(std::move(got), std::move(token), std::move(routes), limits));
  TRY(server->start(listening));
  return server;
}

Result<void> HttpServer::start(int listening) {
  const auto idle_s = static_cast<unsigned>(
      std::max<std::int64_t>(1, std::chrono::duration_cast<std::chrono::seconds>(limits_.patience).count()));
  // The server's own thread runs the library: it has a name, a priority and an end.
  daemon_ =
      MHD_start_daemon(MHD_USE_EPOLL, 0, nullptr, nullptr, &HttpCallbacks::take, this,
                       MHD_OPTION_LISTEN_SOCKET, listening, MHD_OPTION_CONNECTION_LIMIT, limits_.connections,
                       MHD_OPTION_CONNECTION_TIMEOUT, idle_s, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
                       limits_.header_bytes, MHD_OPTION_NOTIFY_COMPLETED, &HttpCallbacks::completed, nullptr,
                       MHD_OPTION_NOTIFY_CONNECTION, &HttpCallbacks::connected, this, MHD_OPTION_END);
  if (daemon_ == nullptr) {
    close(listening);
    return Error{ErrorCode::Io, fmt::format("libmicrohttpd does not start on {}", to_text(address_))};
  }
  thread_ = std::thread([this] {
    name_this_thread("http");
    set_priority_of_this_thread(ThreadPriority::Background);
    serve();
  });
  return {};
}

HttpServer::~HttpServer() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
  if (daemon_ != nullptr) MHD_stop_daemon(daemon_);
}

void HttpServer::serve() {
  constexpr int kTick_ms = 50;
  while (!ending_) {
    MHD_run_wait(daemon_, kTick_ms);
    cut_off_the_slow();
  }
}

// The library's own limit is for clients that are silent: one that sends or takes a byte now and then stays.
void HttpServer::cut_off_the_slow() {
  const auto now = Clock::now();
  for (const auto& client : clients_)
    if (client->socket >= 0 && now - client->since > limits_.patience) {
      shutdown(client->socket, SHUT_RDWR);
      client->socket = -1;
    }
}

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  HDRCAM_CHECK_EQ(getrandom(bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

}  // namespace hdrcam
