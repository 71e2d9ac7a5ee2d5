// The scripts of a fleet, with programs of the test in place of hdrcam, Slurm and jq: which results count,
// and which files of an earlier job stay.
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/shell.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::Ran;
namespace fs = std::filesystem;

namespace {

// Of a program in place of hdrcam: it takes all flags that a fleet asks it about, and replaces no frames
// without --force.
constexpr const char* kTakesFlags =
    "[ \"$2\" != --print-config ] || exit 0\n[ \"$7\" = --force ] || exit 17\n";

// Two recordings, and programs that a fleet finds before those of the system.
class Fleet {
 public:
  explicit Fleet(const std::string& name) : place_(sample::scratch_folder(name)) {
    fs::create_directories(place_ + "/bin");
    for (const char* recording : {"/a.mkv", "/b.mkv"}) std::ofstream(place_ + recording) << recording;
    // replay RECORDING -o FOLDER/%06d.exr --stats FILE --force FRAMES
    program("hdrcam", std::string(kTakesFlags) +
                          "[ \"$8\" != none ] || { echo 'hdrcam: there is no frame.' >&2; exit 9; }\n"
                          "for i in $(seq \"$8\"); do echo \"$8\" >\"${4%/*}/00000$i.exr\"; done\n"
                          "echo file >\"${4%/*}/frames.csv\"; echo '{}' >\"$6\"");
    // -r --arg name NAME FILTER FILE
    program("jq", "cat \"$6\" >/dev/null && printf '%s\\t3\\t1\\t2\\n' \"$4\"");
  }

  void program(const std::string& name, const std::string& lines) const {
    test::write_program(place_ + "/bin/" + name, lines);
  }
  // flags: of run_fleet.sh; frames: what every job leaves.
  // before: what starts the script.
  Ran run(const std::string& flags, const std::string& frames, const std::string& before = "") const {
    return shell(
        fmt::format("run_fleet.sh {} -o {} {}/a.mkv {}/b.mkv -- {}", flags, out(), place_, place_, frames),
        before);
  }
  // to: the folder of the results, as a shell takes it.
  Ran run_to(const std::string& to, const std::string& flags) const {
    return shell(fmt::format("run_fleet.sh {} -o {} {}/a.mkv -- 3", flags, to, place_));
  }
  Ran run_on(const std::string& recording, const std::string& frames = " -- 3") const {
    return shell(fmt::format("run_fleet.sh --plain -o {} {}/{}{}", out(), place_, recording, frames));
  }
  Ran summary() const { return shell("summary.sh " + out()); }

  std::string out() const { return place_ + "/out"; }
  bool has(const std::string& file) const { return fs::exists(out() + "/" + file); }

 private:
  Ran shell(const std::string& line, const std::string& before = "") const {
    return test::shell(
        fmt::format("PATH={0}/bin:$PATH HDRCAM={0}/bin/hdrcam {3} '{1}/firmware_host/fleet/'{2}", place_,
                    HDRCAM_SOURCE_DIR, line, before));
  }

  const std::string place_;
};

constexpr const char* kOfAnother = "not run; what is there is of another recording, program or flags";

}  // namespace

TEST_CASE("a fleet passes on every flag of replay, also an empty value, and nothing where none is given") {
  const Fleet fleet("fleet_flags");
  fleet.program("hdrcam", std::string(kTakesFlags) + "echo \"$#\" >\"${4%/*}/words\"; echo '{}' >\"$6\"");
  const auto words = [&] {
    std::ifstream file(fleet.out() + "/a/words");
    int count = 0;
    file >> count;
    return count;
  };
  REQUIRE(fleet.run_on("a.mkv", "").exit_code == 0);
  const int without = words();
  REQUIRE(without > 0);
  REQUIRE(fleet.run_on("a.mkv", " -- --layers '' --readout ''").exit_code == 0);
  CHECK(words() == without + 4);
}

