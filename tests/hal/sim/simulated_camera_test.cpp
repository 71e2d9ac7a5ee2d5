// The simulated camera: the contract of all cameras, and what its own header promises about time, delays and
// injected faults.
#include "hal/sim/simulated_camera.h"

#include <map>

#include "hal/pixel_pack.h"
#include "hal/sim/sim_bench.h"
#include "tests/allocation_checks.h"
#include "tests/contracts/camera_contract.h"
#include "tests/contracts/expect.h"

using namespace hdrcam;
using std::chrono::milliseconds;

namespace {

const char* kTiny = "still?size=32x24&without=noise";

std::unique_ptr<SimulatedCamera> virtual_camera(const std::string& spec, VirtualClock& clock,
                                                SimulatedWire* strobe = nullptr) {
  return std::make_unique<SimulatedCamera>(value_of(simulation_of(spec)), SimTime(clock), 1,
                                           SimulatedWiring{.strobe = strobe});
}

// A running stream whose request n asks for 1, 4, 8 ms and gain 1, 2, 4 in turn.
struct Stream {
  explicit Stream(const std::string& spec, SimulatedWire* strobe = nullptr, VirtualClock* shared = nullptr)
      : clock(shared != nullptr ? *shared : own),
        camera(virtual_camera(spec, clock, strobe)),
        bench(*camera) {
    value_of(camera->configure({}, 4));
    require_done(camera->start());
    for (int i = 0; i < 4; ++i) queue();
  }
  static Duration exposure(std::uint64_t cookie) {
    return milliseconds(cookie % 3 == 0 ? 1 : cookie % 3 == 1 ? 4 : 8);
  }
  static double gain(std::uint64_t cookie) { return cookie % 3 == 0 ? 1 : cookie % 3 == 1 ? 2 : 4; }
  void queue() {
    require_done(camera->queue({next_cookie, exposure(next_cookie), gain(next_cookie)}));
    ++next_cookie;
  }
  CapturedBuffer next() {
    CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(1)));
    { const BufferLease back = std::move(buffer.lease); }
    queue();
    return buffer;
  }
  TrueExposure truth(const CapturedBuffer& buffer) {
    const auto found = bench.true_exposure(buffer.sequence);
    REQUIRE(found);
    return *found;
  }

  VirtualClock own;
  VirtualClock& clock;
  std::unique_ptr<SimulatedCamera> camera;
  SimBench bench;
  std::uint64_t next_cookie = 0;
};

}  // namespace

TEST_CASE("the simulated camera keeps the camera contract") {
  const auto open = [](const char* spec) {
    return [spec]() -> Result<std::unique_ptr<Camera>> { return open_simulated_camera(spec); };
  };
  keeps_camera_contract({.name = "simulated RGB",
                         .open = open("still?size=32x24&fps=100"),
                         .mode = {PixelFormat::Rgb24, 32, 24, milliseconds(10)},
                         .drops_frames = true});  // it keeps real time, and a busy machine is late
  keeps_camera_contract({.name = "simulated Bayer",
                         .open = open("walk?size=32x24&fps=100&drops=0.1"),
                         .mode = {PixelFormat::Rggb10Packed, 32, 24, milliseconds(10)},
                         .drops_frames = true});
}

TEST_CASE("for every set of delays a control shows as many frames later as its delay says") {
  for (int exposure_delay = 0; exposure_delay <= 4; ++exposure_delay)
    for (int gain_delay = 0; gain_delay <= 4; ++gain_delay) {
      Stream stream(fmt::format("{}&delay={},{}", kTiny, exposure_delay, gain_delay));
      for (std::uint64_t i = 0; i < 12; ++i) {
        const CapturedBuffer buffer = stream.next();
        const TrueExposure truth = stream.truth(buffer);
        INFO("delays " << exposure_delay << ", " << gain_delay << ", frame " << i);
        REQUIRE(buffer.cookie == i);
        REQUIRE(buffer.sequence == i);
        if (i >= static_cast<std::uint64_t>(exposure_delay))
          REQUIRE(truth.exposure == Stream::exposure(i - static_cast<std::uint64_t>(exposure_delay)));
        if (i >= static_cast<std::uint64_t>(gain_delay))
          REQUIRE(truth.analogue_gain == Stream::gain(i - static_cast<std::uint64_t>(gain_delay)));
        REQUIRE(buffer.exposure == truth.exposure);
        REQUIRE(buffer.analogue_gain == truth.analogue_gain);
      }
    }
}

