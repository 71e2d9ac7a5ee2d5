#include "hal/gpu/gpu_device.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>
#include <numeric>
#include <vector>

#include "hal/core/worker_pool.h"
#include "hal/fault/faulty_gpu.h"
#include "hal/gpu/gpu_list.h"
#include "online/pictures/vulkan/box_mean.comp.h"
#include "tests/support/gpu.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

std::vector<float> ramp(std::size_t n, float first = 0) {
  std::vector<float> values(n);
  std::iota(values.begin(), values.end(), first);
  return values;
}

std::vector<float> there_and_back(GpuDevice& gpu, const std::vector<float>& picture) {
  const auto buffer = value_of(gpu.buffer(4 * picture.size()));
  std::vector<float> back(picture.size());
  gpu.work().upload(std::as_bytes(std::span(picture)), *buffer);
  gpu.work().download(*buffer, std::as_writable_bytes(std::span(back)));
  require_done(gpu.work().finish());
  return back;
}

struct BoxMean {
  int rows, cols, radius;
};
const GpuShader kBoxMean{"box_mean", k_box_mean, 2};

TEST_CASE("graphics devices have a name and a version, the best kind first, or it is said what to install") {
  const auto found = list_gpus();
  if (!found) {
    CHECK((found.error().code == ErrorCode::NotFound || found.error().code == ErrorCode::Unsupported));
    CHECK(found.error().message.find("install") != std::string::npos);
    return;
  }
  CHECK(std::ranges::is_sorted(found.value(), {}, &GpuFacts::kind));  // the best first
  for (const GpuFacts& gpu : found.value()) {
    CHECK_FALSE(gpu.name.empty());
    CHECK(std::count(gpu.api.begin(), gpu.api.end(), '.') == 2);
    CHECK(std::isdigit(static_cast<unsigned char>(gpu.api.front())));
    CHECK(gpu.memory_gib > 0);  // Vulkan lets no device be without memory of its own
    if (gpu.missing.empty()) CHECK(gpu.subgroup >= 1);
  }
}

TEST_CASE("a graphics device that does not exist is not found, and those that do are named") {
  const auto found = list_gpus();
  if (!found || found.value().empty()) {
    LACKS_GPU("no graphics device here");
    return;
  }
  const auto opened = open_gpu({.name = "no such device"});
  require_error(opened, ErrorCode::NotFound);
  CHECK(opened.error().message.find("no such device") != std::string::npos);
  CHECK(opened.error().message.find(found.value().front().name) != std::string::npos);
}

TEST_CASE("a graphics device is found by a part of its name in any case") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  std::string part = gpu->facts().name.substr(0, 4);
  for (char& c : part) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  const auto again = value_of(open_gpu({.name = part}));
  CHECK(again->facts().name == gpu->facts().name);
  CHECK(again->facts().group >= again->facts().subgroup);
  CHECK(again->facts().group % again->facts().subgroup == 0);
}

TEST_CASE("what goes up to a graphics device comes back, step after step in their order") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  GpuWork& work = gpu->work();
  const auto a = value_of(gpu->buffer(4000)), b = value_of(gpu->buffer(4000));
  const std::vector<float> first = ramp(1000), second = ramp(1000, 5000);
  std::vector<float> seen(1000), then(1000), cleared(1000, 1);
  work.upload(std::as_bytes(std::span(first)), *a);
  work.copy(*a, *b);
  work.upload(std::as_bytes(std::span(second)), *a);
  work.download(*b, std::as_writable_bytes(std::span(seen)));
  work.download(*a, std::as_writable_bytes(std::span(then)));
  work.clear(*a);
  work.download(*a, std::as_writable_bytes(std::span(cleared)));
  require_done(work.finish());
  CHECK(seen == first);
  CHECK(then == second);
  CHECK(std::all_of(cleared.begin(), cleared.end(), [](float v) { return v == 0; }));
}

TEST_CASE("a graphics device can be opened again and again") {
  NEEDS_GPU(test::open_test_gpu());
  const std::vector<float> picture = ramp(1 << 20);
  for (int time = 0; time < 8; ++time) {
    INFO("time " << time);
    const auto gpu = value_of(open_gpu(test::gpu_options()));
    REQUIRE(there_and_back(*gpu, picture) == picture);
  }
}

TEST_CASE("a part of a graphics device's buffer is written and read by itself") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  GpuWork& work = gpu->work();
  const auto buffer = value_of(gpu->buffer(4000));
  const std::vector<float> whole = ramp(1000), part = ramp(10, 5000);
  std::vector<float> around(12), all(1000);
  work.upload(std::as_bytes(std::span(whole)), *buffer);
  work.upload(std::as_bytes(std::span(part)), *buffer, 4 * 100);
  work.download(*buffer, 4 * 99, std::as_writable_bytes(std::span(around)));
  work.download(*buffer, std::as_writable_bytes(std::span(all)));
  require_done(work.finish());
  std::vector<float> expected = whole;
  std::copy(part.begin(), part.end(), expected.begin() + 100);
  CHECK(all == expected);
  CHECK(std::equal(around.begin(), around.end(), expected.begin() + 99));
}

