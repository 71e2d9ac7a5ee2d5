// hdrcam import CLIP -o x.mkv: a folder of images and its clip.json become a recording.
#include <CLI/CLI.hpp>
#include <memory>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "hal/recording/image_sequence.h"

namespace hdrcam {
namespace {

struct ImportOptions {
  std::string clip, output;
  KeptWork kept;
};

Result<int> copy_frames(Surroundings& around, const ImageSequence& clip, const std::string& path) {
  auto writer = TRY(create_recording(around.storage, path, clip.camera()));
  for (int i = 0; i < clip.frame_count(); ++i) {
    if (around.stop)
      return Error{ErrorCode::Interrupted,
                   fmt::format("interrupted at frame {} of {}", i, clip.frame_count())};
    const RawFrame frame = TRY(clip.read(i));
    TRY(writer->append(frame));
  }
  TRY(writer->finish());
  return clip.frame_count();
}

// Nothing half-written ever has the name of the output, and an older output goes only when the new one is
// whole.
Result<void> import_clip(Surroundings& around, const ImportOptions& options) {
  const auto clip = TRY(ImageSequence::open(around.storage, options.clip));
  std::vector<NamedInput> inputs{{"the clip that is read", clip.path()}};
  for (int i = 0; i < clip.frame_count(); ++i) inputs.push_back({"a frame that is read", clip.path_of(i)});
  TRY(options.kept.check(around.storage, inputs, {{"--output", options.output, OutputKind::Recording}}));
  FileInMaking making = TRY(FileInMaking::beside(around.storage, options.output));
  const int frames = TRY(copy_frames(around, clip, making.path()));
  TRY(making.commit());
  const CameraFacts& camera = clip.camera();
  fmt::print("{}: {} frames, {}x{}, {} bits, {}\n", options.output, frames, camera.width, camera.height,
             camera.bits, name(camera.layout));
  return {};
}

}  // namespace

void add_import(CLI::App& app, Verb& chosen) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* verb = app.add_subcommand("import", "turn a folder of images with a clip.json into a recording");
  verb->add_option("clip", options->clip, "the clip.json, or the folder that holds it")->required();
  verb->add_option("-o,--output", options->output, "the recording to write (.mkv)")->required();
  options->kept.add_to(*verb);
  verb->callback([options, &chosen] {
    chosen = [options](Surroundings& around) { return import_clip(around, *options); };
  });
}

}  // namespace hdrcam
