// hdrcam import CLIP -o x.mkv: a folder of images and its clip.json become a recording.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "capture/recording_stage.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

struct ImportOptions {
  std::string clip, output;
  bool strict = false;
  KeptWork kept;
};

// Returns the number of frames. The verdicts of the pictures on the exposures go into the recording.
Result<std::uint64_t> copy_frames(Surroundings& around, RecordingStage& clip, const std::string& path) {
  auto writer = TRY(create_recording(around.storage, path, clip.camera()));
  CapturedFrame frame;
  while (TRY(clip.next(frame))) {
    if (around.stop)
      return Error{ErrorCode::Interrupted, fmt::format("interrupted at frame {} of {}",
                                                       clip.counters().captured - 1, *clip.frame_count())};
    TRY(writer->append(frame.raw));
  }
  TRY(writer->finish());
  return clip.counters().captured;
}

// The files that must not be overwritten: the clip.json and every image.
Result<std::vector<NamedInput>> files_of(Storage& storage, const std::string& path) {
  const auto clip = TRY(ImageSequence::open(storage, path));
  std::vector<NamedInput> files{{"the clip that is read", clip.path()}};
  for (int i = 0; i < clip.frame_count(); ++i) files.push_back({"a frame that is read", clip.path_of(i)});
  return files;
}

// An incomplete file never has the name of the output, and an older output is replaced only when the new one
// is complete.
Result<void> import_clip(Surroundings& around, const ImportOptions& options) {
  const std::vector<NamedInput> inputs = TRY(files_of(around.storage, options.clip));
  TRY(options.kept.check(around.storage, inputs, {{"--output", options.output, OutputKind::Recording}}));
  RecordingStage clip(TRY(open_clip(around.storage, options.clip)),
                      options.strict ? Contradiction::Fails : Contradiction::Warns);
  FileInMaking making = TRY(FileInMaking::beside(around.storage, options.output));
  const std::uint64_t frames = TRY(copy_frames(around, clip, making.path()));
  TRY(making.commit());
  const CameraFacts& camera = clip.camera();
  for (const std::string& warning : clip.warnings()) fmt::print(stderr, "warning: {}\n", warning);
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
  verb->add_flag("--strict", options->strict,
                 "fail where the pictures contradict an exposure, instead of relabelling or flagging it");
  options->kept.add_to(*verb);
  verb->callback([options, &chosen] {
    chosen = [options](Surroundings& around) { return import_clip(around, *options); };
  });
}

}  // namespace hdrcam
