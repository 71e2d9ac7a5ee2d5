#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <span>
#include <string_view>
#include <vector>

int main(int argc, char** argv) {
  std::vector<const char*> arguments;
  for (const char* argument : std::span(argv, std::size_t(argc))) {
#if CATCH_VERSION_MAJOR >= 3  // has other words for it
    if (argument == std::string_view("--list-test-names-only")) {
      arguments.insert(arguments.end(), {"--list-tests", "--verbosity", "quiet"});
      continue;
    }
#endif
    arguments.push_back(argument);
  }
  return Catch::Session().run(int(arguments.size()), arguments.data());
}
