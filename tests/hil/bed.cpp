#include "tests/hil/bed.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "tests/contracts/expect.h"

namespace hdrcam::hil {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

std::string first_line(const fs::path& file) {
  std::string line;
  std::getline(std::ifstream(file), line);
  return line;
}

std::string find_node(std::string_view part) {
  std::error_code ignored;
  for (const auto& device : fs::directory_iterator("/sys/class/video4linux", ignored)) {
    const std::string name = device.path().filename();
    if (!name.starts_with("video") || first_line(device.path() / "index") != "0") continue;
    if (first_line(device.path() / "name").find(part) != std::string::npos) return "/dev/" + name;
  }
  return {};
}

pid_t start_program(const char* const* arguments) {
  const pid_t process = ::fork();
  REQUIRE(process >= 0);
  if (process > 0) return process;
  ::execvp(arguments[0], const_cast<char**>(arguments));
  ::_exit(127);
}

// Until all events of udev are dealt with: libcamera sees no device before.
void settle() {
  const char* arguments[] = {"udevadm", "settle", nullptr};
  int status = -1;
  ::waitpid(start_program(arguments), &status, 0);
  REQUIRE(status == 0);
}

}  // namespace

std::string video_node(std::string_view part) {
  for (int i = 0; i < 100; ++i) {
    if (const std::string node = find_node(part); !node.empty() && ::access(node.c_str(), R_OK) == 0)
      return node;
    std::this_thread::sleep_for(milliseconds(100));
  }
  FAIL("no video node '" << part << "'");
  return {};
}

SimulatedPin::SimulatedPin(int line) {
  const char* folder = std::getenv("HIL_GPIO");
  REQUIRE(folder != nullptr);
  const std::string pin = std::string(folder) + "/sim_gpio" + std::to_string(line);
  pull_ = pin + "/pull", value_ = pin + "/value";
}

void SimulatedPin::drive(bool high) const {
  std::ofstream file(pull_);
  file << (high ? "pull-up" : "pull-down") << std::flush;
  REQUIRE(file.good());
}

bool SimulatedPin::level() const { return first_line(value_) == "1"; }

UsbCamera::UsbCamera(int latency_frames, int rate_hz, std::string_view strobe_file, int lose_every) {
  static int plugged_in = 0;
  name_ = "hdrcam camera " + std::to_string(++plugged_in) + ".";
  const std::string latency = std::to_string(latency_frames), rate = std::to_string(rate_hz),
                    strobe(strobe_file), lose = std::to_string(lose_every);
  const char* arguments[] = {"./hdrcam_usb_camera", "--name",       name_.c_str(), "--latency",
                             latency.c_str(),       "--rate",       rate.c_str(),  "--strobe",
                             strobe.c_str(),        "--lose-every", lose.c_str(),  nullptr};
  process_ = start_program(arguments);
  (void)node();
  settle();
}

void UsbCamera::unplug() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
}

UsbCamera::~UsbCamera() {
  unplug();
  for (int i = 0; i < 50 && !find_node(name_).empty(); ++i) std::this_thread::sleep_for(milliseconds(100));
}

double mean_code(const CapturedBuffer& buffer) {
  const bool wide = buffer.mode.format >= PixelFormat::Rggb10 && buffer.mode.format <= PixelFormat::Bggr16;
  const std::size_t step = wide || buffer.mode.format == PixelFormat::Yuyv ? 2 : 1;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = buffer.stride * static_cast<std::size_t>(buffer.mode.height / 2);
       i + step <= buffer.pixels.size(); i += step, ++count) {
    const auto low = std::to_integer<unsigned>(buffer.pixels[i]);
    sum += wide ? low + 256U * std::to_integer<unsigned>(buffer.pixels[i + 1]) : low;
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace hdrcam::hil
