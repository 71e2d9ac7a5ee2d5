#include "firmware_host/run/output_needs.h"

#include <string>

#include "firmware_host/run/pipeline_options.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("EXR files beside a camera are not compressed, others are, and the setting overrules both") {
  Settings::Output output;
  CHECK(compression_of(output, RunPace::Camera) == ExrCompression::None);
  CHECK(compression_of(output, RunPace::Clip) == ExrCompression::Piz);
  for (const auto& [asked, used] : {std::pair(FrameCompression::None, ExrCompression::None),
                                    {FrameCompression::Rle, ExrCompression::Rle},
                                    {FrameCompression::Zip, ExrCompression::Zip},
                                    {FrameCompression::Piz, ExrCompression::Piz}})
    for (const RunPace pace : {RunPace::Camera, RunPace::Clip}) {
      output.compression = asked;
      CHECK(compression_of(output, pace) == used);
    }
}

TEST_CASE("a layer or an output of the field is refused by name where the field is left out") {
  Settings settings;
  settings.output.paths["frames"] = "out/%06d.exr";
  settings.fit.emit = EmitLayer::State;
  CHECK(check_needs(settings).ok());
  const std::pair<bool ExrLayers::*, const char*> layers[] = {
      {&ExrLayers::depth, "depth"},
      {&ExrLayers::field_flow, "field_flow"},
      {&ExrLayers::field_flow_forward, "field_flow_forward"}};
  for (const auto& [layer, word] : layers) {
    settings.output.layers = {};
    settings.output.layers.*layer = true;
    const auto refused = check_needs(settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::Invalid);
    CHECK(refused.error().message == std::string("--layers ") + word +
                                         " comes from the field, which --emit state leaves out; leave out "
                                         "one of them");
  }
  settings.output.layers = {.flow = true, .flow_forward = true};
  CHECK(check_needs(settings).ok());  // the state's own
  settings.fit.emit = EmitLayer::Merged;
  settings.output.paths["depth"] = "depth/%06d.png";
  CHECK(check_needs(settings).ok());
  settings.fit.knobs["field"] = "none";
  REQUIRE_FALSE(check_needs(settings).ok());
  CHECK(check_needs(settings).error().message ==
        "--depth comes from the field, which --set field=none leaves out; leave out one of them");
}

TEST_CASE("frames of the field alone are refused where the field is left out, whatever else is asked for") {
  Settings settings;
  settings.output.paths["frames"] = "out/%06d.exr";
  settings.fit.emit = EmitLayer::Field;
  for (const Preset preset : {Preset::Realtime, Preset::Fast, Preset::Balanced, Preset::Best}) {
    settings.fit.preset = preset;
    CHECK(check_needs(settings).ok());
  }
  settings.fit.knobs["field"] = "none";
  for (const char* depth : {"", "depth/%06d.png"}) {
    settings.output.paths["depth"] = depth;
    const auto refused = check_needs(settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::Invalid);
    CHECK(refused.error().message ==
          "--emit field comes from the field, which --set field=none leaves out; leave out one of them");
  }
}

TEST_CASE(
    "pictures whose names have blanks, at which COLMAP splits a line, are refused for its model alone") {
  Settings settings;
  settings.output.paths = {{"frames", "my walk/%06d.exr"}, {"colmap", "my walk/colmap"}};
  CHECK(check_needs(settings).ok());  // the folder's name is not in the model
  for (const char* frames : {"out/my walk %06d.exr", "out/%06d\tleft.exr"}) {
    settings.output.paths = {{"frames", frames}, {"transforms", "out/transforms.json"}};
    CHECK(check_needs(settings).ok());
    settings.output.paths["colmap"] = "out/colmap";
    const auto refused = check_needs(settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::Invalid);
    CHECK(refused.error().message.starts_with(std::string("--colmap cannot name the pictures '") + frames));
  }
}

