// The gt/ folder of a clip, as `hdrcam compare` reads it (render/scores/ground_truth.h): the ground truth of
// a simulated scene, frame by frame, and at the end gt.json and crf.csv. Thread-bound.
//   gt/hdr/NNNN.exr R G B half · gt/depth/NNNN.exr Z metres · gt/flow/NNNN.exr R=dx G=dy B=occluded ·
//   gt/id/NNNN.png
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "hal/sim/simulated_sensor.h"
#include "hal/storage.h"

namespace hdrcam {

class TruthFolder {
 public:
  // Its name in the clip, and its files: patterns of one for each frame, and those of the whole clip.
  static constexpr const char* kFolder = "gt";
  static constexpr const char* kFrames[] = {"hdr/%04d.exr", "depth/%04d.exr", "flow/%04d.exr", "id/%04d.png"};
  static constexpr const char* kFiles[] = {"gt.json", "crf.csv"};

  // folder: of the clip; creates gt/ in it. spec: the scene's settings, stored in gt.json. Errors:
  // Permission, Io.
  static Result<TruthFolder> create(Storage& storage, const std::string& folder,
                                    const SimulatedSensor& sensor, const std::string& spec);

  // Writes the next frame: 0, 1, 2.. Errors: NoSpace, Permission, Io.
  Result<void> append(const SceneTruth& truth, const FrameFacts& facts);
  // gt.json and crf.csv.
  Result<void> finish();

 private:
  TruthFolder(Storage& storage, std::string folder) : storage_(&storage), folder_(std::move(folder)) {}
  void describe_sensor(const SimulatedSensor& sensor);  // from radiance to codes, and the lens
  Result<void> write_pictures(const SceneTruth& truth);

  Storage* storage_;
  std::string folder_;  // gt itself
  Simulation simulation_;
  nlohmann::ordered_json json_;
  double shortest_exposure_ = 0;  // seconds x gain
  float brightest_ = 0;           // radiance
};

}  // namespace hdrcam
