#include "firmware_host/settings/settings_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/settings_toml.h"
#include "tests/firmware_host/settings/given_settings.h"
#include "tests/places.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::all_changed;
using test::file_with;
using test::from_flags;
using test::from_toml;
using test::kAllGroups;
using test::other_value;
using test::sentence;

namespace {

// "--output", or "--set=steps".
std::string long_flag(const SettingField& field) {
  if (field.type == SettingType::Knob) return "--set=" + field.knob->name;
  return std::string(field.flag).substr(std::string_view(field.flag).find("--"));
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

TEST_CASE("a knob is set by --set and by the file, and is checked where it is read") {
  const auto set = from_flags({"--set", "steps=7", "--set=loss.flow=0.5"});
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

TEST_CASE("a command line that sets a knob twice is refused, and both flags are named") {
  CHECK(sentence(from_flags({"--set", "steps=100", "--set", "loss.flow=0.5", "--set=steps=7"})) ==
        "--set steps=100 and --set steps=7 set the same knob; leave out one of them");
  CHECK(sentence(from_flags({"--set", "look_ahead=2", "--lookahead", "0"})) ==
        "--lookahead 0 and --set look_ahead=2 set the same knob; leave out one of them");
  CHECK(sentence(from_flags({"--code-noise=1", "--set", "code_noise=1"})) ==
        "--code-noise 1 and --set code_noise=1 set the same knob; leave out one of them");
}

TEST_CASE("a knob with a flag of its own has one value, and the flag wins over the file") {
  using Set = std::map<std::string, std::string>;
  CHECK(from_flags({"--lookahead", "0", "--code-noise", "2.5"}).value().fit.knobs ==
        Set{{"look_ahead", "0"}, {"code_noise", "2.5"}});
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