TEST_CASE("pictures that are numbered wrongly are refused for that, also where poses name them") {
  const std::pair<const char*, const char*> wrong[] = {
      {"frames", "a%6d.exr"}, {"frames", "a.exr"}, {"preview", "p%6d.png"}};
  for (const auto& [sink, name] : wrong)
    for (const char* poses : {"transforms", "colmap"}) {
      Settings settings;
      settings.output.paths = {{sink, name}, {poses, "out/poses"}};
      const auto refused = check_needs(settings);
      REQUIRE_FALSE(refused.ok());
      CHECK(refused.error().code == ErrorCode::Invalid);
      CHECK(refused.error().message.find(std::string("'") + name + "'") != std::string::npos);
    }
  Settings none;
  none.output.paths = {{"frames", "out.mp4"}, {"transforms", "out/transforms.json"}};
  REQUIRE_FALSE(check_needs(none).ok());
  CHECK(check_needs(none).error().message.find("it leaves none") != std::string::npos);
}

TEST_CASE("motion to the next frame is refused where the run does not wait for it, whoever says so") {
  Settings settings;
  settings.output.paths["flow_forward"] = "flow/%06d.flo";
  for (const Preset preset : {Preset::Realtime, Preset::Fast, Preset::Balanced, Preset::Best}) {
    settings.fit.preset = preset;
    CHECK(check_needs(settings).ok());
  }
  for (const char* frames : {"-1", "1", "2"}) {
    settings.fit.knobs = {{"look_ahead", frames}};
    CHECK(check_needs(settings).ok());
  }
  settings.fit.knobs = {{"look_ahead", "0"}};
  REQUIRE_FALSE(check_needs(settings).ok());
  CHECK(check_needs(settings).error().code == ErrorCode::Invalid);
  CHECK(check_needs(settings).error().message ==
        "motion to the next frame is known once that frame is there; give --lookahead 1, or --set "
        "look_ahead=1");
}

TEST_CASE("the field's motion to the next frame is told to be a guess where the field is not fitted to it") {
  const auto noted = [](const Settings& settings, int width) {
    CameraFacts camera;
    camera.width = width, camera.height = width * 3 / 4;
    return !note_on_motion(settings, camera).empty();
  };
  Settings none, file, layer;
  none.output.paths = {{"flow_forward", "flow/%06d.flo"}, {"field_flow_backward", "back/%06d.flo"}};
  file.output.paths["field_flow_forward"] = "field/%06d.flo";
  layer.output.layers.field_flow_forward = true;
  for (const char* frames : {"-1", "0", "1", "2"}) {
    INFO(frames);
    for (Settings* settings : {&none, &file, &layer}) settings->fit.knobs = {{"look_ahead", frames}};
    const bool knows = frames == std::string("2");
    CHECK_FALSE(noted(none, 1280));
    CHECK(noted(file, 1280) == !knows);
    CHECK(noted(layer, 1280) == !knows);
  }
  file.fit.knobs = {{"look_ahead", "-1"}};
  CHECK_FALSE(noted(file, 640));  // small pictures wait for two frames
  file.fit.knobs.clear(), file.fit.preset = Preset::Fast;
  CHECK(noted(file, 640));
}

TEST_CASE("motion is found among the layers and among the outputs of its own") {
  Settings::Output output;
  output.paths["frames"] = "out/%06d.exr";
  output.layers.depth = output.layers.provenance = true;
  CHECK(motion_output(output).empty());
  output.layers.field_flow = true;
  CHECK(motion_output(output) == "--layers field_flow");
  output.layers.flow_forward = true;
  CHECK(motion_output(output) == "--layers flow_forward");
  output.paths["flow_backward"] = "back/%06d.flo";
  CHECK(motion_output(output) == "--flow-backward");
}

TEST_CASE(
    "a scene that is saved has a field whatever the preset, which stays, and none where that is asked for") {
  Settings settings;
  settings.fit.preset = Preset::Realtime;
  const auto field = [&] { return options_of(settings, FieldUse::Fills).knobs.field; };
  CHECK(field() == FieldKind::None);
  settings.output.paths[Settings::Output::kSnapshot] = "scene.hdrscene";
  CHECK(field() == FieldKind::HashGrid);
  CHECK(field_use(settings, options_of(settings, FieldUse::Fills), FieldUse::Fills) == FieldUse::Seen);
  settings.fit.emit = EmitLayer::State;
  CHECK(field() == FieldKind::None);
}

}  // namespace
}  // namespace hdrcam
