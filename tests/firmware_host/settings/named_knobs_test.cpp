#include "firmware_host/settings/named_knobs.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a knob that the settings name has its value, all others their defaults, whatever the preset") {
  Settings::Fit fit;
  fit.preset = Preset::Realtime;
  CHECK(named_knobs(fit).field == Knobs().field);  // the preset has none
  fit.knobs = {{"pose", "fixed"}, {"look_ahead", "0"}};
  const Knobs named = named_knobs(fit);
  CHECK(named.pose == PoseKind::Fixed);
  CHECK(named.look_ahead == 0);
  CHECK(named.bootstrap_frames == Knobs().bootstrap_frames);
}

TEST_CASE("knobs that the settings name stand above those of a preset") {
  Settings::Fit fit;
  fit.knobs = {{"look_ahead", "0"}};
  Knobs knobs = knobs_of(Preset::Realtime);
  const FieldKind field = knobs.field;
  set_named_knobs(knobs, fit);
  CHECK(knobs.look_ahead == 0);
  CHECK(knobs.field == field);
}
