#include "firmware_host/sinks/earlier_frames.h"

#include <filesystem>
#include <fstream>

#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/as_nobody.h"

using namespace hdrcam;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

void put(const std::string& path) { std::ofstream(path) << path; }

}  // namespace

TEST_CASE("the frames of an earlier run are counted, with any number of digits, and the first is named") {
  const std::string folder = sample::scratch_folder("earlier_frames");
  for (const char* name : {"/000002.exr", "/000001.exr", "/0003.exr", "/poster.exr", "/000001.png"})
    put(folder + name);
  const EarlierFrames earlier(posix_storage(), folder + "/%06d.exr");
  CHECK(earlier.count() == 3);
  CHECK(earlier.first() == folder + "/000001.exr");
}

TEST_CASE("where there is no folder, or no pattern of frames, there are no earlier frames") {
  const std::string folder = sample::scratch_folder("earlier_frames_none");
  put(folder + "/000001.exr");
  for (const std::string& pattern : {folder + "/none/%06d.exr", folder + "/walk.mp4", std::string("-")}) {
    INFO(pattern);
    const EarlierFrames earlier(posix_storage(), pattern);
    CHECK(earlier.count() == 0);
    CHECK(earlier.warning().empty());
  }
}

TEST_CASE("what is in a folder that may be written to but not listed is not known, and the warning says so") {
  const std::string folder = sample::scratch_folder("earlier_frames_closed");
  put(folder + "/000001.exr");
  fs::permissions(folder, fs::perms(0333));
  {
    const test::AsNobody nobody;
    const EarlierFrames earlier(posix_storage(), folder + "/%06d.exr");
    REQUIRE_FALSE(earlier.listed().ok());
    CHECK(earlier.listed().error().code == ErrorCode::Permission);
    CHECK_THAT(earlier.warning(), Contains("cannot read the folder '" + folder + "'") &&
                                      Contains("earlier run remain there is not known"));
  }
  fs::permissions(folder, fs::perms::owner_all);
  CHECK(EarlierFrames(posix_storage(), folder + "/%06d.exr").listed().ok());
  CHECK(EarlierFrames(posix_storage(), folder + "/none/%06d.exr").listed().ok());
  CHECK(EarlierFrames(posix_storage(), folder + "/000001.exr/%06d.exr").listed().ok());
}

TEST_CASE("files that the run replaced or that are gone are no remains, the others are named") {
  const std::string folder = sample::scratch_folder("earlier_frames_left");
  for (const char* name : {"/000001.exr", "/000002.exr", "/000003.exr", "/0004.exr"}) put(folder + name);
  const EarlierFrames earlier(posix_storage(), folder + "/%06d.exr");
  put(folder + "/new"), fs::rename(folder + "/new", folder + "/000001.exr");
  fs::remove(folder + "/000002.exr");
  CHECK_THAT(earlier.warning(),
             Contains("2 files of an earlier run remain") &&
                 Contains("from '" + folder + "/000003.exr' to '" + folder + "/0004.exr'"));
  put(folder + "/000005.exr");
  for (const char* name : {"/000001.exr", "/000002.exr", "/000005.exr"})
    CHECK_FALSE(earlier.remains(folder + name));
  for (const char* name : {"/000003.exr", "/0004.exr"}) CHECK(earlier.remains(folder + name));
}

TEST_CASE("a run that wrote no frame has none that earlier ones could be mixed with") {
  const std::string folder = sample::scratch_folder("earlier_frames_alone");
  for (const char* name : {"/000001.exr", "/000002.exr"}) put(folder + name);
  const EarlierFrames earlier(posix_storage(), folder + "/%06d.exr");
  put(folder + "/000003.png");
  CHECK(earlier.warning().empty());
  put(folder + "/000003.exr");
  CHECK_THAT(earlier.warning(), Contains("2 files of an earlier run remain beside the new ones"));
}
