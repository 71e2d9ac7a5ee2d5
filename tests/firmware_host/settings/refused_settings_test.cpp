// Settings that are wrong, as flags or in a file: refused in one sentence, with the place and what is taken.
#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <string>
#include <string_view>

#include "firmware_host/settings/settings_toml.h"
#include "tests/firmware_host/settings/given_settings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using Catch::Matches;
using test::all_changed;
using test::file_with;
using test::from_flags;
using test::from_toml;
using test::kAllGroups;
using test::sentence;

TEST_CASE("an unknown key names the file, the line and the setting that was meant") {
  CHECK(sentence(from_toml("[camera]\nwidth = 640\n\nformt = \"YUYV\"\n")) ==
        "live.toml:4: there is no setting 'camera.formt' (did you mean 'camera.format'?)");
  CHECK_THAT(sentence(from_toml("framerate = 30\n")), Contains("(did you mean 'camera.framerate'?)"));
  CHECK_THAT(sentence(from_toml("[schedule]\nwidth = 30\n")), Contains("(did you mean 'camera.width'?)"));
  CHECK_THAT(sentence(from_toml("[camera]\nperpendicular = 1\n")),
             Contains("'camera.perpendicular'; --print-config lists all settings"));
  CHECK(sentence(from_toml("\n[camra]\nwidth = 640\n")) ==
        "live.toml:2: there is no table [camra] (did you mean 'camera'?); "
        "there are camera, schedule, sync, fit, knobs, output, video, record, machine");
  CHECK(sentence(from_toml("camera = 3")) ==
        "live.toml:1: 'camera' is a table; write [camera] above its settings");
  CHECK_THAT(sentence(from_toml("[[camera]]\nwidth = 640\n")), Contains("'camera' is a table"));
}

TEST_CASE("a value that a setting does not take is refused with what it takes") {
  const auto refused = [](const std::string& text) { return sentence(from_toml(text)); };
  CHECK(refused("[camera]\nwidth = 3\n") ==
        "live.toml:2: camera.width takes a whole number, 16..65535 or 0, not 3");
  CHECK(refused("[camera]\nwidth = \"wide\"\n") ==
        "live.toml:2: camera.width takes a whole number, 16..65535 or 0, not 'wide'");
  CHECK(refused("[camera]\nwidth = \"640\"\n") ==
        "live.toml:2: camera.width takes a whole number, 16..65535 or 0, not '640'; write it without quotes");
  CHECK_THAT(refused("[camera]\nwidth = \"3\"\n"), Contains("not '3'") && !Contains("quotes"));
  CHECK_THAT(refused("[sync]\nactive_low = \"true\"\n"), Contains("; write it without quotes"));
  CHECK_THAT(refused("[camera]\nwidth = 99999999999\n"), Contains("not 99999999999"));
  CHECK_THAT(refused("[camera]\nwidth = 640.5\n"), Contains("not 640.5"));
  CHECK_THAT(refused("[camera]\nwidth = [640]\n"), Contains("not this list"));
  CHECK_THAT(refused("[camera]\nwidth.px = 640\n"), Contains("not a table"));
  CHECK_THAT(refused("[camera]\nid = 1979-05-27\n"), Contains("camera.id takes a text, not a date or time"));
  CHECK_THAT(refused("[camera]\nid = 7\n"), Contains("camera.id takes a text, not 7"));
  CHECK_THAT(refused("[sync]\nactive_low = 1\n"), Contains("takes true or false, not 1"));
  CHECK_THAT(refused("[fit]\ncode_noise = nan\n"), Contains("takes a number, 0..20, not nan"));
  CHECK_THAT(refused("[schedule]\nshutter = [true]\n"), Contains("takes a text or a list, not this list"));
  CHECK(refused("[fit]\npreset = \"bset\"\n") ==
        "live.toml:2: fit.preset takes realtime, fast, balanced or best, not 'bset' (did you mean 'best'?)");
  CHECK_THAT(refused("[video]\ncodec = \"h265\"\n"), Contains("(did you mean 'hevc'?)"));  // not 'h264'
  CHECK_THAT(refused("[schedule]\nmains = 55\n"), Contains("takes off, 50 or 60, not 55"));
  CHECK(refused("[fit]\ndeadline = \"soon\"\n") ==
        "live.toml:2: fit.deadline takes a time such as 33ms, or off, not 'soon'");
  CHECK_THAT(refused("[fit]\ndeadline = 0.033\n"), Contains("a time such as 33ms, or off, not 0.033"));
}

