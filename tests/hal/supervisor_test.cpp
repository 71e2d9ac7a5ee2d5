#include "hal/supervisor.h"

#include <unistd.h>

#include <cstdlib>

#include "tests/support/notify_socket.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// The environment of a service, for the time of one test.
class Environment {
 public:
  explicit Environment(std::initializer_list<std::pair<const char*, std::string>> variables) {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
    for (const auto& [name, value] : variables) setenv(name, value.c_str(), 1);
  }
  ~Environment() {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  }
};

}  // namespace

TEST_CASE("a supervisor is told over its socket, by path or in the abstract namespace") {
  for (const bool abstract : {false, true}) {
    NotifySocket socket(abstract ? NotifySocket::Where::Abstract : NotifySocket::Where::Path);
    const Environment environment{{"NOTIFY_SOCKET", socket.name()}};
    const Supervisor supervisor = Supervisor::of_environment();
    CHECK(supervisor.present());
    CHECK(supervisor.patience() == Duration::zero());
    CHECK(supervisor.tell("READY=1\nSTATUS=here\n"));
    CHECK(socket.next() == "READY=1\nSTATUS=here\n");
  }
}

TEST_CASE("without a service manager nothing is said, and nothing goes wrong") {
  const Environment environment{};
  const Supervisor supervisor = Supervisor::of_environment();
  CHECK_FALSE(supervisor.present());
  CHECK_FALSE(supervisor.tell("READY=1"));
  CHECK_FALSE(Supervisor("/nowhere/notify", {}).tell("READY=1"));
  CHECK_FALSE(Supervisor(std::string(4096, 'x'), {}).tell("READY=1"));
}

TEST_CASE("the patience of a watchdog counts for the process that it names") {
  using std::chrono::seconds;
  {
    const Environment environment{{"NOTIFY_SOCKET", "@x"}, {"WATCHDOG_USEC", "3000000"}};
    CHECK(Supervisor::of_environment().patience() == seconds(3));
  }
  {
    const Environment environment{
        {"NOTIFY_SOCKET", "@x"}, {"WATCHDOG_USEC", "3000000"}, {"WATCHDOG_PID", std::to_string(getpid())}};
    CHECK(Supervisor::of_environment().patience() == seconds(3));
  }
  {
    const Environment environment{{"NOTIFY_SOCKET", "@x"},
                                  {"WATCHDOG_USEC", "3000000"},
                                  {"WATCHDOG_PID", std::to_string(getpid() + 1)}};
    CHECK(Supervisor::of_environment().patience() == seconds(0));
  }
  for (const char* wrong : {"", "soon", "-5", "3s"}) {
    const Environment environment{{"NOTIFY_SOCKET", "@x"}, {"WATCHDOG_USEC", wrong}};
    CHECK(Supervisor::of_environment().patience() == seconds(0));
  }
}

TEST_CASE("a supervisor that does not read does not hold the program up") {
  NotifySocket socket(NotifySocket::Where::Path);
  const Supervisor supervisor(socket.name(), {});
  for (int i = 0; i < 5000; ++i) supervisor.tell("WATCHDOG=1");  // far more than a socket holds
  CHECK(socket.next() == "WATCHDOG=1");
}
