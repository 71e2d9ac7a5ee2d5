#include "online/knobs.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("each knob has a name of its own, says what it costs and gives, and stands within its range",
          "[knobs]") {
  std::set<std::string> names;
  for (const Knob& knob : knob_table()) {
    INFO(knob.name);
    CHECK(names.insert(knob.name).second);
    CHECK(std::string_view(knob.costs).size() > 3);
    CHECK(std::string_view(knob.gives).size() > 3);
    for (const Preset preset : {Preset::Realtime, Preset::Fast, Preset::Balanced, Preset::Best}) {
      const double value = knob.get(knobs_of(preset));
      CHECK((value >= knob.least && value <= knob.most));
      if (knob.kind == KnobKind::Whole) CHECK(std::fmod(value, knob.multiple) == 0);
    }
  }
  CHECK(names.size() > 40);
}

TEST_CASE("each knob can be set to both ends of its range, reads back what was set and moves no other",
          "[knobs]") {
  for (const Knob& knob : knob_table())
    for (const double end : {knob.least, knob.most}) {
      INFO(knob.name << " = " << end);
      Knobs knobs = knobs_of(Preset::Balanced);
      const double whole = std::ceil(end / knob.multiple) * knob.multiple;
      const std::string text = knob.kind == KnobKind::Choice ? knob.choices[static_cast<std::size_t>(end)]
                               : knob.kind == KnobKind::Whole
                                   ? std::to_string(static_cast<int>(whole > knob.most ? end : whole))
                                   : std::to_string(end);
      REQUIRE(set_knob(knobs, knob.name, text).ok());
      CHECK(knob.get(knobs) == Approx(std::stod(knob.kind == KnobKind::Choice ? std::to_string(end) : text)));
      const std::string shown = knob_value(knobs, knob.name).value();
      Knobs again = knobs_of(Preset::Balanced);
      REQUIRE(set_knob(again, knob.name, shown).ok());
      CHECK(knob.get(again) == knob.get(knobs));
      for (const Knob& other : knob_table())
        if (other.name != knob.name) CHECK(other.get(knobs) == other.get(knobs_of(Preset::Balanced)));
    }
}

TEST_CASE("a value beyond the range, of another kind or for no knob is refused with what would do",
          "[knobs]") {
  struct Case {
    const char *knob, *value, *says;
  };
  const Case cases[] = {
      {"steps", "-1", "steps takes a whole number, 0..1000 steps, not '-1'"},
      {"steps", "1.5", "steps takes a whole number, 0..1000 steps, not '1.5'"},
      {"steps", "", "steps takes a whole number, 0..1000 steps, not ''"},
      {"steps", "10x", "steps takes a whole number, 0..1000 steps, not '10x'"},
      {"steps", "nan", "steps takes a whole number, 0..1000 steps, not 'nan'"},
      {"rays_per_step", "100",
       "rays_per_step takes a whole number, 32..4096 rays, a multiple of 32, not '100'"},
      {"static_levels", "7", "static_levels takes a whole number, 2..16 levels, a multiple of 2, not '7'"},
      {"dynamic_levels", "1", "dynamic_levels takes a whole number, 2..16 levels, a multiple of 2, not '1'"},
      {"state.gate_tolerance", "-1",
       "state.gate_tolerance takes a number, 0..1000000000 mean chi^2, not '-1'"},
      {"table_rate", "2", "table_rate takes a number, 0.00001..1, not '2'"},
      {"flow", "finest", "flow takes coarse, fast, medium or fine, not 'finest'"},
      {"step", "10", "there is no knob 'step'; there are"},
  };
  for (const Case& c : cases) {
    INFO(c.knob << '=' << c.value);
    Knobs knobs = knobs_of(Preset::Balanced);
    const Result<void> set = set_knob(knobs, c.knob, c.value);
    REQUIRE_FALSE(set.ok());
    CHECK(set.error().code == ErrorCode::Invalid);
    CHECK(set.error().message.find(c.says) == 0);
    for (const Knob& knob : knob_table()) CHECK(knob.get(knobs) == knob.get(knobs_of(Preset::Balanced)));
  }
}

TEST_CASE("the presets are ordered by what they spend", "[knobs]") {
  for (const char* name : {"flow", "view_steps", "samples_per_ray"}) {
    INFO(name);
    std::vector<double> values;
    for (const Knob& knob : knob_table())
      if (knob.name == name)
        for (const Preset preset : {Preset::Realtime, Preset::Fast, Preset::Balanced, Preset::Best})
          values.push_back(knob.get(knobs_of(preset)));
    REQUIRE(values.size() == 4);
    CHECK(std::is_sorted(values.begin(), values.end()));
    CHECK(values.front() < values.back());
  }
}

TEST_CASE("balanced looks two frames ahead in small pictures, one in large ones, unless it is told how far",
          "[knobs]") {
  Knobs knobs = knobs_of(Preset::Balanced);
  CHECK(look_ahead_of(knobs, 240, 320) == 2);
  CHECK(look_ahead_of(knobs, 480, 640) == 2);
  CHECK(look_ahead_of(knobs, 640, 481) == 1);
  CHECK(look_ahead_of(knobs, 1080, 1920) == 1);
  for (const int frames : {0, 1, 2}) {
    knobs.look_ahead = frames;
    CHECK(look_ahead_of(knobs, 240, 320) == frames);
    CHECK(look_ahead_of(knobs, 1080, 1920) == frames);
  }
  CHECK(look_ahead_of(knobs_of(Preset::Realtime), 240, 320) == 1);
  CHECK(look_ahead_of(knobs_of(Preset::Best), 1080, 1920) == 2);
}
