#include "firmware_host/live/takes.h"

#include <filesystem>
#include <fstream>

#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"

namespace hdrcam {
namespace {

TEST_CASE(
    "each take is a new file with the next number that none has, and each is told with its own frames") {
  const std::string folder = sample::scratch_folder("takes_alone");
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/02.mkv") << "an earlier take";
  Takes takes(posix_storage(), value_of(FramePattern::parse("--http-record", folder + "/%02d.mkv", ".mkv")),
              RecordingCodec::Huffyuv);
  CHECK(takes.account(0).empty());

  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 32, 24);
  const Takes::Created first = value_of(takes.create(camera));
  takes.started(first.path, 0);
  const Takes::Created second = value_of(takes.create(camera));
  takes.started(second.path, 5);
  CHECK(first.path == folder + "/01.mkv");
  CHECK(second.path == folder + "/03.mkv");
  CHECK(takes.account(6) == first.path + ": 5 frames\n" + second.path + ": 1 frame\n");
  const Error full{ErrorCode::NoSpace, "the disk is full"};
  CHECK(takes.cut(full, 6).message.starts_with("the disk is full; '" + second.path +
                                               "' is cut after 1 frame,"));
  CHECK(takes.cut(full, 5).message == full.message);  // it has none
  const Error removed{ErrorCode::NotFound, "the take was removed"};
  CHECK(takes.cut(removed, 6).message == removed.message);  // nothing is left to repair
}

TEST_CASE("a take that was not begun leaves no file, and its number is the next one's") {
  const std::string folder = sample::scratch_folder("takes_discarded");
  Takes takes(posix_storage(), value_of(FramePattern::parse("--http-record", folder + "/%02d.mkv", ".mkv")),
              RecordingCodec::Huffyuv);
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 32, 24);
  const std::string path = value_of(takes.create(camera)).path;
  CHECK(std::filesystem::exists(path));
  takes.discard(path);
  CHECK_FALSE(std::filesystem::exists(path));
  CHECK(takes.account(0).empty());
  CHECK(value_of(takes.create(camera)).path == path);
}

}  // namespace
}  // namespace hdrcam