TEST_CASE("an invalid exposure time in a file of settings is refused with its line") {
  const auto refused = [](const std::string& times) {
    return sentence(from_toml("[camera]\nwidth = 64\n\n[schedule]\nshutter = " + times + "\n"));
  };
  CHECK(
      refused("[\"1ms\", \"x\"]") ==
      "live.toml:5: shutter times '1ms,x': 'x' is not a duration; write it like 4ms, 250us, 1/250 or 0.004s");
  CHECK(refused("[0.001, 4]") ==
        "live.toml:5: shutter times '0.001,4': the time '0.001' has no unit; write 0.001ms or 0.001s");
  CHECK_THAT(refused("[]"), Contains("live.toml:5: shutter times ''"));
  CHECK(sentence(from_flags({"--shutter", "1ms,4"})) ==
        "shutter times '1ms,4': the time '4' has no unit; write 4ms or 4s");
}

TEST_CASE("the first mistake of a file is the one that is reported") {
  CHECK_THAT(sentence(from_toml("[output]\nstats = 3\n[camera]\nwidth = 3\n")), Contains("live.toml:2:"));
}

TEST_CASE("what a flag does not take is refused in the same words") {
  CHECK_THAT(sentence(from_flags({"--deadline", "33mm"})), Contains("or off, not '33mm'"));
  CHECK(sentence(from_flags({"--width", "3"})) == "--width takes a whole number, 16..65535 or 0, not 3");
  CHECK_THAT(sentence(from_flags({"--width", "12px"})), Contains("not '12px'"));
  CHECK_THAT(sentence(from_flags({"--memory", "10GB"})), Contains("64..16777216 MiB or 0, not '10GB'"));
  CHECK_THAT(sentence(from_flags({"--framerate", ""})), Contains("0.1..1000 or 0, not ''"));
  CHECK_THAT(sentence(from_flags({"--code-noise", "inf"})), Contains("0..20, not 'inf'"));
  CHECK_THAT(sentence(from_flags({"--black-level", "255"})), Contains("0..254 or -1, not 255"));
  CHECK(from_flags({"--black-level", "254"}).ok());
  CHECK_THAT(sentence(from_flags({"--compression", "zap"})), Contains("(did you mean 'zip'?)"));
  CHECK_THAT(sentence(from_flags({"--sync-active-low=maybe"})), Contains("true or false, not 'maybe'"));
}

TEST_CASE("layers that do not exist are refused with the nearest that does") {
  CHECK(from_flags({"--layers", "depth, flow"}).value().output.layers.flow);
  CHECK(from_flags({"--layers", ""}).ok());
  CHECK(sentence(from_flags({"--layers", "depth,confidense"})) ==
        "--layers takes any of depth,flow,flow_forward,field_flow,field_flow_forward,confidence,provenance, "
        "not 'confidense' (did you mean "
        "'confidence'?)");
  CHECK_THAT(sentence(from_flags({"--layers", "depth,,flow"})), Contains("not ''"));
}

TEST_CASE("what is not TOML is refused with line and column") {
  CHECK_THAT(sentence(from_toml("[camera]\nwidth = \n")),
             Matches("live\\.toml:2: not TOML at column [0-9]+: .*"));
  CHECK_THAT(sentence(from_toml("[camera]\nwidth = 640\n[camera]\nheight = 480\n")),
             Matches("live\\.toml:3: not TOML at column [0-9]+: .*camera.*"));
  CHECK_THAT(sentence(from_toml("[camera]\nwidth = 640\nwidth = 480\n")), Contains("live.toml:3:"));
  CHECK_THAT(sentence(from_toml(std::string(kMostTomlBytes + 1, '\n'))),
             Contains("65537 bytes") && Contains("at most 65536"));
}

