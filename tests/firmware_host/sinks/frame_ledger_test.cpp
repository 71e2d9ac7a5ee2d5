#include "firmware_host/sinks/frame_ledger.h"

#include <filesystem>

#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the list of an earlier run's frames stays until there is a frame to list") {
  const std::string folder = sample::scratch_folder("frame_ledger"), file = folder + "/frames.csv";
  const FramePattern frames = value_of(FramePattern::parse("--output", folder + "/%06d.exr", ".exr"));
  const auto written = [&] { return value_of(read_whole(posix_storage(), file)); };
  {
    FrameLedger earlier = value_of(FrameLedger::create(posix_storage(), frames));
    CHECK_FALSE(std::filesystem::exists(file));
    require_done(earlier.append({}, 0, "000007.exr"));
    CHECK(written().find("000007.exr") != std::string::npos);
  }
  { const FrameLedger without_frames = value_of(FrameLedger::create(posix_storage(), frames)); }
  CHECK(written().find("000007.exr") != std::string::npos);
  FrameLedger later = value_of(FrameLedger::create(posix_storage(), frames));
  require_done(later.append({}, 0, "000008.exr"));
  CHECK(written().find("000007.exr") == std::string::npos);
  require_done(later.append({}, 0, "000009.exr"));
  CHECK(written().find("000009.exr") != std::string::npos);
  CHECK(sample::unfinished_files_in(folder) == 0);
}

TEST_CASE("takes in one folder have a list each, named as their frames are") {
  const auto list_of = [](const char* frames) {
    return FrameLedger::path_beside(value_of(FramePattern::parse("--output", frames, ".exr")));
  };
  CHECK(list_of("out/a_%04d.exr") == "out/a_frames.csv");
  CHECK(list_of("out/%04d_b.exr") == "out/frames.csv");
  CHECK(list_of("%06d.exr") == "./frames.csv");
}

TEST_CASE("a name with a comma or a quotation mark is one cell of the list") {
  const std::string folder = sample::scratch_folder("frame_ledger_comma");
  const FramePattern frames = value_of(FramePattern::parse("--output", folder + "/%06d.exr", ".exr"));
  FrameLedger ledger = value_of(FrameLedger::create(posix_storage(), frames));
  require_done(ledger.append({}, 0, "a,\"b\"000007.exr"));
  const std::string written = value_of(read_whole(posix_storage(), folder + "/frames.csv"));
  CHECK(written.ends_with(",\"a,\"\"b\"\"000007.exr\"\n"));
}
