#include "tests/contracts/camera_contract.h"
#include "tests/allocation_checks.h"

#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

// A camera that is configured, and the cookies that were queued.
struct Session {
  const CameraUnderTest& facts;
  std::unique_ptr<Camera> camera = value_of(facts.open());
  StreamMode mode = value_of(camera->configure(facts.mode, facts.buffers));
  std::uint64_t next_cookie = 1000;

  std::uint64_t queue_one() {
    ExposureRequest request = next_cookie % 2 == 0 ? facts.short_exposure : facts.long_exposure;
    request.cookie = next_cookie;
    require_done(camera->queue(request));
    return next_cookie++;
  }
  void queue_all() {
    for (int i = 0; i < facts.buffers; ++i) queue_one();
  }
  CapturedBuffer next() { return value_of(camera->wait(facts.patience)); }
};

void delivers_what_it_says(const CameraUnderTest& facts) {
  Session session{facts};
  const CameraCapabilities& has = session.camera->capabilities();
  CHECK_FALSE(has.id.empty());
  CHECK_FALSE(has.driver.empty());
  CHECK_FALSE(has.modes.empty());
  if (has.sets_exposure) {
    CHECK(has.exposure_min > Duration::zero());
    CHECK(has.exposure_min <= has.exposure_max);
    CHECK(has.gain_min <= has.gain_max);
  }
  CHECK(session.mode.format == facts.mode.format);
  CHECK(session.mode.width == facts.mode.width);
  CHECK(session.mode.height == facts.mode.height);
  CHECK(session.mode.frame_duration > Duration::zero());
  require_done(session.camera->start());
  session.queue_all();
  const CapturedBuffer buffer = session.next();
  CHECK(buffer.mode.format == session.mode.format);
  CHECK(buffer.mode.width == session.mode.width);
  CHECK(buffer.mode.height == session.mode.height);
  CHECK_FALSE(buffer.damaged);
  if (session.mode.format == PixelFormat::Mjpeg) {
    CHECK(buffer.pixels.size() > 0);
  } else {
    CHECK(buffer.stride > 0);
    CHECK(buffer.pixels.size() >= buffer.stride * static_cast<std::size_t>(session.mode.height));
  }
  if (has.reports_exposure) CHECK(buffer.exposure.has_value());
}

void echoes_cookies_in_order(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  session.queue_all();
  std::uint64_t expected = 1000, sequence = 0;
  Instant before{};
  for (int i = 0; i < facts.frames; ++i) {
    {
      const CapturedBuffer buffer = session.next();
      INFO("frame " << i);
      REQUIRE(buffer.cookie == expected++);
      if (i > 0) {
        REQUIRE((buffer.sequence > sequence || (facts.repeats_sequence && buffer.sequence == sequence)));
        REQUIRE(buffer.timestamp > before);
      }
      if (i > 0 && !facts.drops_frames) CHECK(buffer.sequence == sequence + 1);
      sequence = buffer.sequence, before = buffer.timestamp;
    }
    session.queue_one();
  }
}

void takes_as_many_requests_as_buffers(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  std::vector<CapturedBuffer> held;  // a buffer that somebody reads is not free either
  session.queue_all();
  for (int i = 0; i < facts.buffers; ++i) held.push_back(session.next());
  ExposureRequest one_more = facts.short_exposure;
  require_error(session.camera->queue(one_more), ErrorCode::Busy);
  held.clear();
  session.queue_one();
  CHECK(session.next().cookie + 1 == session.next_cookie);
}

void starts_again_after_stop(const CameraUnderTest& facts) {
  Session session{facts};
  for (int round = 0; round < 3; ++round) {
    require_done(session.camera->start());
    session.queue_all();
    const std::uint64_t first = session.next_cookie - static_cast<std::uint64_t>(facts.buffers);
    INFO("round " << round);
    REQUIRE(session.next().cookie == first);  // none of the requests that the last stop() dropped
    require_done(session.camera->stop());
  }
  require_done(session.camera->stop());  // once more is no harm
}

void stops_with_requests_queued(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  session.queue_all();
  require_done(session.camera->stop());
  require_error(session.camera->wait(facts.patience), ErrorCode::Interrupted);
  require_done(session.camera->start());
  session.queue_all();  // every buffer is free again
  for (int i = 0; i < facts.buffers; ++i) session.next();
}

void closes_with_requests_queued(const CameraUnderTest& facts) {
  for (int round = 0; round < 2; ++round) {  // the second finds the device free again
    Session session{facts};
    require_done(session.camera->start());
    session.queue_all();
  }
  CHECK(facts.open().ok());
}

