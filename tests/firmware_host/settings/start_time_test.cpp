#include "firmware_host/settings/start_time.h"

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