TEST_CASE("what several threads carry to a graphics device and back is what one does") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(3);
  const std::vector<float> picture = ramp(1'000'003);
  const GpuTurn turn(*gpu, &pool);
  CHECK(there_and_back(*gpu, picture) == picture);
}

TEST_CASE("a graphics device says how long each kind of step took") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  GpuWork& work = gpu->work();
  const GpuKernel* mean = value_of(gpu->kernel(kBoxMean));
  constexpr int kSize = 256, kRuns = 3;
  std::vector<float> picture(kSize * kSize, 1);
  const auto in = value_of(gpu->buffer(picture.size() * 4)), out = value_of(gpu->buffer(picture.size() * 4));
  const auto run = [&] {
    work.upload(std::as_bytes(std::span(picture)), *in);
    for (int i = 0; i < kRuns; ++i)
      work.run(*mean, {in.get(), out.get()}, BoxMean{kSize, kSize, 2}, {kSize, kSize, 1});
    work.download(*out, std::as_writable_bytes(std::span(picture)));
    require_done(work.finish());
  };
  GpuStepTimes times;
  work.measure(&times);
  const auto start = std::chrono::steady_clock::now();
  run();
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (times.empty()) {
    NOT_TESTED("the graphics device has no clock");
    return;
  }
  CHECK(times["upload"].times == 1);
  CHECK(times["box_mean"].times == kRuns);
  CHECK(times["download"].times == 1);
  CHECK(times["box_mean"].ms > 0);
  CHECK(times["box_mean"].ms < wall_ms);
  work.measure(nullptr);
  run();
  CHECK(times["box_mean"].times == kRuns);
}

TEST_CASE("a kernel is made once, sees its constants and leaves out what is beyond its grid") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  GpuWork& work = gpu->work();
  const GpuKernel* mean = value_of(gpu->kernel(kBoxMean));
  CHECK(value_of(gpu->kernel(kBoxMean)) == mean);
  const int rows = 7, cols = 91;  // no multiple of any group
  const std::vector<float> flat(static_cast<std::size_t>(rows * cols), 3);
  std::vector<float> out(flat.size() + 100, -1);
  const auto in = value_of(gpu->buffer(flat.size() * 4)), to = value_of(gpu->buffer(out.size() * 4));
  work.upload(std::as_bytes(std::span(flat)), *in);
  work.upload(std::as_bytes(std::span(out)), *to);
  work.run(*mean, {in.get(), to.get()}, BoxMean{rows, cols, 2}, {cols, rows, 1});
  work.download(*to, std::as_writable_bytes(std::span(out)));
  require_done(work.finish());
  for (std::size_t i = 0; i < flat.size(); ++i) REQUIRE(out[i] == Approx(3));
  for (std::size_t i = flat.size(); i < out.size(); ++i) REQUIRE(out[i] == -1);
}

TEST_CASE("buffers of a graphics device do not touch each other, and their room is used again") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  GpuWork& work = gpu->work();
  for (int round = 0; round < 20; ++round) {
    std::vector<std::unique_ptr<GpuBuffer>> buffers;
    const std::size_t sizes[] = {4, 260, 5 << 20, 1024, 20 << 20, 12, 3 << 20};
    for (const std::size_t bytes : sizes) buffers.push_back(value_of(gpu->buffer(bytes)));
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      const std::vector<float> values(sizes[i] / 4, static_cast<float>(i));
      work.upload(std::as_bytes(std::span(values)), *buffers[i]);
    }
    for (std::size_t i = 0; i < buffers.size(); i += 2) buffers[i].reset();
    require_done(work.finish());
    for (std::size_t i = 1; i < buffers.size(); i += 2) {
      std::vector<float> values(sizes[i] / 4, -1);
      work.download(*buffers[i], std::as_writable_bytes(std::span(values)));
      require_done(work.finish());
      CHECK(std::all_of(values.begin(), values.end(), [i](float v) { return v == static_cast<float>(i); }));
    }
  }
}

TEST_CASE("more memory than a graphics device lets a kernel see is an error, and the device goes on") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  const auto huge = gpu->buffer(std::size_t{1} << 45);
  REQUIRE_FALSE(huge.ok());
  CHECK((huge.error().code == ErrorCode::NoSpace || huge.error().code == ErrorCode::Unsupported));
  CHECK(gpu->buffer(1024).ok());
}

TEST_CASE("a lost graphics device says so at every finish, and sends nothing") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  FaultyGpu faulty(*gpu, {.finishes_until_lost = 1});
  const auto a = value_of(faulty.buffer(40));
  std::vector<float> out(10, -1);
  faulty.work().clear(*a);
  require_done(faulty.work().finish());
  for (int i = 0; i < 2; ++i) {
    faulty.work().download(*a, std::as_writable_bytes(std::span(out)));
    require_error(faulty.work().finish(), ErrorCode::Unplugged);
    CHECK(out[0] == -1);
  }
}

}  // namespace
}  // namespace hdrcam