TEST_CASE("a fleet does each recording once, and anew under other flags, without frames of the job before") {
  const Fleet fleet("fleet_anew");
  const Ran first = fleet.run("--plain", "3");
  INFO(first.output);
  REQUIRE(first.exit_code == 0);
  CHECK(fleet.has("a/000003.exr"));
  std::ofstream(fleet.out() + "/a/mine.exr") << "of the user";
  CHECK_THAT(fleet.run("--plain", "3").output,
             Contains("a.mkv: done earlier") && Contains("b.mkv: done earlier"));

  const Ran fewer = fleet.run("--plain", "2");
  INFO(fewer.output);
  CHECK(fewer.exit_code == 0);
  CHECK_THAT(fewer.output, !Contains("done earlier"));
  CHECK(fleet.has("a/000002.exr"));
  CHECK_FALSE(fleet.has("a/000003.exr"));

  const Ran failed = fleet.run("--plain", "none");
  CHECK(failed.exit_code == 1);
  CHECK_THAT(failed.output, Contains("exit 9: hdrcam: there is no frame."));
  for (const char* file : {"a/000001.exr", "a/frames.csv", "a/stats.json"}) CHECK_FALSE(fleet.has(file));
  CHECK(fleet.has("a/mine.exr"));
}

TEST_CASE("flags that replay refuses end a fleet before a job deletes the frames of an earlier one") {
  const Fleet fleet("fleet_refused_flags");
  REQUIRE(fleet.run("--plain", "3").exit_code == 0);
  fleet.program("hdrcam", "echo \"hdrcam: --preset takes fast or best, not 'fats'.\" >&2; exit 2");
  const Ran refused = fleet.run("--plain", "3 --preset fats");
  INFO(refused.output);
  CHECK(refused.exit_code == 2);
  CHECK_THAT(refused.output, Contains("not 'fats'") && !Contains("ms/frame"));
  CHECK(fleet.has("a/000003.exr"));
}

TEST_CASE("flags that do not fit together leave the frames of an earlier job of a fleet") {
  const Fleet fleet("fleet_unfit_flags");
  REQUIRE(fleet.run("--plain", "3").exit_code == 0);
  fleet.program("hdrcam",
                "[ \"$2\" != --print-config ] || exit 0\n"
                "echo 'hdrcam: --emit field comes from the field.' >&2; exit 2");
  const Ran refused = fleet.run("--plain", "3 --emit field --set field=none");
  INFO(refused.output);
  CHECK(refused.exit_code == 1);
  CHECK_THAT(refused.output, Contains("exit 2: hdrcam: --emit field comes from the field."));
  for (const char* file : {"a/000003.exr", "a/frames.csv", "a/stats.json"}) CHECK(fleet.has(file));
}

TEST_CASE("a recording that is gone leaves what an earlier job of a fleet made of it") {
  const Fleet fleet("fleet_gone");
  REQUIRE(fleet.run("--plain", "3").exit_code == 0);
  fs::remove(fleet.out() + "/../a.mkv");
  const Ran gone = fleet.run("--plain", "3");
  INFO(gone.output);
  CHECK(gone.exit_code == 1);
  CHECK_THAT(gone.output, Contains("exit 3: hdrcam: '") && Contains("a.mkv' does not exist.") &&
                              Contains("b.mkv: done earlier"));
  for (const char* file : {"a/000003.exr", "a/stats.json"}) CHECK(fleet.has(file));
}

TEST_CASE("a fleet deletes no frames that none of its jobs wrote") {
  const Fleet fleet("fleet_foreign");
  const std::string taken = fleet.out() + "/a/000009.exr";
  fs::create_directories(fleet.out() + "/a");
  std::ofstream(taken) << "of the user";
  for (int i = 0; i < 2; ++i) {
    const Ran refused = fleet.run("--plain", "3");
    INFO(refused.output);
    CHECK(refused.exit_code == 1);
    CHECK_THAT(refused.output, Contains("exit 17: in ") && Contains("frames that no job of a fleet wrote"));
    CHECK(fs::exists(taken));
    CHECK_FALSE(fleet.has("a/000003.exr"));
    CHECK(fleet.has("b/000003.exr"));
  }
  fs::remove(taken);
  CHECK(fleet.run("--plain", "3").exit_code == 0);
  CHECK(fleet.has("a/000003.exr"));
}

