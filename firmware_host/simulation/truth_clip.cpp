#include "firmware_host/simulation/truth_clip.h"

namespace hdrcam {

std::vector<NamedOutput> TruthClip::outputs(const std::string& flag, const std::string& folder) {
  std::vector<NamedOutput> outputs;
  const auto add = [&](const std::string& file, OutputKind kind) {
    outputs.push_back({flag, folder + "/" + file, kind});
  };
  const std::string truth = std::string(TruthFolder::kFolder) + "/";
  add(ImageSequence::kFile, OutputKind::Document);
  for (const char* file : TruthFolder::kFiles) add(truth + file, OutputKind::Document);
  add(std::string(ImageSequence::kPictures) + "/%04d.png", OutputKind::Frames);
  for (const char* frames : TruthFolder::kFrames) add(truth + frames, OutputKind::Frames);
  return outputs;
}

Result<std::unique_ptr<TruthClip>> TruthClip::create(Storage& storage, const std::string& folder,
                                                     const SimulatedSensor& sensor, const std::string& spec,
                                                     WorkerPool& pool) {
  auto pictures = TRY(ImageSequenceWriter::create(storage, folder, sensor.facts(), Creation::Replace));
  auto truth = TRY(TruthFolder::create(storage, folder, sensor, spec));
  return std::unique_ptr<TruthClip>(new TruthClip(std::move(pictures), std::move(truth), sensor, pool));
}

TruthClip::TruthClip(ImageSequenceWriter pictures, TruthFolder folder, const SimulatedSensor& sensor,
                     WorkerPool& pool)
    : pictures_(std::move(pictures)),
      folder_(std::move(folder)),
      renderer_(*sensor.scene(), sensor.lens(), sensor.simulation().height, sensor.simulation().width, pool,
                sensor.vignetting()) {}

Result<void> TruthClip::append(const RawFrame& frame, double centre_s, double next_centre_s) {
  renderer_.render(centre_s, next_centre_s, truth_);
  TRY(pictures_.append(frame));
  return folder_.append(truth_, frame.facts);
}

Result<void> TruthClip::finish() {
  TRY(folder_.finish());
  return pictures_.finish();
}

}  // namespace hdrcam
