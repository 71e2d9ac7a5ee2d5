#include "firmware_host/run/progress.h"

#include <chrono>
#include <memory>
#include <string>

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::chrono_literals;

namespace {

// What was printed for a run of `frames` frames, `apart` one from the next, on something that is not a
// terminal.
std::string printed(int frames, std::chrono::milliseconds apart) {
  char* text = nullptr;
  std::size_t size = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> log(std::tmpfile(), &std::fclose);
  REQUIRE(log != nullptr);
  {
    Progress progress(log.get(), frames);
    for (int i = 0; i < frames; ++i) progress.frame_done(61, 0.021, Progress::Clock::time_point(apart * i));
  }
  std::rewind(log.get());
  std::string lines;
  while (getline(&text, &size, log.get()) >= 0) lines += text;
  std::free(text);
  return lines;
}

}  // namespace

TEST_CASE("the line says how far, how fast, how well and how long still") {
  CHECK(progress_line({12, 48, 61.2, 0.0213}) == "frame 12/48  61 ms/frame  loss 0.021  ETA 00:03");
  CHECK(progress_line({12, std::nullopt, 61.2, std::nullopt}) == "frame 12  61 ms/frame");
  CHECK(progress_line({0, 6000, 50, std::nullopt}) == "frame 0/6000  50 ms/frame  ETA 05:00");
  CHECK(progress_line({7, 5, 50, std::nullopt}) == "frame 7/5  50 ms/frame  ETA 00:00");
}

TEST_CASE("before the first frame of a film the line says how far the recording is read") {
  ProgressState state;
  state.total = 1;
  state.frame_read(250);
  CHECK(progress_line(state) == "recorded frame 1  250 ms/frame");
  state.frame_read(250);
  CHECK(progress_line(state) == "recorded frame 2  250 ms/frame");
  state.frame_done(80, std::nullopt);
  CHECK(progress_line(state) == "frame 1/1  80 ms/frame  ETA 00:00");
  state.frame_read(250);  // between the frames of a film
  CHECK(progress_line(state) == "frame 1/1  80 ms/frame  ETA 00:00");
}

TEST_CASE("away from a terminal there is one plain line a second and one for the last frame") {
  CHECK(printed(3, 2000ms) ==
        "frame 1/3  61 ms/frame  loss 0.021  ETA 00:01\n"
        "frame 2/3  61 ms/frame  loss 0.021  ETA 00:01\n"
        "frame 3/3  61 ms/frame  loss 0.021  ETA 00:00\n");
  const std::string fast = printed(50, 100ms);
  CHECK(std::count(fast.begin(), fast.end(), '\n') == 6);
  CHECK(fast.find('\r') == std::string::npos);
  CHECK(fast.ends_with("frame 50/50  61 ms/frame  loss 0.021  ETA 00:00\n"));
}
