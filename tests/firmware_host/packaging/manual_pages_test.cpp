#include "firmware_host/packaging/manual_pages.h"

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "firmware_host/program.h"
#include "firmware_host/version.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

CommandTable product() {
  const std::vector<const char*> args{"list"};
  return command_table(*parse_command_line(args).value().app);
}

// A page's text without the escapes of roff.
std::string plain(const std::string& roff) {
  std::string text;
  for (std::size_t i = 0; i < roff.size(); ++i) {
    if (roff.compare(i, 2, "\\-") == 0) continue;
    text += roff[i];
    if (i > 0 && roff.compare(i - 1, 2, "\\-") == 0) text.back() = '-';
  }
  return text;
}

}  // namespace

TEST_CASE("there is a manual page for the program and for every verb, and each names every flag") {
  const CommandTable table = product();
  const std::vector<ManualPage> pages = manual_pages(table);
  REQUIRE(pages.size() == table.verbs.size() + 1);
  CHECK(pages.front().name == "hdrcam.1");
  for (std::size_t i = 0; i < table.verbs.size(); ++i) {
    const VerbEntry& verb = table.verbs[i];
    const std::string text = plain(pages[i + 1].roff);
    CHECK(pages[i + 1].name == "hdrcam-" + verb.name + ".1");
    CHECK_THAT(plain(pages.front().roff), Contains("hdrcam " + verb.name) && Contains(verb.about));
    CHECK_THAT(text, Contains(verb.example));
    REQUIRE_FALSE(verb.flags.empty());
    for (const FlagEntry& flag : verb.flags)
      for (const std::string& name : flag.names) CHECK_THAT(text, Contains("\\fB" + name + "\\fR"));
  }
}

TEST_CASE("the manual page of a verb groups its flags as --help does") {
  const std::vector<ManualPage> pages = manual_pages(product());
  const std::string& replay = pages[1].roff;
  REQUIRE(pages[1].name == "hdrcam-replay.1");
  CHECK(replay.find(".SH OPTIONS") < replay.find(".SS Fit"));
  CHECK(replay.find(".SS Fit") < replay.find("\\-\\-preset"));
  CHECK(replay.find("\\-\\-preset") < replay.find(".SS Output"));
  CHECK_THAT(replay, Contains("quality against time; realtime has no field (realtime, fast, balanced or "
                              "best); default balanced"));
}

TEST_CASE(
    "a verb's own verbs stand before its flags on its manual page, and what one of them takes is optional") {
  const std::vector<ManualPage> pages = manual_pages(product());
  const auto bench = std::ranges::find(pages, "hdrcam-bench.1", &ManualPage::name);
  REQUIRE(bench != pages.end());
  CHECK_THAT(bench->roff, Contains("\\fBhdrcam bench\\fR \\fIwhat\\fR [\\fIflags\\fR] [\\fICLIP\\fR ...]\n"));
}

TEST_CASE("an argument that may be repeated is followed by dots in the synopsis, and no other is") {
  const std::vector<ManualPage> pages = manual_pages(product());
  const auto page = [&](const char* name) { return std::ranges::find(pages, name, &ManualPage::name)->roff; };
  CHECK_THAT(page("hdrcam-import.1"),
             Contains("\\fBhdrcam import\\fR [\\fIflags\\fR] \\fIfootage\\fR ...\n"));
  CHECK_THAT(page("hdrcam-info.1"), Contains("\\fBhdrcam info\\fR [\\fIflags\\fR] \\fIrecording\\fR\n"));
}

TEST_CASE("what roff would read as a request or an escape is text on a manual page") {
  FlagEntry flag;
  flag.names = {"--as-is"}, flag.about = "'quoted' at the start";
  VerbEntry verb;
  verb.name = "dig", verb.about = ".hidden \\paths", verb.example = "hdrcam dig", verb.flags = {flag};
  const std::string page = manual_pages({"about", {}, {verb}})[1].roff;
  CHECK_THAT(page, Contains("\\- \\&.hidden \\epaths\n"));
  CHECK_THAT(page, Contains("\n\\fB\\-\\-as\\-is\\fR\n\\&'quoted' at the start\n"));
}

TEST_CASE("the changelog of the package begins with this version and its day") {
  std::ifstream file(HDRCAM_SOURCE_DIR "/firmware_host/packaging/deb/changelog");
  std::string first, line, signature;
  REQUIRE(std::getline(file, first));
  while (signature.empty() && std::getline(file, line))
    if (line.starts_with(" -- ")) signature = line;
  CHECK(first.starts_with(std::string("hdrcam (") + kVersion + ")"));
  std::tm day{};
  std::istringstream(kReleased) >> std::get_time(&day, "%Y-%m-%d");
  std::ostringstream written;
  written << std::put_time(&day, "%d %b %Y");
  CHECK_THAT(signature, Contains(written.str()));
}
