#include "firmware_host/settings/settings_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/settings_toml.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using Catch::Matches;

namespace {

const std::vector<SettingGroup> kAllGroups{SettingGroup::Camera, SettingGroup::Schedule, SettingGroup::Sync,
                                           SettingGroup::Fit,    SettingGroup::Knobs,    SettingGroup::Output,
                                           SettingGroup::Record, SettingGroup::Machine};

std::string file_with(const std::string& text) {
  static const std::string folder = sample::scratch_folder("settings");
  const std::string path = folder + "/live.toml";
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
  return path;
}

// What a verb of these groups makes of a command line.
Result<Settings> from_flags(const std::vector<std::string>& words,
                            const std::vector<SettingGroup>& groups = kAllGroups) {
  CLI::App verb("", "live");
  const SettingsFlags flags(verb, groups);
  verb.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  return flags.read(posix_storage());
}

Result<Settings> from_toml(const std::string& text) {
  Settings settings;
  const auto read = read_toml(text, "live.toml", settings);
  return read ? Result<Settings>(settings) : read.error();
}

std::string sentence(const Result<Settings>& refused) {
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Invalid);
  return refused.error().message;
}

// A value that the field takes and that is not its default.
std::string other_value(const SettingField& field) {
  switch (field.type) {
    case SettingType::Choice:
    case SettingType::Words:
      return field.choices.back();
    case SettingType::Switch:
      return "true";
    case SettingType::Whole:
      return to_text(field.range.most);
    case SettingType::Real:
      return to_text(field.range.least + (field.range.most - field.range.least) / 3);
    case SettingType::Time:
    case SettingType::TimeOrOff:
      return "33ms";
    case SettingType::Delay:
      return "-2ms";
    case SettingType::Times:
      return "250us, 1/60";
    case SettingType::Gains:
      return "2,1,1.5";
    case SettingType::Knob:
      return field.knob->kind == KnobKind::Choice ? field.knob->choices.back() : to_text(field.knob->least);
    case SettingType::Text:
      break;
  }
  return "a \"quoted\" \\ word, wörtlich\tand\n=[#]";
}

// "--output", or "--set=steps".
std::string long_flag(const SettingField& field) {
  if (field.type == SettingType::Knob) return "--set=" + field.knob->name;
  return std::string(field.flag).substr(std::string_view(field.flag).find("--"));
}

Settings all_changed() {
  Settings settings;
  for (const SettingField& field : setting_fields())
    REQUIRE(set_from_text(field, other_value(field), field.key, settings).ok());
  return settings;
}

// The line of a knob in docs/configuration.md.
std::string row_of(const Knob& knob) {
  const auto in = [&](Preset preset) { return knob_value(knobs_of(preset), knob.name).value(); };
  return fmt::format("| `{}` | {} | {} | {} | {} | {} | {} | {} |", knob.name, in(Preset::Realtime),
                     in(Preset::Fast), in(Preset::Balanced), in(Preset::Best), accepted_values(knob),
                     knob.gives, knob.costs);
}

bool same(const Settings& a, const Settings& b) {
  return std::ranges::all_of(setting_fields(),
                             [&](const SettingField& field) { return field.read(a) == field.read(b); });
}

}  // namespace

TEST_CASE("a flag wins over the file, and the file over the default") {
  const std::string path = file_with("[camera]\nwidth = 640\nheight = 480\n");
  const auto settings = from_flags({"--config", path, "--width", "320"});
  REQUIRE(settings.ok());
  CHECK(settings.value().camera.width == 320);
  CHECK(settings.value().camera.height == 480);
  CHECK(settings.value().camera.buffers == 8);
}

TEST_CASE("a flag that repeats the default still wins over the file") {
  const std::string path = file_with("[camera]\nbuffers = 12\n[sync]\nactive_low = true\n");
  const auto settings = from_flags({"--config", path, "--buffers", "8", "--sync-active-low=false"});
  REQUIRE(settings.ok());
  CHECK(settings.value().camera.buffers == 8);
  CHECK_FALSE(settings.value().sync.active_low);
}

