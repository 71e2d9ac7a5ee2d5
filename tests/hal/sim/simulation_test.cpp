// The text that names a simulation, and the plan of effects that comes of it.
#include "hal/sim/simulation.h"

#include "tests/contracts/expect.h"

using namespace hdrcam;

namespace {

void require_sentence(const std::string& spec, ErrorCode code, const std::string& words) {
  const auto result = simulation_of(spec);
  require_error(result, code);
  INFO(result.error().message);
  CHECK(result.error().message.find(words) != std::string::npos);
}

}  // namespace

TEST_CASE("a scene's name is enough; settings change what they name") {
  const Simulation plain = value_of(simulation_of("walk"));
  CHECK(plain.width == 320);
  CHECK(plain.scene.objects == 6);
  const Simulation set =
      value_of(simulation_of("walk?seed=3&size=64x48&fps=60&objects=2&lamps=0&speed=0.5&camera=orbit&full-"
                             "well=900&read-noise=3&black=0.06"
                             "&delay=3,1&drops=0.1&reports=no&response=gamma"));
  CHECK(set.scene.seed == 3);
  CHECK(set.width == 64);
  CHECK(set.height == 48);
  CHECK(set.frame_duration() == Duration(16'666'667));
  CHECK(set.scene.objects == 2);
  CHECK(set.scene.speed == 0.5f);
  CHECK(set.scene.camera == CameraMove::Orbit);
  CHECK(set.full_well_e == 900);
  CHECK(set.control_delay == ControlDelays{3, 1});
  CHECK(set.plan.on(Effect::Drops));
  CHECK_FALSE(set.reports_exposure);
  CHECK(set.response == CurveShape::Gamma);
}

TEST_CASE("a scene calls for the effects that it needs and says why") {
  const EffectPlan still = value_of(simulation_of("still")).plan, fast = value_of(simulation_of("fast")).plan;
  CHECK_FALSE(still.on(Effect::MotionBlur));
  CHECK(fast.on(Effect::MotionBlur));
  CHECK(fast.on(Effect::RollingShutter));
  CHECK(still.on(Effect::Quantisation));
  for (std::size_t i = 0; i < kEffects; ++i) CHECK_FALSE(fast.why(static_cast<Effect>(i)).empty());
}

TEST_CASE("with and without overrule the scene, and say so") {
  const EffectPlan plan = value_of(simulation_of("still?with=flare,drops&without=noise")).plan;
  CHECK(plan.on(Effect::Flare));
  CHECK(plan.on(Effect::Drops));
  CHECK_FALSE(plan.on(Effect::Noise));
  CHECK(plan.why(Effect::Noise).find("without=noise") != std::string::npos);
}

TEST_CASE("a scene without a rolling shutter has no read-out time") {
  CHECK(value_of(simulation_of("fast")).readout() == std::chrono::milliseconds(12));
  CHECK(value_of(simulation_of("fast?without=rolling-shutter")).readout() == Duration::zero());
  CHECK(value_of(simulation_of("still")).readout() == Duration::zero());
}

TEST_CASE("the rows of a rolling shutter are read out within a frame") {
  CHECK(value_of(simulation_of("fast?fps=200")).readout() == std::chrono::milliseconds(5));
  CHECK(value_of(simulation_of("fast?fps=1000")).readout() == std::chrono::milliseconds(1));
  CHECK(value_of(simulation_of("fast?fps=80")).readout() == std::chrono::milliseconds(12));
}

TEST_CASE("every effect is found by its name") {
  for (std::size_t i = 0; i < kEffects; ++i)
    CHECK(effect_of(name(static_cast<Effect>(i))) == static_cast<Effect>(i));
  CHECK_FALSE(effect_of("sparkle"));
}

TEST_CASE("what cannot be is refused in a sentence that says what can") {
  require_sentence("wlak", ErrorCode::NotFound, "still, walk, night, fast, lamps, pan");
  require_sentence("walk?sed=3", ErrorCode::Invalid, "the settings are seed, size");
  require_sentence("walk?size=64", ErrorCode::Invalid, "320x240");
  require_sentence("walk?size=64x9", ErrorCode::Invalid, "from 16 to 4096");
  require_sentence("walk?seed=-1", ErrorCode::Invalid, "seed=-1");
  require_sentence("walk?speed=nan", ErrorCode::Invalid, "from 0 to 4");
  require_sentence("walk?delay=1,2,3", ErrorCode::Invalid, "2,1");
  require_sentence("walk?with=sparkle", ErrorCode::Invalid, "motion-blur");
  require_sentence("walk?with=mosaic", ErrorCode::Invalid, "ask for a Bayer format with --format");
  require_sentence("walk?without=mosaic", ErrorCode::Invalid, "ask for an RGB format with --format");
  require_sentence("walk?without=quantisation", ErrorCode::Invalid, "every sensor has it");
  require_sentence("walk?camera=fly", ErrorCode::Invalid, "handheld");
  require_sentence("walk?rays=2", ErrorCode::Invalid, "1 or 4");
  require_sentence("walk?size=64x48&seed=1&size=32x32", ErrorCode::Invalid, "'size' is given more than once");
  require_sentence("walk?with=drops&with=flare&without=flare", ErrorCode::Invalid, "'with=flare'");
  require_sentence("walk?with=drops,noise&without=noise", ErrorCode::Invalid, "'with=noise': it is left out");
  require_sentence("", ErrorCode::NotFound, "scenes are");
}
