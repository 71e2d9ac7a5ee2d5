#include "firmware_host/settings/start_time.h"

#include <filesystem>
#include <span>

#include "hal/storage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/ran_here.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the start of a run stands in the names of its files where they ask for it") {
  Settings settings;
  settings.record.file = "take-{start}.mkv";
  settings.output.paths["frames"] = "{start}/{start}-%06d.exr";
  settings.output.paths["report"] = "report.html";
  settings.output.http_takes = "takes-{start}/%03d.mkv";
  settings.machine.trace = "{start}.json";
  const Settings named = with_start_time(settings, std::chrono::system_clock::from_time_t(1795357805));
  CHECK(named.record.file == "take-20261122T143005Z.mkv");
  CHECK(named.output.path("frames") == "20261122T143005Z/20261122T143005Z-%06d.exr");
  CHECK(named.output.path("report") == "report.html");
  CHECK(named.output.http_takes == "takes-20261122T143005Z/%03d.mkv");
  CHECK(named.machine.trace == "20261122T143005Z.json");
}

TEST_CASE("a run on a recording or on its frames has its start in the names of its files, too") {
  const std::string folder = sample::scratch_folder("start_time"), file = folder + "/rig.toml";
  const auto write = [&](const char* name) {
    const std::string text = "[output]\nframes = \"" + folder + name + "\"\n";
    REQUIRE(write_whole(posix_storage(), file, std::as_bytes(std::span(text))).ok());
  };
  const auto names = [&] {
    std::string all;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      all += entry.path().filename().string() + " ";
    return all;
  };
  const auto done = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--config", file});
    const test::RanHere run = test::ran_here(words);
    INFO(run.err);
    CHECK(run.exit_code == 0);
  };
  const std::string demo = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";
  write("/replay-{start}/%06d.exr");
  done({"replay", demo, "--frames", "6", "--preset", "fast", "--emit", "state"});
  write("/render-{start}/%06d.exr");
  done({"render", demo, "--time", "0", "--preset", "fast", "--emit", "state"});
  write("/encode-{start}.mp4");
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().filename().string().starts_with("replay-"))
      done({"encode", entry.path().string() + "/%06d.exr"});
  CHECK(names().find("{start}") == std::string::npos);
  for (const char* verb : {"replay-20", "render-20", "encode-20"})
    CHECK(names().find(verb) != std::string::npos);
}

TEST_CASE("a file that a verb without settings of outputs writes has its start in its name, too") {
  const std::string folder = sample::scratch_folder("start_time_verbs");
  // The name of the file that starts so.
  const auto written = [&](const std::string& start) {
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().filename().string().starts_with(start)) return entry.path().string();
    return std::string("none");
  };
  const auto done = [&](const std::vector<std::string>& words) {
    const test::RanHere run = test::ran_here(words);
    INFO(run.err);
    CHECK(run.exit_code == 0);
  };
  done({"simulate", "walk?size=64x48", "--frames", "6", "-o", folder + "/simulate-{start}.mkv", "--truth",
        folder + "/truth-{start}"});
  done({"export", written("simulate-20"), "-o", folder + "/export-{start}"});
  done({"import", written("export-20"), "-o", folder + "/import-{start}.mkv"});
  done({"repair", written("simulate-20"), "-o", folder + "/repair-{start}.mkv"});
  done({"manual", "-o", folder + "/manual-{start}"});
  for (const char* file : {"truth-20", "import-20", "repair-20", "manual-20"}) CHECK(written(file) != "none");
}