void ends_a_wait_by_stop(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  std::thread other([&] {
    std::this_thread::sleep_for(milliseconds(50));
    (void)session.camera->stop();
  });
  const auto begin = SteadyClock::now();
  const Result<CapturedBuffer> waited = session.camera->wait(std::chrono::seconds(20));
  other.join();
  require_error(waited, ErrorCode::Interrupted);
  CHECK(SteadyClock::now() - begin < std::chrono::seconds(10));
}

void times_out_without_a_request(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  require_error(session.camera->wait(milliseconds(30)), ErrorCode::Timeout);
  session.queue_all();  // and goes on afterwards
  session.next();
}

void refuses_out_of_order_calls(const CameraUnderTest& facts) {
  Session session{facts};
  require_error(session.camera->queue(facts.short_exposure), ErrorCode::Invalid);  // not started
  require_done(session.camera->start());
  require_error(session.camera->configure(facts.mode, facts.buffers), ErrorCode::Invalid);
  require_error(session.camera->start(), ErrorCode::Invalid);
  session.queue_all();
  session.next();  // none of which did any harm
  require_done(session.camera->stop());
  value_of(session.camera->configure(facts.mode, facts.buffers));
}

void is_not_configured_under_a_reader(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  session.queue_all();
  {
    const CapturedBuffer read = session.next();
    require_done(session.camera->stop());
    require_error(session.camera->configure(facts.mode, facts.buffers), ErrorCode::Busy);
  }
  value_of(session.camera->configure(facts.mode, facts.buffers));
  require_done(session.camera->start());
  session.queue_all();
  for (int i = 0; i < facts.buffers; ++i) session.next();
}

void refuses_an_impossible_exposure(const CameraUnderTest& facts) {
  Session session{facts};
  if (!session.camera->capabilities().sets_exposure) {
    SUCCEED("no exposure can be asked for");
    return;
  }
  require_done(session.camera->start());
  ExposureRequest request = facts.short_exposure;
  request.exposure = Duration::zero();
  require_error(session.camera->queue(request), ErrorCode::Invalid);
  request.exposure = session.camera->capabilities().exposure_max * 2;
  require_error(session.camera->queue(request), ErrorCode::Invalid);
}

void does_not_allocate_per_frame(const CameraUnderTest& facts) {
  Session session{facts};
  require_done(session.camera->start());
  session.queue_all();
  const int warm_up = 2 * facts.buffers;
  std::uint64_t before = 0;
  for (int i = 0; i < warm_up + facts.frames; ++i) {
    if (i == warm_up) before = allocations_so_far();
    Result<CapturedBuffer> buffer = session.camera->wait(facts.patience);
    if (!buffer.ok()) FAIL(buffer.error().message);
    { const BufferLease back = std::move(buffer->lease); }
    ExposureRequest request = i % 2 == 0 ? facts.short_exposure : facts.long_exposure;
    request.cookie = session.next_cookie++;
    if (const Result<void> queued = session.camera->queue(request); !queued.ok())
      FAIL(queued.error().message);
  }
  const double per_frame = static_cast<double>(allocations_so_far() - before) / facts.frames;
  INFO(per_frame << " allocations a frame");
  CHECK_ALLOCATIONS(per_frame <= facts.allocations_per_frame);
}

struct Clause {
  const char* sentence;
  void (*holds)(const CameraUnderTest&);
};
constexpr Clause kClauses[] = {
    {"delivers the mode that it agreed to", delivers_what_it_says},
    {"echoes every cookie once, in order, with growing sequence numbers and timestamps",
     echoes_cookies_in_order},
    {"takes as many requests as it has free buffers", takes_as_many_requests_as_buffers},
    {"starts again after stop", starts_again_after_stop},
    {"drops queued requests at stop", stops_with_requests_queued},
    {"may be closed with requests queued", closes_with_requests_queued},
    {"ends a wait when another thread stops it", ends_a_wait_by_stop},
    {"times out when nothing was requested", times_out_without_a_request},
    {"refuses calls out of order", refuses_out_of_order_calls},
    {"is not configured anew while a frame is read", is_not_configured_under_a_reader},
    {"refuses an exposure that it cannot make", refuses_an_impossible_exposure},
    {"does not allocate per frame", does_not_allocate_per_frame},
};

}  // namespace

void keeps_camera_contract(const CameraUnderTest& camera) {
  for (const Clause& clause : kClauses) DYNAMIC_SECTION(camera.name << " " << clause.sentence) {
      clause.holds(camera);
    }
}

}  // namespace hdrcam