TEST_CASE("a fleet's folder may have any name, also on a cluster") {
  const Fleet fleet("fleet_quotes");
  const std::string folder = fs::path(fleet.out()).parent_path().string() + "/it's here";
  fleet.program(
      "sbatch",
      "for word; do case $word in --wrap=*) SLURM_ARRAY_TASK_ID=0 sh -c \"${word#--wrap=}\" ;; esac; "
      "done; echo 'Submitted batch job 7'");
  for (const char* manner : {"", "--plain"}) {
    const Ran run = fleet.run_to('"' + folder + '"', manner);
    INFO(run.output);
    CHECK(run.exit_code == 0);
    CHECK(fs::exists(folder + "/a/000003.exr"));
    fs::remove_all(folder);
  }
}

TEST_CASE("a changed file that a flag names makes each job of a fleet new") {
  const Fleet fleet("fleet_config");
  const std::string config = sample::scratch_folder("fleet_settings") + "/rig.toml";
  for (const std::string& flag : {"--config " + config, "--config=" + config}) {
    INFO(flag);
    std::ofstream(config) << "[fit]\nseed = 1\n";
    REQUIRE(fleet.run("--plain", "3 " + flag).exit_code == 0);
    CHECK_THAT(fleet.run("--plain", "3 " + flag).output, Contains("b.mkv: done earlier"));
    std::ofstream(config) << "[fit]\nseed = 2\n";
    const Ran table = fleet.summary();
    CHECK(table.exit_code == 1);
    CHECK_THAT(table.output, Contains(kOfAnother));
    const Ran anew = fleet.run("--plain", "3 " + flag);
    CHECK(anew.exit_code == 0);
    CHECK_THAT(anew.output, !Contains("done earlier"));
  }
}

TEST_CASE("a changed folder that a flag names makes each job of a fleet new") {
  const Fleet fleet("fleet_truth");
  const std::string clip = sample::scratch_folder("fleet_clip");
  fs::create_directories(clip + "/gt");
  std::ofstream(clip + "/gt/0.exr") << "true";
  const auto runs_anew = [&](const std::string& flag) {
    const Ran anew = fleet.run("--plain", "3 " + flag);
    CHECK(anew.exit_code == 0);
    CHECK_THAT(anew.output, !Contains("done earlier"));
  };
  const auto changes = [&](const std::string& flag) {
    INFO(flag);
    CHECK_THAT(fleet.run("--plain", "3 " + flag).output,
               Contains("a.mkv: done earlier") && Contains("b.mkv: done earlier"));
    std::ofstream(clip + "/gt/0.exr", std::ios::app) << " and more";
    CHECK_THAT(fleet.summary().output, Contains(kOfAnother));
    runs_anew(flag);
    std::ofstream(clip + "/gt/" + fmt::format("{}.exr", fs::file_size(clip + "/gt/0.exr"))) << "another";
    runs_anew(flag);
  };
  for (const std::string& flag : {"--truth " + clip, "--truth=" + clip}) {
    REQUIRE(fleet.run("--plain", "3 " + flag).exit_code == 0);
    changes(flag);
  }
}

TEST_CASE("a result without figures is in the table as such, stops no other row, and is done again") {
  const Fleet fleet("fleet_figures");
  REQUIRE(fleet.run("--plain", "3").exit_code == 0);
  fs::remove(fleet.out() + "/a/stats.json");
  const Ran table = fleet.summary();
  INFO(table.output);
  CHECK(table.exit_code == 1);
  CHECK_THAT(table.output, Contains("no figures: its stats.json is gone or damaged"));
  CHECK_THAT(table.output, Contains("1.0      2.0  done"));  // b
  const Ran again = fleet.run("--plain", "3");
  CHECK(again.exit_code == 0);
  CHECK_THAT(again.output, !Contains("a.mkv: done earlier") && Contains("b.mkv: done earlier"));
}