TEST_CASE("every setting has a default that it takes, and another value") {
  for (const SettingField& field : setting_fields()) {
    INFO(field.key);
    Settings settings;
    const SettingValue fallback = field.read(settings);
    CHECK(set(field, fallback, field.key, settings).ok());
    CHECK(set_from_text(field, other_value(field), field.key, settings).ok());
    CHECK(field.read(settings) != fallback);
  }
}

TEST_CASE("every setting comes back from the printed configuration and from its flag") {
  for (const SettingField& field : setting_fields()) {
    INFO(field.key);
    Settings changed;
    REQUIRE(set_from_text(field, other_value(field), field.key, changed).ok());
    const std::string toml = to_toml(changed, kAllGroups);
    INFO(toml);
    const auto printed = from_toml(toml);
    REQUIRE(printed.ok());
    CHECK(same(printed.value(), changed));

    const auto flagged = from_flags({long_flag(field) + "=" + other_value(field)});
    REQUIRE(flagged.ok());
    CHECK(same(flagged.value(), changed));
  }
}

TEST_CASE("the printed configuration has a comment for every key and only the groups asked for") {
  const std::string text = to_toml(Settings{}, {SettingGroup::Camera, SettingGroup::Sync});
  CHECK_THAT(text, Contains("[camera]\n# a device") && Contains("\n\n[sync]\n# "));
  CHECK_THAT(text, !Contains("[fit]") && !Contains("[schedule]"));
  CHECK_THAT(to_toml(Settings{}, kAllGroups), Contains("\nshutter = \"1ms,4ms,16ms\"\n"));
  const auto all = from_toml(to_toml(all_changed(), kAllGroups));
  REQUIRE(all.ok());
  CHECK(same(all.value(), all_changed()));
}

TEST_CASE("lists may be written as arrays, and numbers of a choice without quotes") {
  const auto settings = from_toml(
      "[camera]\ncontrol_delay = [2, 1]\nframerate = 30\n"
      "[schedule]\nshutter = [\"1ms\", \"1/250\"]\ngain = [1, 2.5]\nmains = 50\n"
      "[output]\nlayers = [\"depth\", \"flow\"]\n");
  REQUIRE(settings.ok());
  CHECK(settings.value().camera.control_delay == "2,1");
  CHECK(settings.value().camera.framerate_hz == 30);
  CHECK(settings.value().schedule.shutter == "1ms,1/250");
  CHECK(settings.value().schedule.gain == "1,2.5");
  CHECK(settings.value().schedule.mains == Mains::Hz50);
  CHECK(settings.value().output.layers.depth);
  const auto one = from_toml("schedule.gain = 4");
  REQUIRE(one.ok());
  CHECK(one.value().schedule.gain == "4");
}

TEST_CASE("a verb takes the flags of its groups, and a file with the keys of all") {
  const std::string path = file_with("[fit]\npreset = \"fast\"\n[record]\nmemory_mib = 64\n");
  const auto settings = from_flags({"--config", path}, {SettingGroup::Camera, SettingGroup::Record});
  REQUIRE(settings.ok());
  CHECK(settings.value().fit.preset == Preset::Fast);
  CHECK(settings.value().record.memory_mib == 64);
  CHECK_THROWS_AS(from_flags({"--preset", "fast"}, {SettingGroup::Camera}), CLI::ParseError);
}

TEST_CASE("the recording is written with -o by a verb that has no other output") {
  const auto alone = from_flags({"-o", "walk.mkv"}, {SettingGroup::Camera, SettingGroup::Record});
  REQUIRE(alone.ok());
  CHECK(alone.value().record.file == "walk.mkv");
  const auto both = from_flags({"-o", "out/%06d.exr", "--record", "walk.mkv"});
  REQUIRE(both.ok());
  CHECK(both.value().output.path("frames") == "out/%06d.exr");
  CHECK(both.value().record.file == "walk.mkv");
}

