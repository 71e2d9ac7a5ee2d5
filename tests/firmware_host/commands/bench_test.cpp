// The verb `bench` as a user meets it, on a small clip that the simulator films.
#include <atomic>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "firmware_host/bench/cost_page.h"
#include "firmware_host/bench/kernel_rates.h"
#include "firmware_host/exit_code.h"
#include "hal/storage.h"
#include "tests/contracts/expect.h"
#include "tests/places.h"
#include "tests/render/scores/synthetic_clip.h"
#include "tests/support/ran_here.h"
#include "tests/support/stopping_storage.h"

#include "tests/support/ran.h"

using hdrcam::test::Ran;
using hdrcam::test::ran;

namespace hdrcam {
namespace {

PointCost point(const char* name, double ms, double db) {
  PointCost cost;
  cost.point = name, cost.group = "preset", cost.clip = "walk";
  cost.mean_ms = ms, cost.psnr_mu_db = db;
  return cost;
}

}  // namespace

TEST_CASE(
    "hdrcam bench pareto measures every point on every clip, and leaves figures, charts and no frames") {
  synthetic_clip::TemporaryFolder work;
  const Ran filmed = ran(
      {"simulate", "walk?size=96x64", "--frames", "10", "-o", work / "walk.mkv", "--truth", work / "walk"});
  INFO(filmed.output);
  REQUIRE(filmed.exit_code == 0);
  const Ran bench = ran({"bench", "pareto", work / "walk", "-o", work / "cost", "--point", "fast", "--point",
                         "look-ahead 0", "--point", "balanced"});
  INFO(bench.output);
  REQUIRE(bench.exit_code == 0);
  const auto json = nlohmann::json::parse(read_whole(posix_storage(), work / "cost/pareto.json").value());
  REQUIRE(json.at("points").size() == 3);
  for (const auto& point : json.at("points")) {
    CHECK(point.at("clip") == "walk");
    CHECK(point.at("frames") == 10);
    CHECK(point.at("ms_per_frame") > 0);
    CHECK(point.at("psnr_mu") > 10);
  }
  // the command repeats the walk
  CHECK(json.at("command").get<std::string>().find("--output " + (work / "cost") +
                                                   " --point fast --point 'look-ahead 0' --point balanced") !=
        std::string::npos);
  // another knob is another picture, and the look-ahead is worth its time
  const auto db = [&](std::size_t i) { return json.at("points").at(i).at("psnr_mu").get<double>(); };
  CHECK(db(1) < db(2));
  const std::string page = read_whole(posix_storage(), work / "cost/pareto.html").value();
  CHECK(page.find("look-ahead 0</text>") != std::string::npos);
  CHECK(bench.output.find("| balanced |") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(work / "cost/frames"));
}

TEST_CASE(
    "hdrcam bench pareto refuses an invalid clip before it measures, and keeps what it measured before "
    "another fault") {
  synthetic_clip::TemporaryFolder work;
  REQUIRE(ran({"simulate", "walk?size=96x64", "--frames", "10", "--truth", work / "walk"}).exit_code == 0);
  const auto walk_with = [&](const std::string& clip, const std::string& folder) {
    const Ran bench =
        ran({"bench", "pareto", work / "walk", work / clip, "-o", work / folder, "--point", "fast"});
    INFO(bench.output);
    CHECK(bench.exit_code == exit_code_of(ErrorCode::NotFound));
    return bench.output;
  };
  CHECK(walk_with("none", "none_cost").find("ms a frame") == std::string::npos);
  std::filesystem::copy(work / "walk", work / "blind", std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(work / "blind/gt");
  CHECK(walk_with("blind", "blind_cost").find("ground truth") != std::string::npos);
  const auto json =
      nlohmann::json::parse(read_whole(posix_storage(), work / "blind_cost/pareto.json").value());
  REQUIRE(json.at("points").size() == 1);
  CHECK(json.at("points").at(0).at("clip") == "walk");
}

TEST_CASE("hdrcam bench pareto measures the same whatever outputs a file of settings names") {
  synthetic_clip::TemporaryFolder work;
  REQUIRE(ran({"simulate", "walk?size=96x64", "--frames", "10", "--truth", work / "walk"}).exit_code == 0);
  const std::string trace = work / "trace.json",
                    text =
                        "[output]\nlayers = \"depth\"\nwhite_balance = \"2,1,1.5\"\n[machine]\ntrace = \"" +
                        trace + "\"\n";
  REQUIRE(write_whole(posix_storage(), work / "rig.toml", std::as_bytes(std::span(text))).ok());
  const auto psnr = [&](const char* folder, const std::vector<std::string>& more) {
    std::vector<std::string> words{"bench", "pareto", work / "walk", "-o", work / folder, "--point", "fast"};
    words.insert(words.end(), more.begin(), more.end());
    const Ran bench = ran(words);
    INFO(bench.output);
    REQUIRE(bench.exit_code == 0);
    const std::string json = read_whole(posix_storage(), work / folder + "/pareto.json").value();
    return nlohmann::json::parse(json).at("points").at(0).at("psnr_mu").get<double>();
  };
  const double plain = psnr("plain", {});
  CHECK(psnr("filed", {"--config", work / "rig.toml"}) == plain);
  CHECK_FALSE(std::filesystem::exists(trace));
  const std::string page = read_whole(posix_storage(), work / "filed/pareto.json").value();
  CHECK(page.find("--trace") == std::string::npos);  // of the command that made it
  const Ran flagged = ran({"bench", "pareto", work / "walk", "-o", work / "flagged", "--trace", trace});
  CHECK(flagged.exit_code == exit_code_of(ErrorCode::Invalid));
  CHECK(flagged.output.find("unknown flag '--trace' (a flag of ") != std::string::npos);
}

TEST_CASE("hdrcam bench kernels measures each kernel and the ceilings, as a table and as JSON") {
  synthetic_clip::TemporaryFolder work;
  const Ran bench = ran({"bench", "kernels", "--width", "128", "--height", "96", "--seconds", "0.002",
                         "--json", work / "kernels.json"});
  INFO(bench.output);
  REQUIRE(bench.exit_code == 0);
  const auto json = nlohmann::json::parse(read_whole(posix_storage(), work / "kernels.json").value());
  CHECK(json.at("flops_per_s") > 1e8);
  CHECK(json.at("look_ups_per_s") > 1e6);
  CHECK(json.at("kernels").size() == kernel_tasks(96, 128).size());
  for (const auto& kernel : json.at("kernels")) {
    INFO(kernel.at("kernel"));
    CHECK(kernel.at("per_s") > 0);
    if (kernel.contains("bound")) CHECK(kernel.at("ceiling_per_s") > 0);
    CHECK(bench.output.find("| " + kernel.at("kernel").get<std::string>() + " |") != std::string::npos);
  }
}

TEST_CASE("the page of what accuracy costs has every kernel that is measured") {
  const std::string page =
      value_of(read_whole(posix_storage(), HDRCAM_SOURCE_DIR "/docs/cost-of-accuracy.md"));
  for (const KernelTask& task : kernel_tasks(96, 128)) {
    INFO(task.name);
    CHECK((page.find("| " + task.name + " |") != std::string::npos ||
           page.find("`" + task.name + "`") != std::string::npos));
  }
}

TEST_CASE("a kernel's bytes are those of the planes that it reads and writes") {
  const std::map<std::string, int> planes = {
      {"fusion: stand-ins", 4},           // three read, one written
      {"fusion: variance of a warp", 3},  // a flow read, one written
      {"fusion: ageing", 8},              // seven read, one written
      {"flow: rating", 5},                // two flows read, one written
      {"motion of the next step", 8}};    // two flows, two shares; a flow
  std::size_t found = 0;
  for (const KernelTask& task : kernel_tasks(96, 128)) {
    const auto counted = planes.find(task.name);
    if (counted == planes.end()) continue;
    INFO(task.name);
    CHECK(task.bytes == 4.0 * counted->second);
    ++found;
  }
  CHECK(found == planes.size());
}

TEST_CASE("the ceiling of a kernel is the resource that it exhausts first") {
  int runs = 0;
  const auto task = [&](const char* name, double flops, double bytes, double look_ups) {
    return KernelTask{name, "px", 10, flops, bytes, look_ups, 4096, [&] { ++runs; }};
  };
  const KernelTask tasks[] = {task("counted by flops", 1e9, 1, 1), task("by bytes", 1, 1e9, 1),
                              task("by look-ups", 1, 1, 1e9), task("not at all", 0, 0, 0)};
  const std::atomic<bool> stop{false};
  const KernelRates rates = measure_kernels(tasks, 1e-4, stop).value();
  REQUIRE(rates.kernels.size() == 4);
  CHECK(runs >= 4 * 6);
  CHECK(rates.kernels[0].bound == KernelBound::Arithmetic);
  CHECK(rates.kernels[0].ceiling_per_s == Approx(rates.flops_per_s / 1e9));
  CHECK(rates.kernels[1].bound == KernelBound::Memory);
  CHECK(rates.kernels[2].bound == KernelBound::LookUps);
  CHECK(rates.kernels[2].ceiling_per_s == Approx(rates.look_ups_per_s / 1e9));
  CHECK(rates.kernels[3].bound == KernelBound::Unknown);
  CHECK(rates.kernels[3].ceiling_per_s == 0);
  const std::string table = rates_table(rates);
  CHECK(table.find("| memory |") != std::string::npos);
  CHECK(table.find("| not at all |") != std::string::npos);
}

TEST_CASE("the kernels that are told to stop end within one run, and give no rates") {
  std::atomic<bool> stop{false};
  int runs = 0, runs_after = 0;
  const KernelTask tasks[] = {{"first", "px", 10, 0, 0, 0, 4096, [&] { stop = stop || ++runs == 2; }},
                              {"second", "px", 10, 0, 0, 0, 4096, [&] { ++runs_after; }}};
  const auto rates = measure_kernels(tasks, 1e-3, stop);
  REQUIRE_FALSE(rates.ok());
  CHECK(rates.error().code == ErrorCode::Interrupted);
  CHECK(runs == 2);
  CHECK(runs_after == 0);
}

TEST_CASE("hdrcam bench kernels takes a number of seconds") {
  for (const char* seconds : {"nan", "0", "61", "inf"}) {
    const Ran refused = ran({"bench", "kernels", "--seconds", seconds});
    INFO(refused.output);
    CHECK(refused.exit_code == exit_code_of(ErrorCode::Invalid));
    CHECK(refused.output.find("takes seconds, 0.001 to 60") != std::string::npos);
  }
}

TEST_CASE("hdrcam bench pareto that is told to stop keeps the points that are measured") {
  synthetic_clip::TemporaryFolder work;
  REQUIRE(ran({"simulate", "walk?size=64x48", "--frames", "8", "--truth", work / "walk"}).exit_code == 0);
  test::StoppingStorage storage(".exr", 8 + 2);  // in the second point
  const test::RanHere stopped =
      test::ran_here({"bench", "pareto", work / "walk", "-o", work / "cost", "--point", "fast", "--point",
                      "look-ahead 0", "--preset", "fast"},
                     storage, storage.stop());
  INFO(stopped.err);
  CHECK(stopped.exit_code == exit_code_of(ErrorCode::Interrupted));
  CHECK(stopped.err.find("stopped after 1 of 2 points; the pages hold these") != std::string::npos);
  const auto page = read_whole(posix_storage(), work / "cost/pareto.json");
  REQUIRE(page.ok());
  CHECK(nlohmann::json::parse(page.value()).at("points").size() == 1);
  CHECK_FALSE(std::filesystem::exists(work / "cost/frames"));
}

TEST_CASE("hdrcam bench pareto names what it cannot measure") {
  synthetic_clip::TemporaryFolder work;
  const Ran unknown = ran({"bench", "pareto", work.path(), "-o", work / "cost", "--point", "swift"});
  CHECK(unknown.exit_code == kExitUsage);
  CHECK(unknown.output.find("there is no point 'swift'; there are realtime, fast, balanced") !=
        std::string::npos);
  const Ran nothing = ran({"bench", "pareto", work / "none", "-o", work / "cost", "--point", "fast"});
  CHECK(nothing.exit_code == exit_code_of(ErrorCode::NotFound));
  CHECK(nothing.output.find("none/clip.json' does not exist") != std::string::npos);
}

TEST_CASE("hdrcam bench replaces no earlier measurement without --force, and no recording at all") {
  synthetic_clip::TemporaryFolder work;
  const std::string text = "an earlier one";
  REQUIRE(posix_storage().make_directories(work / "cost").ok());
  for (const char* file : {"cost/pareto.md", "take.mkv"})
    REQUIRE(write_whole(posix_storage(), work / file, std::as_bytes(std::span(text))).ok());
  const Ran again = ran({"bench", "pareto", work / "clip", "-o", work / "cost", "--point", "fast"});
  CHECK(again.exit_code == 17);
  CHECK(again.output.find("pareto.md") != std::string::npos);
  CHECK(ran({"bench", "kernels", "--seconds", "0.001", "--json", work / "take.mkv"}).exit_code == 2);
  for (const char* file : {"cost/pareto.md", "take.mkv"})
    CHECK(read_whole(posix_storage(), work / file).value() == text);
}

TEST_CASE("the front holds the points that no other undercuts at the same quality") {
  const std::vector<PointCost> points{point("a", 10, 30), point("b", 20, 29), point("c", 30, 31),
                                      point("d", 5, 20)};
  CHECK(on_the_front(points) == std::vector<bool>{true, false, true, true});
}

TEST_CASE("a point's mean is over its clips, and the table is in the order of time") {
  std::vector<PointCost> costs{point("slow", 40, 30), point("quick", 10, 28), point("slow", 20, 34),
                               point("quick", 20, 26)};
  costs[2].clip = costs[3].clip = "night";
  const std::vector<PointCost> means = means_of(costs);
  REQUIRE(means.size() == 2);
  CHECK(means[0].mean_ms == Approx(30));
  CHECK(means[0].psnr_mu_db == Approx(32));
  CHECK(means[1].mean_ms == Approx(15));
  const std::string table = cost_table(costs);
  CHECK(table.find("| quick |") < table.find("| slow |"));
}

TEST_CASE("a point of a clip without true motion has no flicker in the table") {
  std::vector<PointCost> costs{point("fast", 40, 30)};
  costs[0].flicker_stops = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(cost_table(costs), Catch::Contains("| fast | 40.0 | 0.0 | 30.00 | 0.00 | - | yes |"));
}

}  // namespace hdrcam