TEST_CASE("a recording named as a list of the fleet is refused before anything is written") {
  for (const char* recording : {"flags.mkv", "recordings.mkv"}) {
    const Fleet fleet("fleet_names");
    const Ran refused = fleet.run_on(recording);
    INFO(refused.output);
    CHECK(refused.exit_code == 2);
    CHECK_THAT(refused.output, Contains("as is a list of the fleet") && Contains("rename it"));
    CHECK_FALSE(fs::exists(fleet.out()));
  }
}

TEST_CASE("a flag of the fleet with a missing or an invalid value is refused before anything is written") {
  const Fleet fleet("fleet_values");
  const Ran number = fleet.run("--plain --at-once many", "3");
  INFO(number.output);
  CHECK(number.exit_code == 2);
  CHECK_THAT(number.output, Contains("--at-once takes a number"));
  CHECK_FALSE(fs::exists(fleet.out()));
  const Ran nothing = fleet.run_on("a.mkv --at-once", "");
  INFO(nothing.output);
  CHECK(nothing.exit_code == 2);
  CHECK_THAT(nothing.output, Contains("--at-once needs a value"));
  CHECK_FALSE(fs::exists(fleet.out()));
}

TEST_CASE("a recording without an extension has a folder of its own, also where a dot is in its path") {
  const Fleet fleet("fleet_dots");
  const fs::path takes = fs::path(fleet.out()).parent_path() / "rig-1.2";
  fs::create_directories(takes);
  for (const char* take : {"first", "second"}) std::ofstream(takes / take) << take;
  const Ran run = fleet.run_on("rig-1.2/first " + (takes / "second").string());
  INFO(run.output);
  CHECK(run.exit_code == 0);
  CHECK(fleet.has("first/000003.exr"));
  CHECK(fleet.has("second/000003.exr"));
}

TEST_CASE("an array that Slurm does not take ends the fleet, and no earlier result counts as its own") {
  const Fleet fleet("fleet_refused");
  REQUIRE(fleet.run("--plain", "3").exit_code == 0);
  std::ofstream(fleet.out() + "/slurm-0.log") << "of an earlier array";
  fleet.program("sbatch", "echo 'sbatch: error: invalid partition' >&2; exit 1");
  const Ran refused = fleet.run("", "2");
  INFO(refused.output);
  CHECK(refused.exit_code == 1);
  CHECK_THAT(refused.output, Contains("sbatch failed with 1; no job was submitted") && !Contains("done"));
  CHECK_FALSE(fleet.has("slurm-0.log"));

  const Ran table = fleet.summary();
  INFO(table.output);
  CHECK(table.exit_code == 1);
  CHECK_THAT(table.output, Contains(kOfAnother) && !Contains("done"));
}

TEST_CASE("a job of an array that fails is in the table beside the others") {
  const Fleet fleet("fleet_array");
  REQUIRE(fleet.run("--plain", "3").exit_code == 0);
  std::ofstream(fleet.out() + "/../b.mkv") << "another recording";
  fleet.program("sbatch", "echo 'Submitted batch job 7'; exit 1");  // and b's job never starts
  const Ran run = fleet.run("", "3");
  INFO(run.output);
  CHECK(run.exit_code == 1);
  CHECK_THAT(run.output, Contains("Submitted batch job 7") && Contains("done") && Contains(kOfAnother));
}

TEST_CASE("a fleet on a cluster that is interrupted cancels its array") {
  const Fleet fleet("fleet_interrupted");
  // ^C goes to all programs of a terminal; the jobs of a cluster hear nothing of it. It comes once the number
  // of the array is in the log, which is in the folder of --output.
  fleet.program("sbatch",
                "trap 'exit 130' INT; echo 'Submitted batch job 7'; log=$(dirname \"${5#--output=}\"); "
                "until grep -q 7 \"$log/slurm-array.log\"; do sleep 0.05; done; kill -INT 0; exit 130");
  fleet.program("scancel", "echo \"cancelled $1\"");
  const Ran run = fleet.run("", "3", "env --default-signal=INT setsid --wait");
  INFO(run.output);
  CHECK(run.exit_code == 130);
  CHECK_THAT(run.output, Contains("cancelled 7") && Contains("run it again") && !Contains("recording "));
}
