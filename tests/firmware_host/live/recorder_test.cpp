#include "firmware_host/live/recorder.h"

#include <atomic>
#include <new>
#include <vector>

#include "hal/fault/faulty_storage.h"
#include "tests/firmware_host/live/writer_without_memory.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/becomes_true.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

const CameraFacts kCamera = sample::camera(PixelLayout::Rgb, 8, 32, 24);

FrameShare holding(const RawFrame& frame, FramePool& pool) {
  FrameShare share = pool.take();
  REQUIRE(share);
  share->captured.raw.facts = frame.facts;
  share->captured.raw.codes.copy_from(frame.codes);
  return share;
}

// Frames of the pool that nobody holds.
int free_in(FramePool& pool) {
  std::vector<FrameShare> taken;
  while (FrameShare frame = pool.take()) taken.push_back(std::move(frame));
  return static_cast<int>(taken.size());
}

}  // namespace

TEST_CASE(
    "a recorder writes the frames that it has when it is closed, in their order, and takes none after") {
  const std::string path = sample::scratch_folder("recorder") + "/raw.mkv";
  const auto frames = sample::frames(kCamera, 6, 2);
  FramePool pool(8);
  std::atomic<int> written{0};
  Recorder recorder(value_of(create_recording(posix_storage(), path, kCamera)), pool.size(),
                    [&] { ++written; });
  for (const RawFrame& frame : frames) CHECK(recorder.put(holding(frame, pool)));
  recorder.close();
  CHECK_FALSE(recorder.put(holding(frames.front(), pool)));
  require_done(recorder.finish());
  CHECK(recorder.ended());
  CHECK(written == 6);
  CHECK(free_in(pool) == pool.size());
  const auto read = sample::replay(posix_storage(), path);
  CHECK_FALSE(read.error);
  CHECK(read.frames.size() == 6);
  CHECK(read.is_start_of(frames));
}

TEST_CASE("a recorder whose disk is full gives all frames back, later ones too, and keeps the error") {
  const std::string path = sample::scratch_folder("recorder_full") + "/raw.mkv";
  const auto frames = sample::frames(kCamera, 30, 2);
  FaultyStorage disk(posix_storage(), {.space_bytes = 20'000});
  FramePool pool(32);
  std::atomic<int> written{0};
  Recorder recorder(value_of(create_recording(disk, path, kCamera)), pool.size(), [&] { ++written; });
  for (const RawFrame& frame : frames) CHECK(recorder.put(holding(frame, pool)));
  REQUIRE(test::becomes_true([&] { return !recorder.outcome().ok(); }));
  require_error(recorder.outcome(), ErrorCode::NoSpace);
  CHECK(recorder.ended());
  CHECK(written < 30);
  CHECK(recorder.put(holding(frames.front(), pool)));  // as far as the caller can tell; the error says more
  CHECK(free_in(pool) == pool.size());
  require_error(recorder.finish(), ErrorCode::NoSpace);
}

TEST_CASE(
    "what the writer of a recording throws is thrown by the recorder, and the frames before it are whole") {
  const std::string path = sample::scratch_folder("recorder_without_memory") + "/raw.mkv";
  const auto frames = sample::frames(kCamera, 6, 2);
  FramePool pool(8);
  std::atomic<int> written{0};
  Recorder recorder(std::make_unique<test::WriterWithoutMemory>(
                        value_of(create_recording(posix_storage(), path, kCamera)), 4),
                    pool.size(), [&] { ++written; });
  for (const RawFrame& frame : frames) CHECK(recorder.put(holding(frame, pool)));
  REQUIRE(test::becomes_true([&] { return recorder.ended(); }));
  CHECK(recorder.failed());
  CHECK(written == 4);
  CHECK(recorder.put(holding(frames.front(), pool)));
  CHECK(free_in(pool) == pool.size());
  CHECK_THROWS_AS(recorder.outcome(), std::bad_alloc);
  CHECK_THROWS_AS(recorder.finish(), std::bad_alloc);
  const auto read = sample::replay(posix_storage(), path);
  CHECK_FALSE(read.error);
  CHECK(read.frames.size() == 4);
  CHECK(read.is_start_of(frames));
}

}  // namespace hdrcam