TEST_CASE("the simulated camera states the black level of its raw codes, unless it reports nothing") {
  const auto stated = [](const std::string& spec, PixelFormat format) {
    VirtualClock clock;
    auto camera = virtual_camera(spec, clock);
    REQUIRE(camera->configure({format, 32, 24, milliseconds(33)}, 3).ok());
    return camera->capabilities().black_level;
  };
  const auto raw = stated("still?size=32x24&black=0.05", PixelFormat::Rggb12);
  REQUIRE(raw);
  CHECK((*raw)[1] == Approx(0.05 * 255));
  CHECK(stated("still?size=32x24", PixelFormat::Rggb12) == BlackLevel());
  CHECK_FALSE(stated("still?size=32x24&black=0.05", PixelFormat::Rgb24));
  CHECK_FALSE(stated("still?size=32x24&black=0.05&reports=no", PixelFormat::Rggb12));
}

TEST_CASE("the pixels are those of the true exposure, in every format") {
  for (const PixelFormat format :
       {PixelFormat::Rgb24, PixelFormat::Bgr24, PixelFormat::Rggb8, PixelFormat::Rggb12,
        PixelFormat::Rggb10Packed, PixelFormat::Rggb12Packed, PixelFormat::Rggb16}) {
    const std::string spec = "walk?size=32x24&delay=2,1";
    VirtualClock clock;
    auto camera = virtual_camera(spec, clock);
    SimBench bench(*camera);
    const StreamMode mode = value_of(camera->configure({format, 32, 24, milliseconds(33)}, 3));
    require_done(camera->start());
    for (std::uint64_t i = 0; i < 3; ++i)
      require_done(camera->queue({i, Stream::exposure(i), Stream::gain(i)}));
    Simulation simulation = value_of(simulation_of(spec));
    simulation.framerate_hz = 1 / to_seconds(mode.frame_duration);
    const PackedFormat packed = packed_format(format).value();
    WorkerPool pool(1);
    SimulatedSensor sensor(simulation, packed.layout, packed.bits, pool);
    for (int i = 0; i < 3; ++i) {
      const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(1)));
      const TrueExposure truth = bench.true_exposure(buffer.sequence).value();
      Image<std::uint16_t> codes;
      sensor.expose({buffer.sequence, to_seconds(mode.frame_duration) * static_cast<double>(buffer.sequence),
                     to_seconds(truth.exposure), truth.analogue_gain},
                    codes);
      std::vector<std::byte> expected(packed_stride(format, 32) * 24);
      pack_codes(codes, format, expected);
      INFO(name(format) << " frame " << i);
      REQUIRE(std::equal(expected.begin(), expected.end(), buffer.pixels.begin(), buffer.pixels.end()));
    }
  }
}

TEST_CASE("a dropped frame leaves a gap, keeps its request, and was exposed all the same") {
  Stream stream(kTiny);
  for (int i = 0; i < 5; ++i) stream.next();
  stream.bench.drop_next(2);
  const CapturedBuffer before = stream.next();  // exposed before the order came
  const CapturedBuffer after = stream.next();
  CHECK(after.sequence == before.sequence + 3);
  CHECK(after.cookie == before.cookie + 1);
  CHECK(after.timestamp - before.timestamp == 3 * after.mode.frame_duration);
  CHECK(stream.bench.true_exposure(before.sequence + 1));
  CHECK_FALSE(stream.bench.true_exposure(after.sequence + 100));
}

TEST_CASE("a request that is due is written while frames are lost, and acts after its delay") {
  Stream stream(fmt::format("{}&delay=2,1", kTiny));
  for (int i = 0; i < 5; ++i) stream.next();
  stream.bench.drop_next(1);
  stream.next();  // exposed before the order came
  const CapturedBuffer after = stream.next(), following = stream.next();
  CHECK(following.sequence == after.sequence + 1);
  CHECK(stream.truth(after).analogue_gain == Stream::gain(after.cookie));
  CHECK(stream.truth(following).exposure == Stream::exposure(after.cookie));
}

TEST_CASE("frames are lost while nobody has asked for one") {
  VirtualClock clock;
  auto camera = virtual_camera(kTiny, clock);
  value_of(camera->configure({}, 2));
  require_done(camera->start());
  require_error(camera->wait(milliseconds(500)), ErrorCode::Timeout);
  require_done(camera->queue({1, milliseconds(1), 1}));
  CHECK(value_of(camera->wait(milliseconds(500))).sequence >= 14);
}

