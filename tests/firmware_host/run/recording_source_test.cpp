#include "firmware_host/run/recording_source.h"

#include <atomic>

#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"

namespace hdrcam {
namespace {

TEST_CASE("the copy of a recording is whole as far as it came, also where nobody finishes the run") {
  const std::string copy = sample::scratch_folder("recording_source") + "/copy.mkv";
  const std::atomic<bool> stop{false};
  {
    const auto source = value_of(RecordingSource::open(
        posix_storage(), HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", {.copy_to = copy}, stop));
    for (int i = 0; i < 3; ++i) REQUIRE(value_of(source->next()) != nullptr);
  }
  const auto reader = value_of(open_recording(posix_storage(), copy));
  CHECK(reader->frame_count() == 3);
}

TEST_CASE("a recording's source warns of frames that were left out to hold the deadline, and else of none") {
  const std::atomic<bool> stop{false};
  const auto source = value_of(
      RecordingSource::open(posix_storage(), HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", {.frames = 6}, stop));
  while (value_of(source->next()) != nullptr) {
  }
  CHECK(source->warnings().empty());
  source->left_out();
  source->left_out();
  REQUIRE(source->warnings().size() == 1);
  CHECK(source->warnings().front() ==
        "2 of 6 frames were left out to hold the deadline; give a longer --deadline, or none");
}

}  // namespace
}  // namespace hdrcam
