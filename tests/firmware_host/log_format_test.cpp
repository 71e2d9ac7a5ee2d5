#include "firmware_host/log_format.h"

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "hal/storage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/trace_reading.h"

#include "tests/contracts/expect.h"

using namespace hdrcam;
using nlohmann::json;

namespace {

std::vector<json> objects_in(const std::string& text) {
  std::vector<json> objects;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    INFO(line);
    const json object = json::parse(line, nullptr, false);
    REQUIRE(object.is_object());
    objects.push_back(object);
  }
  return objects;
}

// The objects on the standard error stream of the program as installed, and its exit code.
std::pair<std::vector<json>, int> log_of(const std::string& words) {
  const std::string file = sample::scratch_folder("log") + "/stderr";
  const int status = std::system(("'" HDRCAM_BINARY "' " + words + " >/dev/null 2>" + file).c_str());
  return {objects_in(value_of(read_whole(posix_storage(), file))), WEXITSTATUS(status)};
}

}  // namespace

TEST_CASE("a line of the log is one object, whatever it says") {
  for (const std::string& message : {std::string("plain"), std::string("two\nlines \"quoted\" \x1b[31m"),
                                     std::string("no UTF-8: \xff\xfe")}) {
    const std::string line = json_log_line(LogLevel::Warning, message);
    CHECK(std::count(line.begin(), line.end(), '\n') == 1);
    CHECK(line.back() == '\n');
    const json object = json::parse(line);
    CHECK(object["level"] == "warning");
    CHECK(std::regex_match(object["time"].get<std::string>(),
                           std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z)")));
  }
  CHECK(json::parse(json_log_line(LogLevel::Note, "a \"b\""))["message"] == "a \"b\"");
}

TEST_CASE("remarks become one object a line, at the level that their first word names") {
  const auto objects = objects_in(json_log_lines("note: one\nwarning: two\nthree\n\n"));
  REQUIRE(objects.size() == 3);
  CHECK(objects[0]["level"] == "note");
  CHECK(objects[0]["message"] == "one");
  CHECK(objects[1]["level"] == "warning");
  CHECK(objects[1]["message"] == "two");
  CHECK(objects[2]["level"] == "note");
  CHECK(objects[2]["message"] == "three");
}

TEST_CASE("with --log-format json every line of a run is an object, and so is an error") {
  const std::string folder = sample::scratch_folder("log_run");
  const auto [objects, code] = log_of(
      "live --camera 'sim:still?size=64x48&fps=60' --format RGB24 --shutter 1ms,4ms --preset fast "
      "--emit state --frames 30 --http 127.0.0.1:0 --log-format json --trace " +
      folder + "/trace.json --record " + folder + "/raw.mkv");
  CHECK(code == 0);
  std::set<std::string> levels;
  bool view = false;
  for (const json& object : objects) {
    levels.insert(object["level"].get<std::string>());
    view |= object["message"].get<std::string>().starts_with("live view: http://127.0.0.1:");
  }
  CHECK(levels.contains("status"));
  CHECK(view);
  CHECK_FALSE(levels.contains("error"));
  for (const std::string words :
       {"replay --log-format json /nowhere.mkv -o /tmp/x.mp4", "replay --log-format=json --no-such-flag"}) {
    const auto [lines, failed] = log_of(words);
    CHECK(failed != 0);
    REQUIRE(lines.size() == 1);
    CHECK(lines[0]["level"] == "error");
  }
}

TEST_CASE(
    "the trace of a run on a camera has all its threads by name, and stages that nest in their frames") {
  const std::string folder = sample::scratch_folder("trace_run");
  const auto [objects, code] = log_of(
      "live --camera 'sim:still?size=64x48&fps=60' --format RGB24 --shutter 1ms,4ms --preset fast --deadline "
      "off "
      "--frames 30 --log-format json --trace " +
      folder + "/trace.json --record " + folder + "/raw.mkv -o " + folder + "/%06d.exr");
  REQUIRE(code == 0);
  const test::ReadTrace trace(value_of(read_whole(posix_storage(), folder + "/trace.json")));
  CHECK(trace.threads() == std::set<std::string>{"capture", "fit", "recorder", "sink frames"});
  for (const std::string& crossing : trace.crossings()) FAIL_CHECK(crossing);
  const auto stages = trace.names_on("fit");
  for (const char* stage : {"frame", "motion", "state", "fit", "deliver"}) {
    INFO(stage);
    CHECK(stages.contains(stage));
  }
  CHECK(trace.names_on("capture") == std::set<std::string>{"capture"});
  CHECK(trace.names_on("recorder") == std::set<std::string>{"record"});
}
