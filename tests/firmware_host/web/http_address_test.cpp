#include "firmware_host/web/http_address.h"

#include "tests/contracts/expect.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("an address to listen on is an address and a port; a port alone is this machine's") {
  const auto as_text = [](std::string_view text) { return to_text(value_of(parse_http_address(text))); };
  CHECK(as_text("127.0.0.1:8080") == "127.0.0.1:8080");
  CHECK(as_text("8080") == "127.0.0.1:8080");
  CHECK(as_text(":8080") == "127.0.0.1:8080");
  CHECK(as_text("[::1]:0") == "[::1]:0");
  CHECK(as_text("camera.local:80") == "camera.local:80");
  for (const char* wrong :
       {"", "camera", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:80a", "::1:80", "[::1]",
        "[::1:80", "[camera]:80", "http://127.0.0.1:80", "a b:80", "127.0.0.1:-1"}) {
    INFO(wrong);
    require_error(parse_http_address(wrong), ErrorCode::Invalid);
  }
}

TEST_CASE("only this machine reaches a loopback address") {
  for (const char* here : {"127.0.0.1:1", "127.8.8.8:1", "[::1]:1", "localhost:1", "LOCALHOST:1"})
    CHECK(is_loopback(value_of(parse_http_address(here))));
  for (const char* there : {"0.0.0.0:1", "[::]:1", "192.168.1.2:1", "127.0.0.1.example.org:1", "camera:1"})
    CHECK_FALSE(is_loopback(value_of(parse_http_address(there))));
}

TEST_CASE("a request under a foreign name is told from one under an address of this machine") {
  const HttpAddress address{"camera.local", 8080};
  for (const char* own : {"127.0.0.1", "127.0.0.1:8080", "127.0.0.1:9000", "192.168.1.2:8080", "[::1]:8080",
                          "localhost:8080", "LocalHost", "camera.local:8080", "Camera.Local"}) {
    INFO(own);
    CHECK(host_allowed(own, address));
  }
  for (const char* foreign :
       {"", "example.org", "example.org:8080", "127.0.0.1.example.org", "localhost.example.org", "[::1",
        "[camera.local]:80", "127.0.0.1:80:80", "127.0.0.1:x", "1270.0.1", "evil@127.0.0.1"}) {
    INFO(foreign);
    CHECK_FALSE(host_allowed(foreign, address));
  }
}