TEST_CASE("the help shows every flag with its default, under the title of its group") {
  CLI::App verb("", "live");
  const SettingsFlags flags(verb, kAllGroups);
  const std::string help = verb.help();
  for (const SettingField& field : setting_fields()) {
    INFO(field.key);
    if (field.type == SettingType::Knob) continue;
    CHECK_THAT(help, Contains(field.flag) && Contains(title(field.group)));
    CHECK(verb.get_option(long_flag(field))->get_group() == title(field.group));
  }
  CHECK_THAT(help, Contains("--buffers INT=8") || Contains("--buffers INT [8]"));  // CLI11 2.3 or later
  CHECK_THAT(help, Contains("--shutter TEXT=1ms,4ms,16ms") || Contains("--shutter TEXT [1ms,4ms,16ms]"));
  CHECK_THAT(help, Contains("--config") && Contains("--print-config"));
}

TEST_CASE("a verb gets its settings, or none where they are printed instead") {
  const auto given = [](std::vector<std::string> words) {
    CLI::App verb("", "live");
    const SettingsFlags flags(verb, {SettingGroup::Camera});
    verb.parse(std::move(words));
    return flags.read_or_print(posix_storage());
  };
  const auto run = given({"--width=320"});
  REQUIRE(run.ok());
  REQUIRE(run.value().has_value());
  CHECK(run.value()->camera.width == 320);
  const auto printed = given({"--print-config"});
  REQUIRE(printed.ok());
  CHECK_FALSE(printed.value().has_value());
  CHECK_FALSE(given({"--width=-1"}).ok());
}

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

