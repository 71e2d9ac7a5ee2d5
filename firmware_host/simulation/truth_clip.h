// A simulated clip with its ground truth, as `hdrcam compare` reads it: the pictures with their clip.json
// (hal/recording/image_sequence.h), and beside them the truth of each (truth_folder.h). Thread-bound.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware_host/simulation/truth_folder.h"
#include "firmware_host/sinks/output_guard.h"
#include "hal/recording/image_sequence.h"

namespace hdrcam {

class TruthClip {
 public:
  // All files that it writes into the folder, those of the truth among them; `flag` asked for them.
  static std::vector<NamedOutput> outputs(const std::string& flag, const std::string& folder);

  // Takes the place of an earlier clip with the first frame. spec: the scene and its settings. Storage,
  // sensor and pool outlive it. Errors: those of ImageSequenceWriter::create and TruthFolder::create.
  static Result<std::unique_ptr<TruthClip>> create(Storage& storage, const std::string& folder,
                                                   const SimulatedSensor& sensor, const std::string& spec,
                                                   WorkerPool& pool);

  // centre_s: scene time of the frame and of the one after it, to which its flow leads. Errors: NoSpace,
  // Permission, Io.
  Result<void> append(const RawFrame& frame, double centre_s, double next_centre_s);
  // Makes it a clip of the frames so far. Errors: the same.
  Result<void> finish();

 private:
  TruthClip(ImageSequenceWriter pictures, TruthFolder folder, const SimulatedSensor& sensor,
            WorkerPool& pool);

  ImageSequenceWriter pictures_;
  TruthFolder folder_;
  TruthRenderer renderer_;
  SceneTruth truth_;  // of the last frame
};

}  // namespace hdrcam
