// What the program says of devices that are missing, forbidden or of another kind, end to end, on a machine
// that may have none. Devices that answer are for the kernel test bed (tests/hil/).
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "firmware_host/exit_code.h"
#include "hal/real/enumerate.h"
#include "tests/places.h"
#include "tests/support/not_tested.h"
#include "tests/support/ran_here.h"

#include "tests/support/as_nobody.h"

using namespace hdrcam;
using Catch::Contains;
using Catch::Matches;

namespace {

// The sentence with which the program ends; its exit code must be that of `expected`.
std::string sentence(const std::vector<std::string>& words, ErrorCode expected) {
  const test::RanHere ended = test::ran_here(words);
  INFO(ended.err);
  CHECK(ended.exit_code == exit_code_of(expected));
  CHECK(ended.out.empty());
  CHECK_THAT(ended.err, Matches("hdrcam: [^\n]*\\.\n"));
  return ended.err;
}

std::string printed(const std::string& command) {
  FILE* pipe = ::popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  char part[256];
  while (std::fgets(part, sizeof part, pipe) != nullptr) text += part;
  CHECK(::pclose(pipe) == 0);
  return text;
}

bool has(DeviceKind kind) {
  return std::ranges::any_of(list_devices(), [kind](const FoundDevice& d) { return d.kind == kind; });
}

// A node that its mode and group keep closed to whoever is not root.
class ClosedNode {
 public:
  ClosedNode(mode_t mode, gid_t group) : path_(fmt::format("/dev/shm/hdrcam_tests_{}", ::getpid())) {
    const int fd = ::open(path_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
    REQUIRE(fd >= 0);
    if (::geteuid() == 0) REQUIRE(::fchown(fd, 0, group) == 0);
    REQUIRE(::fchmod(fd, mode) == 0);
    ::close(fd);
  }
  ~ClosedNode() { ::unlink(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

TEST_CASE("list says of every kind of device that there is none, and what to do") {
  const std::string text = printed("'" HDRCAM_BINARY "' list");
  for (const char* heading : {"Cameras:\n", "GPIO chips:\n", "Graphics devices:\n"})
    CHECK_THAT(text, Contains(heading));
  if (!has(DeviceKind::Camera))
    CHECK_THAT(text, Contains("none; connect one, or use a simulated one: --camera sim:walk"));
  if (!has(DeviceKind::GpioChip)) CHECK_THAT(text, Contains("none; a sync line needs one"));
  CHECK_THAT(printed("'" HDRCAM_BINARY "' list --json"), Matches("\\[[^]*\\]\n"));
}

TEST_CASE("without a camera every verb that needs one says so and what to do instead") {
  if (has(DeviceKind::Camera)) {
    NOT_TESTED("a camera is connected");
    return;
  }
  const std::vector<std::string> verbs[] = {
      {"live"}, {"record", "-o", "/dev/shm/never.mkv"}, {"calibrate", "delay"}};
  for (const auto& verb : verbs)
    CHECK_THAT(sentence(verb, ErrorCode::NotFound),
               Contains("there is no camera") && Contains("'hdrcam list'") && Contains("sim:SCENE"));
  CHECK_THAT(sentence({"live", "--camera", "imx219"}, ErrorCode::NotFound), Contains("'imx219'"));
  CHECK(::access("/dev/shm/never.mkv", F_OK) != 0);
}

TEST_CASE("a camera that is not there, or is something else, is named") {
  CHECK_THAT(sentence({"live", "--camera", "/dev/video77"}, ErrorCode::NotFound),
             Contains("there is no device '/dev/video77'; 'hdrcam list'"));
  CHECK_THAT(sentence({"live", "--camera", "/dev/null"}, ErrorCode::Unsupported),
             Contains("'/dev/null' is not a camera"));
  CHECK_THAT(sentence({"live", "--camera", "sim:wlak"}, ErrorCode::NotFound),
             Contains("'wlak'") && Contains("walk"));
  CHECK_THAT(sentence({"live", "--camera", "replay:/no/such.mkv"}, ErrorCode::NotFound),
             Contains("'/no/such.mkv'"));
}

TEST_CASE("a camera that may not be opened says how to get permission") {
  constexpr gid_t kNoGroup = 65534;
  const auto refused = [](mode_t mode) {
    const ClosedNode node(mode, kNoGroup);
    const test::AsNobody nobody;
    return sentence({"live", "--camera", node.path()}, ErrorCode::Permission);
  };
  CHECK_THAT(refused(0), Contains("no permission for '/dev/shm/") && Contains("udev rule"));
  if (::geteuid() == 0) CHECK_THAT(refused(0660), Contains("sudo usermod -aG "));
}

TEST_CASE("a format that a camera does not have is refused with those that it has") {
  for (const char* format : {"MJPEG", "YUXV"})
    CHECK_THAT(sentence({"live", "--camera", "sim:walk", "--format", format}, ErrorCode::Unsupported),
               Contains(format) && Contains("'sim:walk'") && Contains("RGB24 320x240"));
}

TEST_CASE("an exposure that a camera does not have is refused with the range") {
  const auto refused = [](const char* shutter, const char* gain) {
    return sentence({"live", "--camera", "sim:walk", "--shutter", shutter, "--gain", gain},
                    ErrorCode::BadExposure);
  };
  CHECK_THAT(refused("1ms,4s", "1"),
             Contains("4 s") && Contains("shorten it to") && !Contains("--framerate"));
  CHECK_THAT(refused("200s", "1"), Contains("shorten it to") && !Contains("--framerate"));
  CHECK_THAT(refused("1us,4ms", "1"), Contains("1 us") && Contains("'sim:walk'") && Contains(" to "));
  CHECK_THAT(refused("1ms,4ms", "500"), Contains("gain 500") && Contains("1 to 16"));
}

TEST_CASE("a sync line that is not there is named") {
  for (const char* line : {"gpiochip77:3", "no-such-strobe"})
    CHECK_THAT(sentence({"live", "--camera", "sim:walk", "--sync-line", line}, ErrorCode::NotFound),
               Contains(line) && Contains("'hdrcam list'"));
}