TEST_CASE("letters beyond ASCII belong in quotes or comments") {
  const auto quoted = from_toml("\xef\xbb\xbf[record] # für später\nfile = \"höhe \\\"é\\\".mkv\" # é\n");
  REQUIRE(quoted.ok());
  CHECK(quoted.value().record.file == "höhe \"é\".mkv");
  CHECK(from_toml("[record]\nfile = 'é'\n").value().record.file == "é");
  CHECK_THAT(sentence(from_toml("[record]\nfile = é\n")), Contains("live.toml:2: a letter outside ASCII"));
  CHECK_THAT(sentence(from_toml("[record]\nhöhe = 3\n")), Contains("live.toml:2: a letter outside ASCII"));
  // a quote in the wrong place: the parser meets the letter outside of a text
  CHECK_THAT(sentence(from_toml("[fit]\nseed = 640\"simƪlk?3\"\n")), Contains("live.toml:2: not TOML"));
  CHECK(sentence(from_toml("\n[record]\nfile = \"\"\"\nwalk.mkv\"\"\"\n")) ==
        "live.toml:3: no setting is a multi-line text");
}

TEST_CASE("a name with a zero byte, at which the system would cut it off, is refused") {
  CHECK(sentence(from_toml("[record]\nfile = \"a\\u0000.mkv\"\n")) ==
        "live.toml:2: record.file has a \\u0000, which no setting takes");
  CHECK_FALSE(from_toml("[schedule]\ngain = [\"1\\u0000\", 2]\n").ok());
  CHECK(from_toml("[record]\nfile = \"a\\\\u0000.mkv\"\n").value().record.file == "a\\u0000.mkv");
}

TEST_CASE("a file that cannot be read is an error of its own kind") {
  const auto missing = from_flags({"--config", "/no/such/live.toml"});
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().code == ErrorCode::NotFound);
  CHECK_THAT(missing.error().message, Contains("/no/such/live.toml"));
}

TEST_CASE("the deepest file that is read at all is refused without running out of stack") {
  std::string dotted = "a";
  for (std::size_t i = 0; i < kMostTomlDots; ++i) dotted += ".a";
  CHECK_THAT(sentence(from_toml(dotted + " = 1")), Contains("there is no table [a]"));
  CHECK_THAT(sentence(from_toml("[" + dotted + "]")), Contains("there is no table [a]"));
  CHECK_THAT(sentence(from_toml(dotted + ".a = 1")), Contains("2001 dots"));
  CHECK_THAT(sentence(from_toml("a = " + std::string(kMostTomlBytes - 8, '['))), Contains("not TOML"));
}

TEST_CASE("cut and mutated files are read or refused in one line, never worse") {
  const std::string whole = to_toml(all_changed(), kAllGroups) +
                            "[schedule.more]\na.b = [1, {c = 2}, 1979-05-27T07:32:00Z, 'x y']\n";
  constexpr std::string_view kPieces = "[]{}=\"'\\#.,\n\r\t-+_0x9enai\x80\xff\x01\x7f";
  std::mt19937 random(20240229);
  const auto pick = [&](std::size_t below) { return random() % below; };
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = whole.substr(0, i % 2 == 0 ? pick(whole.size()) : whole.size());
    for (std::size_t edits = pick(4); edits > 0 && !text.empty(); --edits) {
      const std::size_t at = pick(text.size());
      if (pick(2) == 0)
        text[at] = kPieces[pick(kPieces.size())];
      else
        text.insert(at, text.substr(pick(text.size()), pick(12)));
    }
    const auto read = from_toml(text);
    if (read.ok()) continue;
    ++refused;
    INFO(text << "\n-> " << read.error().message);
    REQUIRE(read.error().code == ErrorCode::Invalid);
    REQUIRE_THAT(read.error().message, Contains("live.toml:"));
    REQUIRE(
        std::ranges::none_of(read.error().message, [](unsigned char c) { return c < 0x20 || c == 0x7f; }));
  }
  CHECK(refused > 1000);
}

TEST_CASE("an invalid time of a trigger pulse is refused by its name, and in a file by its line") {
  for (const char* name : {"width", "gap", "tolerance"}) {
    for (const char* wrong : {"0", "-1ms", "2", "wide"}) {
      INFO(name << " " << wrong);
      CHECK_THAT(sentence(from_flags({fmt::format("--trigger-{}={}", name, wrong)})),
                 Contains(fmt::format("--trigger-{} takes a time such as 250us or 1ms, more than 0, not '{}'",
                                      name, wrong)));
      CHECK_THAT(sentence(from_flags(
                     {"--config", file_with(fmt::format("[sync]\ntrigger_{} = \"{}\"\n", name, wrong))})),
                 Contains(fmt::format(":2: sync.trigger_{} takes a time", name)));
    }
    CHECK(from_flags({fmt::format("--trigger-{}=1/2000", name)}).ok());
  }
}
