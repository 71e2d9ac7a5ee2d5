// Where an HTTP server listens, as a user writes it, and which names of a request may mean it. A browser that
// was lured to a foreign page can be made to ask this machine under the foreign page's name (DNS rebinding);
// such a request is known by its Host. Value type, reentrant.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/core/result.h"

namespace hdrcam {

struct HttpAddress {
  std::string host;        // an IPv4 or IPv6 address without brackets, or a name
  std::uint16_t port = 0;  // 0: any free one
};

// "127.0.0.1:8080", "[::1]:8080", "localhost:8080"; "8080" or ":8080" is 127.0.0.1. Errors: Invalid.
Result<HttpAddress> parse_http_address(std::string_view text);

std::string to_text(const HttpAddress& address);  // with brackets where they belong

// Whether only this machine reaches it.
bool is_loopback(const HttpAddress& address);

// Whether a request with this Host header may be answered: an IP address (a rebound name never is one),
// localhost, or the name that the server was given. Any port: a tunnel may have its own.
bool host_allowed(std::string_view host_header, const HttpAddress& address);

}  // namespace hdrcam
