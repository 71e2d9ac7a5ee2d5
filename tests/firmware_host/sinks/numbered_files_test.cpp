// Sinks of one file per frame: previews, depth, motion.
#include "firmware_host/sinks/numbered_files.h"

#include <filesystem>
#include <string>

#include "firmware_host/sinks/preview.h"
#include "firmware_host/sinks/scene_files/depth_pictures.h"
#include "firmware_host/sinks/scene_files/flow_files.h"
#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using sample::scratch_folder;
using test::emit;
using test::example_frame;
using test::With;

namespace {

struct Kind {
  const char* extension;
  Result<std::unique_ptr<FrameSink>> (*create)(const std::string& pattern);
};
constexpr Kind kKinds[] = {
    {".png", [](const std::string& pattern) { return create_preview(posix_storage(), pattern); }},
    {".png", [](const std::string& pattern) { return create_depth_pictures(posix_storage(), pattern); }},
    {".flo",
     [](const std::string& pattern) {
       return create_flow_files(posix_storage(), "--flow-backward", pattern, &HdrFrame::flow);
     }},
};

std::string content(const std::string& path) { return read_whole(posix_storage(), path).value(); }

}  // namespace

TEST_CASE("of two runs that begin together with the same names of pictures the later one writes none") {
  for (const Kind& kind : kKinds) {
    const std::string folder = scratch_folder("numbered-two-runs"), names = folder + "/%03d" + kind.extension;
    for (const std::uint64_t number : {41U, 43U}) {  // the same as that of the first, and another
      const auto file = [&](const char* name) { return folder + name + kind.extension; };
      const auto first = kind.create(names).value();
      auto second = kind.create(names).value();
      REQUIRE(emit(*first, example_frame(41, With::DepthAndFlow)).ok());
      const std::string written = content(file("/041"));
      HdrFrame other = example_frame(number, With::DepthAndFlow, 12, 16);
      const Result<void> late = emit(*second, other);
      REQUIRE_FALSE(late.ok());
      CHECK(late.error().code == ErrorCode::Exists);
      CHECK_THAT(late.error().message, Contains(file("/041")) && Contains(names));
      CHECK(content(file("/041")) == written);
      CHECK_FALSE(std::filesystem::exists(file("/043")));
      second.reset();
      CHECK(sample::unfinished_files_in(folder) == 0);
      REQUIRE(emit(*first, example_frame(42, With::DepthAndFlow)).ok());
      std::filesystem::remove(file("/041")), std::filesystem::remove(file("/042"));
    }
  }
}

TEST_CASE("pictures of an earlier run that may be replaced are, by a run that began after them") {
  const std::string folder = scratch_folder("numbered-later"), names = folder + "/%03d.png";
  REQUIRE(emit(*create_preview(posix_storage(), names).value(), example_frame(41)).ok());
  const std::string earlier = content(folder + "/041.png");
  const auto later = create_preview(posix_storage(), names).value();
  REQUIRE(emit(*later, example_frame(41, With::RadianceOnly, 12, 16)).ok());
  REQUIRE(emit(*later, example_frame(42, With::RadianceOnly, 12, 16)).ok());
  CHECK(content(folder + "/041.png") != earlier);
  CHECK(sample::unfinished_files_in(folder) == 0);
}