TEST_CASE("disturbed metadata lies about the exposure, the bench does not") {
  struct Case {
    MetadataFault fault;
    std::function<void(const CapturedBuffer&, const CapturedBuffer&, const TrueExposure&)> holds;
  };
  const Case cases[] = {
      {MetadataFault::Missing, [](const auto&, const auto& now, const auto&) { CHECK_FALSE(now.exposure); }},
      {MetadataFault::Late,
       [](const auto& before, const auto& now, const TrueExposure& truth) {
         CHECK(now.exposure == before.exposure);
         CHECK(now.exposure != truth.exposure);
         CHECK(now.cookie == before.cookie + 1);
       }},
      {MetadataFault::Doubled,
       [](const auto& before, const auto& now, const TrueExposure& truth) {
         CHECK(now.exposure == before.exposure);
         CHECK(now.exposure != truth.exposure);
         CHECK(now.cookie == before.cookie);
       }},
  };
  for (const Case& c : cases) {
    Stream stream(kTiny);
    for (int i = 0; i < 5; ++i) stream.next();
    stream.bench.disturb_metadata(c.fault, 1);
    const CapturedBuffer before = stream.next();  // exposed before the order came
    const CapturedBuffer now = stream.next();
    const CapturedBuffer after = stream.next();
    INFO("fault " << static_cast<int>(c.fault));
    c.holds(before, now, stream.truth(now));
    CHECK(after.exposure == stream.truth(after).exposure);
    CHECK(after.cookie == before.cookie + 2);
  }
}

TEST_CASE("disturbed controls act early, late, clipped or never") {
  const auto exposures = [](ControlFault fault) {
    Stream stream(fmt::format("{}&delay=1,1", kTiny));
    for (int i = 0; i < 5; ++i) stream.next();  // frames 0..4; frame 5 has begun
    stream.bench.disturb_controls(fault, 1);    // the request of frame 6, 1 ms, shows in frame 7
    std::map<std::uint64_t, Duration> seen;
    for (int i = 0; i < 5; ++i) {
      const CapturedBuffer buffer = stream.next();
      seen[buffer.sequence] = stream.truth(buffer).exposure;
    }
    return std::array{seen.at(6), seen.at(7), seen.at(8), seen.at(9)};
  };
  const Duration ms1 = milliseconds(1), ms2 = milliseconds(2), ms4 = milliseconds(4), ms8 = milliseconds(8);
  CHECK(exposures(ControlFault::None) == std::array{ms8, ms1, ms4, ms8});
  CHECK(exposures(ControlFault::Early) == std::array{ms1, ms1, ms4, ms8});
  CHECK(exposures(ControlFault::Late) == std::array{ms8, ms8, ms4, ms8});  // overwritten by the next on time
  CHECK(exposures(ControlFault::Ignored) == std::array{ms8, ms8, ms4, ms8});
  CHECK(exposures(ControlFault::Clipped) == std::array{ms8, ms1, ms4, ms8});  // 1 ms is below the clip
  Stream stream(fmt::format("{}&delay=0,0", kTiny));
  stream.bench.disturb_controls(ControlFault::Clipped, 8);
  for (int i = 0; i < 6; ++i) CHECK(stream.truth(stream.next()).exposure <= ms2);
}

TEST_CASE("the strobe is high while each frame is exposed, lost ones too") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine line(wire);
  Stream stream(std::string(kTiny) + "&drops=0.3", &wire, &clock);
  for (int i = 0; i < 20; ++i) stream.next();
  for (std::uint64_t frame = 0; frame < 20; ++frame) {
    const TrueExposure truth = stream.bench.true_exposure(frame).value();
    const Edge rise = value_of(line.wait_edge(Duration::zero())),
               fall = value_of(line.wait_edge(Duration::zero()));
    INFO("frame " << frame);
    REQUIRE(rise.rising);
    REQUIRE_FALSE(fall.rising);
    REQUIRE(rise.at == truth.begin);
    REQUIRE(fall.at == truth.begin + truth.exposure);
  }
}

TEST_CASE("in virtual time a run is the same every time, stamps and bytes") {
  const auto run = [] {
    Stream stream("night?size=32x24&drops=0.2&with=clock-jitter");
    std::vector<std::uint64_t> facts;
    std::uint64_t hash = 0;
    for (int i = 0; i < 30; ++i) {
      const CapturedBuffer buffer = stream.next();
      facts.push_back(buffer.sequence);
      facts.push_back(static_cast<std::uint64_t>(buffer.timestamp.since_boot.count()));
      for (const std::byte b : buffer.pixels)
        hash = hash * 1099511628211u + std::to_integer<std::uint64_t>(b);
      facts.push_back(hash);
    }
    return facts;
  };
  CHECK(run() == run());
}

TEST_CASE("the simulated camera states the read-out time of its rolling shutter") {
  CHECK(Stream("still?size=32x24&with=rolling-shutter").next().readout == std::chrono::milliseconds(12));
  CHECK(Stream("still?size=32x24").next().readout == Duration(0));
}