TEST_CASE("settings that differ from the defaults can be typed again as flags") {
  CLI::App verb("", "live");
  const SettingsFlags flags(verb, kAllGroups);
  CHECK(flags.as_flags(Settings{}).empty());
  Settings settings;
  settings.fit.preset = Preset::Fast;
  settings.output.paths["frames"] = "my out/%06d.exr";
  CHECK(flags.as_flags(settings) == " --preset=fast --output='my out/%06d.exr'");
  Settings knobs;
  knobs.fit.knobs = {{"code_noise", "2"}, {"look_ahead", "1"}, {"steps", "7"}};
  CHECK(flags.as_flags(knobs) == " --lookahead=1 --code-noise=2 --set steps=7");
  knobs.fit.knobs = {{"look_ahead", "-1"}};
  CHECK(flags.as_flags(knobs) == " --set look_ahead=-1");
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

TEST_CASE("a knob is set by --set and by the file, and is checked where it is read") {
  const auto set = from_flags({"--set", "steps=100", "--set", "loss.flow=0.5", "--set=steps=7"});
  REQUIRE(set.ok());
  CHECK(set.value().fit.knobs == std::map<std::string, std::string>{{"steps", "7"}, {"loss.flow", "0.5"}});
  const auto file = from_toml("[knobs]\nsteps = 100\nshrinkage = \"off\"\nloss.flow = 0.5\n");
  REQUIRE(file.ok());
  CHECK(file.value().fit.knobs ==
        std::map<std::string, std::string>{{"steps", "100"}, {"shrinkage", "off"}, {"loss.flow", "0.5"}});
  CHECK_THAT(sentence(from_flags({"--set", "stpes=3"})),
             Contains("there is no knob 'stpes' (did you mean 'steps'?)"));
  CHECK_THAT(sentence(from_flags({"--set", "steps=many"})),
             Contains("steps takes a whole number, 0..1000 steps, not 'many'"));
  CHECK_THAT(sentence(from_flags({"--set", "steps"})), Contains("write NAME=VALUE"));
  CHECK_THAT(sentence(from_toml("[knobs]\nsteps = -1\n")), Contains("live.toml:2: knobs.steps takes"));
  CHECK_THAT(sentence(from_toml("[knobs]\nstpes = 1\n")), Contains("(did you mean 'knobs.steps'?)"));
}

TEST_CASE("a knob with a flag of its own has one value, of whichever of the two was given last") {
  using Set = std::map<std::string, std::string>;
  CHECK(from_flags({"--lookahead", "0", "--code-noise", "2.5"}).value().fit.knobs ==
        Set{{"look_ahead", "0"}, {"code_noise", "2.5"}});
  CHECK(from_flags({"--set", "look_ahead=2", "--lookahead", "0"}).value().fit.knobs ==
        Set{{"look_ahead", "2"}});
  const std::string path = file_with("[knobs]\nlook_ahead = 0\ncode_noise = 3\n");
  CHECK(from_flags({"--config", path, "--lookahead", "1", "--code-noise", "2"}).value().fit.knobs ==
        Set{{"look_ahead", "1"}, {"code_noise", "2"}});
  CHECK(from_flags({"--config", path, "--lookahead=-1", "--code-noise", "1"}).value().fit.knobs.empty());
  const std::string text = to_toml(from_flags({"--set", "look_ahead=1"}).value(), kAllGroups);
  CHECK_THAT(text, Contains("\nlookahead = 1\n") && Contains("\nlook_ahead = \"1\"\n"));
}

TEST_CASE("a file that states a knob by both of its keys is read where they agree, and refused otherwise") {
  const auto both = [](const char* number, const char* knob) {
    return from_toml(fmt::format("[fit]\n{}\n\n[knobs]\n{}\n", number, knob));
  };
  for (const char* value : {"look_ahead=1", "look_ahead=-1", "code_noise=2.5"}) {
    const Settings asked = from_flags({"--set", value}).value();
    const auto read = from_toml(to_toml(asked, kAllGroups));  // states both
    REQUIRE(read.ok());
    CHECK(read.value().fit.knobs == asked.fit.knobs);
  }
  CHECK(both("code_noise = 2", "code_noise = \"2.0\"").ok());
  CHECK(sentence(both("lookahead = 2", "look_ahead = \"1\"")) ==
        "live.toml:5: knobs.look_ahead = 1 contradicts fit.lookahead = 2 in line 2, as both set one knob; "
        "give both the same value, or leave one out");
  CHECK_THAT(sentence(both("code_noise = 3", "code_noise = 2")),
             Contains("knobs.code_noise = 2 contradicts fit.code_noise = 3 in line 2"));
  CHECK_THAT(sentence(both("lookahead = -1", "look_ahead = 1")), Contains("contradicts fit.lookahead = -1"));
  CHECK_THAT(sentence(from_toml("[knobs]\nlook_ahead = 1\n[fit]\nlookahead = 2\n")),
             Contains("live.toml:4: fit.lookahead = 2 contradicts knobs.look_ahead = 1 in line 2"));
}

TEST_CASE("the printed configuration shows each knob as the preset has it, in a comment") {
  Settings settings;
  settings.fit.preset = Preset::Best;
  const std::string text = to_toml(settings, kAllGroups);
  CHECK_THAT(text, Contains("\n[knobs]\n") && Contains("\n#view_steps = \"100\"\n"));
  settings.fit.knobs["steps"] = "7";
  CHECK_THAT(to_toml(settings, kAllGroups), Contains("\nsteps = \"7\"\n"));
}

TEST_CASE("docs/configuration.md lists every setting as the program has it") {
  const auto page = read_whole(posix_storage(), HDRCAM_SOURCE_DIR "/docs/configuration.md");
  REQUIRE(page.ok());
  const Settings defaults;
  for (const SettingField& field : setting_fields()) {
    if (field.type == SettingType::Knob) {
      const std::string line = row_of(*field.knob);
      INFO(line);
      CHECK(page.value().find(line) != std::string::npos);
      continue;
    }
    const std::string fallback = to_text(field.read(defaults));
    const std::string line = fmt::format("| `{}` | `{}` | {} | {} |", field.key, field.flag,
                                         fallback.empty() ? "" : "`" + fallback + "`", describe(field));
    INFO(line);
    CHECK(page.value().find(line) != std::string::npos);
  }
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

TEST_CASE("the strobe's delay takes times before and after the timestamp, and 0 with and without a unit") {
  for (const char* delay : {"-2ms", "0ms", "0us", "0", "250us"}) {
    const auto settings = from_flags({fmt::format("--strobe-delay={}", delay)});
    REQUIRE(settings.ok());
    CHECK(settings.value().sync.strobe_delay == delay);
  }
  CHECK(from_flags({"--config", file_with("[sync]\nstrobe_delay = 0\n")}).ok());
  CHECK_THAT(sentence(from_flags({"--strobe-delay=2"})),
             Contains("--strobe-delay takes a time such as 250us, -2ms or 0, not '2'"));
}
