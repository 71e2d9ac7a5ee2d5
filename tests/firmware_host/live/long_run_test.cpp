// A run that lasts: what grows with the number of frames would end a camera's life.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "firmware_host/live/live_session.h"
#include "firmware_host/run/fit_run.h"
#include "hal/sim/simulated_camera.h"
#include "tests/allocations.h"
#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

std::size_t threads_of_this_process() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& task : std::filesystem::directory_iterator("/proc/self/task")) ++count;
  return count;
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

struct Growth {
  std::uint64_t allocations = 0;
  std::ptrdiff_t bytes = 0;
};

// What the process took from the moment when `warm` frames were captured until the end.
Growth growth_over(std::uint64_t frames, std::uint64_t warm) {
  SimulatedCamera camera(value_of(simulation_of("still?size=48x32&fps=250")), SimTime(), 1);
  CaptureOptions options;
  options.mode = {PixelFormat::Rgb24, 48, 32, milliseconds(4)};
  const Exposure cycle[] = {{milliseconds(1), 1}, {milliseconds(2), 1}};
  auto capture = value_of(CaptureStage::open(camera, nullptr, cycle, Mains::Off, options));
  LiveSession session(*capture, nullptr, {.frames = frames});
  Settings settings;
  settings.fit.preset = "fast";
  settings.fit.threads = 2;
  auto run = value_of(FitRun::open(
      settings, capture->facts(), "long", "", posix_storage(),
      [&](FrameRecord& frame) { session.emitted(frame.sequence); }, FrameSource::Camera));
  const std::atomic<bool> never{false};
  require_done(session.start());
  Growth growth;
  std::uint64_t allocations = 0;
  std::size_t bytes = 0;
  while (const FrameShare frame = session.next(never, {})) {
    if (allocations == 0 && session.counters().captured() >= warm)
      allocations = own_allocations_so_far(), bytes = resident_bytes();
    require_done(run->take(frame->captured.raw));
  }
  growth.allocations = own_allocations_so_far() - allocations;
  growth.bytes = static_cast<std::ptrdiff_t>(resident_bytes()) - static_cast<std::ptrdiff_t>(bytes);
  require_done(run->finish());
  CHECK(value_of(session.finish()) == LiveEnd::Frames);
  const LiveCounters counters = session.counters();
  CHECK(counters.captured() == frames);
  CHECK(counters.captured() == counters.emitted + counters.dropped());
  CHECK(counters.emitted > frames / 50);
  CHECK(counters.camera.contradicted == 0);
  return growth;
}

void lasts(std::uint64_t frames, std::uint64_t warm) {
  const std::size_t threads = threads_of_this_process();
  const Growth growth = growth_over(frames, warm);

  // its own.
  CHECK(growth.allocations == 0);
  if (allocations_are_counted()) CHECK(growth.bytes < 2 << 20);  // a sanitizer keeps what is freed
  CHECK(threads_of_this_process() == threads);
}

TEST_CASE("two thousand frames of a camera cost no allocation after the first, no memory and no thread") {
  lasts(2'000, 1'000);
}

TEST_CASE("ten thousand frames cost no more", "[.][full]") { lasts(10'000, 2'000); }

}  // namespace
}  // namespace hdrcam