TEST_CASE("no frame is delivered before its last row was exposed") {
  for (const int fps : {30, 200}) {
    VirtualClock clock;
    const auto camera = virtual_camera(
        fmt::format("still?size=32x24&with=rolling-shutter&without=control-delay&fps={}", fps), clock);
    value_of(camera->configure({}, 4));
    require_done(camera->start());
    const Duration longest = camera->capabilities().exposure_max;
    for (std::uint64_t i = 0; i < 4; ++i)
      require_done(camera->queue({i, i % 2 == 0 ? longest : milliseconds(1), 1}));
    for (std::uint64_t i = 0; i < 4; ++i) {
      const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(1)));
      INFO(fps << " fps, frame " << i);
      CHECK(buffer.cookie == i);
      REQUIRE(buffer.exposure);
      CHECK(clock.now() - buffer.timestamp >= *buffer.exposure + buffer.readout);
    }
  }
}

TEST_CASE("a camera that reports nothing says so, and offers no delays") {
  VirtualClock clock;
  const auto camera = virtual_camera(std::string(kTiny) + "&reports=no", clock);
  CHECK_FALSE(camera->capabilities().reports_exposure);
  CHECK_FALSE(camera->capabilities().delays);
  Stream stream(std::string(kTiny) + "&reports=no");
  CHECK_FALSE(stream.next().exposure);
  CHECK(virtual_camera(kTiny, clock)->capabilities().delays == ControlDelays{2, 1});
  CHECK(virtual_camera(std::string(kTiny) + "&without=control-delay", clock)
            ->capabilities()
            .exposure_per_request);
}

TEST_CASE("a running camera allocates nothing once the first frame has come") {
  Stream stream("night?size=32x24&drops=0.1&with=clock-jitter,rolling-shutter");
  stream.next();
  bool good = true;
  const std::uint64_t before = allocations_so_far();
  for (int i = 0; i < 50; ++i) {
    good &= stream.camera->wait(std::chrono::seconds(1)).ok();  // and back at once
    good &= stream.camera->queue({stream.next_cookie++, milliseconds(1), 1}).ok();
  }
  const std::uint64_t after = allocations_so_far();
  CHECK(good);
  CHECK_ALLOCATIONS(after == before);
}

TEST_CASE("five hundred and a thousand small frames a second can be asked for") {
  for (const int fps : {500, 1000}) {
    VirtualClock clock;
    const auto camera = virtual_camera(fmt::format("walk?size=32x24&rays=1&fps={}", fps), clock);
    const Duration frame = Duration(std::chrono::seconds(1)) / fps;
    const CameraCapabilities& can = camera->capabilities();
    CHECK(can.usual_frame_duration == frame);
    value_of(camera->configure({PixelFormat::Rgb24, 32, 24, can.usual_frame_duration}, 2));
    CHECK(can.exposure_max < frame);
    CHECK(can.exposure_max > frame * 3 / 4);
    require_done(camera->start());
    require_done(camera->queue({0, can.exposure_max, 1}));
    require_done(camera->queue({1, can.exposure_max, 1}));
    const Instant first = value_of(camera->wait(frame * 4)).timestamp;
    CHECK(value_of(camera->wait(frame * 4)).timestamp - first == frame);
  }
}

TEST_CASE("frames that are exposed before a control acts are no longer than the camera can expose") {
  for (const int fps : {30, 500, 1000}) {
    VirtualClock clock;
    const auto camera = virtual_camera(fmt::format("{}&delay=2,1&fps={}", kTiny, fps), clock);
    value_of(camera->configure({}, 4));
    require_done(camera->start());
    require_done(camera->queue({0, std::chrono::microseconds(500), 1}));
    const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(1)));
    INFO(fps << " frames a second");
    REQUIRE(buffer.exposure);
    CHECK(*buffer.exposure <= camera->capabilities().exposure_max);
    if (fps == 30) CHECK(*buffer.exposure == milliseconds(4));
  }
}

TEST_CASE("an unplugged camera says so in every call that needs it") {
  Stream stream(kTiny);
  stream.next();
  stream.bench.unplug();
  require_error(stream.camera->wait(milliseconds(10)), ErrorCode::Unplugged);
  require_error(stream.camera->queue({9, milliseconds(1), 1}), ErrorCode::Unplugged);
  require_done(stream.camera->stop());
  require_error(stream.camera->start(), ErrorCode::Unplugged);
}

TEST_CASE("what the simulated camera cannot deliver is refused in a sentence") {
  VirtualClock clock;
  auto camera = virtual_camera(kTiny, clock);
  require_error(camera->configure({PixelFormat::Mjpeg, 32, 24, {}}, 4), ErrorCode::Unsupported);
  require_error(camera->configure({}, 0), ErrorCode::Invalid);
  require_error(camera->start(), ErrorCode::Invalid);
  const auto unknown = open_simulated_camera("nowhere");
  require_error(unknown, ErrorCode::NotFound);
}
