// The verb `compare` as a user meets it: the program, a clip on disk, what it prints and how it ends.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "firmware_host/exit_code.h"
#include "hal/storage.h"
#include "tests/places.h"
#include "tests/render/scores/synthetic_clip.h"
#include "tests/support/scratch_folder.h"

#include "tests/support/files.h"
#include "tests/support/ran.h"

namespace hdrcam {
namespace {

using test::Ran;

Ran run_compare(const std::string& arguments) { return test::ran("compare " + arguments); }

}  // namespace

TEST_CASE("hdrcam compare prints a table with units and writes the same figures as JSON") {
  synthetic_clip::TemporaryFolder clip;
  synthetic_clip::write_clip(clip.path());
  REQUIRE(posix_storage().make_directories(clip / "out").ok());
  for (int i = 0; i < synthetic_clip::kFrames; ++i)
    if (i != 5)
      synthetic_clip::write_estimate(clip / fmt::format("out/{:06d}.exr", i), i,
                                     synthetic_clip::Geometry::With);
  for (const int i : {20, 21, 40})
    synthetic_clip::write_estimate(clip / fmt::format("out/{:06d}.exr", i), 0,
                                   synthetic_clip::Geometry::With);

  const Ran run = run_compare(fmt::format("{0} {0}/out/ --label mine --json {0}/scores.json", clip.path()));
  INFO(run.output);
  REQUIRE(run.exit_code == 0);
  for (const char* word : {"mine", "PSNR-mu", "dB", "flicker", "stops", "depth abs-rel", "px",
                           "matched by their number: 1 to 4, 6\n", "no estimate: frames 5\n",
                           "the clip has no such frame: estimates 20 to 21, 40\n"})
    REQUIRE(run.output.find(word) != std::string::npos);
  const auto json = nlohmann::json::parse(read_whole(posix_storage(), clip / "scores.json").value());
  REQUIRE(json.at("label") == "mine");
  REQUIRE(json.at("clip") == std::filesystem::path(clip.path()).filename().string());
  REQUIRE(json.at("missing") == nlohmann::json{5});
  REQUIRE(json.at("not_in_clip") == nlohmann::json{20, 21, 40});
  REQUIRE(run.output.find(fmt::format("{:.2f}", json.at("psnr_mu").get<double>())) != std::string::npos);

  const Ran alone = run_compare(fmt::format("{0} {0}/out/ --label mine --json -", clip.path()));
  REQUIRE(alone.exit_code == 0);
  REQUIRE(nlohmann::json::parse(alone.output) == json);
}

TEST_CASE("hdrcam compare prints every figure that docs/compare.md explains") {
  const std::string clip = test::scratch_folder("compare_figures") + "/walk";
  REQUIRE(test::ran("simulate 'walk?size=64x48' --frames 6 --truth " + clip).exit_code == 0);
  const Ran run = run_compare(fmt::format("{0} {0}/gt/hdr", clip));
  REQUIRE(run.exit_code == 0);
  int explained = 0;
  std::istringstream page(test::text_of(HDRCAM_SOURCE_DIR "/docs/compare.md"));
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `")) continue;
    std::istringstream column(line.substr(0, line.find('|', 1)));
    std::string between, figure;
    for (; std::getline(column, between, '`') && std::getline(column, figure, '`'); ++explained)
      CHECK_THAT(run.output, Catch::Contains(figure));
  }
  CHECK(explained > 10);
}

TEST_CASE("hdrcam compare ends with a sentence and not with 0 where there is nothing to compare") {
  synthetic_clip::TemporaryFolder clip;
  synthetic_clip::write_clip(clip.path());
  const Ran no_frames = run_compare(fmt::format("{0} {0}/gt", clip.path()));
  REQUIRE(no_frames.exit_code == exit_code_of(ErrorCode::NotFound));
  REQUIRE(no_frames.output.find("no HDR frames") != std::string::npos);

  REQUIRE(posix_storage().make_directories(clip / "film").ok());
  for (const int i : {100, 103})
    synthetic_clip::write_estimate(clip / fmt::format("film/{}.exr", i), 0,
                                   synthetic_clip::Geometry::Without);
  const Ran apart = run_compare(fmt::format("{0} {0}/film", clip.path()));
  REQUIRE(apart.exit_code == exit_code_of(ErrorCode::NotFound));
  REQUIRE(apart.output.find("of numbers 0 to 7") != std::string::npos);
  REQUIRE(apart.output.find("100 to 103") != std::string::npos);

  const Ran swapped = run_compare(fmt::format("{0}/film {0}", clip.path()));
  REQUIRE(swapped.exit_code == exit_code_of(ErrorCode::NotFound));
  REQUIRE(swapped.output.find("name the clip with ground truth first") != std::string::npos);

  std::filesystem::remove_all(clip / "gt");
  const Ran no_truth = run_compare(fmt::format("{0} {0}", clip.path()));
  REQUIRE(no_truth.exit_code == exit_code_of(ErrorCode::NotFound));
  REQUIRE(no_truth.output.find("no ground truth") != std::string::npos);
}

}  // namespace hdrcam
