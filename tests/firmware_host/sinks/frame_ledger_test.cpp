#include "firmware_host/sinks/frame_ledger.h"

#include <filesystem>

#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the list of an earlier run's frames stays until there is a frame to list") {
  const std::string folder = sample::scratch_folder("frame_ledger"), file = folder + "/frames.csv";
  const auto written = [&] { return value_of(read_whole(posix_storage(), file)); };
  {
    FrameLedger earlier = value_of(FrameLedger::create(posix_storage(), folder));
    CHECK_FALSE(std::filesystem::exists(file));
    require_done(earlier.append({}, 0, "000007.exr"));
    CHECK(written().find("000007.exr") != std::string::npos);
  }
  { const FrameLedger without_frames = value_of(FrameLedger::create(posix_storage(), folder)); }
  CHECK(written().find("000007.exr") != std::string::npos);
  FrameLedger later = value_of(FrameLedger::create(posix_storage(), folder));
  require_done(later.append({}, 0, "000008.exr"));
  CHECK(written().find("000007.exr") == std::string::npos);
  require_done(later.append({}, 0, "000009.exr"));
  CHECK(written().find("000009.exr") != std::string::npos);
  CHECK(sample::unfinished_files_in(folder) == 0);
}
