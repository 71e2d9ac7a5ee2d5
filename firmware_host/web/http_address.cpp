#include "firmware_host/web/http_address.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

constexpr std::string_view kLoopback = "127.0.0.1";

Error not_an_address(std::string_view text) {
  return {
      ErrorCode::Invalid,
      fmt::format("'{}' is not an address to listen on; write ADDRESS:PORT, such as 127.0.0.1:8080", text)};
}

bool is_ipv4(const std::string& host) {
  in_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1;
}

bool is_ipv6(const std::string& host) {
  in6_addr address{};
  return inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

bool same_name(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::ranges::equal(a, b, [&](char x, char y) { return lower(x) == lower(y); });
}

// The host and the port of "HOST:PORT", "[HOST]:PORT" or "HOST"; nullopt for brackets that do not close.
std::optional<std::pair<std::string_view, std::string_view>> split(std::string_view text) {
  if (!text.starts_with('[')) {
    const auto colon = text.rfind(':');
    if (colon == std::string_view::npos) return std::pair(text, std::string_view());
    return std::pair(text.substr(0, colon), text.substr(colon + 1));
  }
  const auto end = text.find(']');
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view rest = text.substr(end + 1);
  if (!rest.empty() && !rest.starts_with(':')) return std::nullopt;
  return std::pair(text.substr(1, end - 1), rest.empty() ? rest : rest.substr(1));
}

bool is_plain_name(std::string_view host) {
  return !host.empty() && std::ranges::all_of(host, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
  });
}

}  // namespace

Result<HttpAddress> parse_http_address(std::string_view text) {
  if (const auto port = parse_number<std::uint16_t>(text)) return HttpAddress{std::string(kLoopback), *port};
  const auto parts = split(text);
  if (!parts) return not_an_address(text);
  const auto port = parse_number<std::uint16_t>(parts->second);
  const bool bracketed = text.starts_with('[');
  HttpAddress address{std::string(parts->first.empty() && !bracketed ? kLoopback : parts->first),
                      port.value_or(0)};
  const bool sound = bracketed ? is_ipv6(address.host) : is_plain_name(address.host);
  if (!port || !sound) return not_an_address(text);
  return address;
}

std::string to_text(const HttpAddress& address) {
  return is_ipv6(address.host) ? fmt::format("[{}]:{}", address.host, address.port)
                               : fmt::format("{}:{}", address.host, address.port);
}

bool is_loopback(const HttpAddress& address) {
  return address.host == "::1" || same_name(address.host, "localhost") ||
         (is_ipv4(address.host) && address.host.starts_with("127."));
}

bool host_allowed(std::string_view host_header, const HttpAddress& address) {
  const auto parts = split(host_header);
  if (!parts || (!parts->second.empty() && !parse_number<std::uint16_t>(parts->second))) return false;
  const std::string host(parts->first);
  if (host_header.starts_with('[')) return is_ipv6(host);
  return is_ipv4(host) || same_name(host, "localhost") || same_name(host, address.host);
}

}  // namespace hdrcam
