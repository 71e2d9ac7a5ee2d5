#include "tests/quality/simulated_clip.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/exr.h"
#include "render/scores/ground_truth.h"
#include "render/scores/order_statistics.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/ran_here.h"

namespace hdrcam::test {
namespace {

constexpr int kSkip = 1;  // frames at either end are not scored, as `hdrcam compare` does

void write_radiance(const std::string& path, const Image<float>& radiance) {
  ExrPicture picture;
  picture.rows = radiance.rows(), picture.cols = radiance.cols();
  picture.compression = ExrCompression::None;
  for (int c = 0; c < 3; ++c)
    picture.channels.push_back({std::string(exr_channel::kRadiance[c]),
                                {radiance.plane(c), radiance.plane_size()},
                                ExrSample::Float});
  require_done(write_whole(posix_storage(), path, value_of(encode_exr(picture))));
}

}  // namespace

SimulatedClip film(const std::string& scene, const std::string& shutter, int frames,
                   const std::string& format) {
  static int filmed = 0;
  SimulatedClip clip;
  clip.folder = sample::scratch_folder(fmt::format("simulated_clip_{}", filmed++));
  const std::string recording = clip.folder + "/clip.mkv", count = std::to_string(frames);
  const test::RanHere filmed_here =
      test::ran_here({"simulate", scene, "-o", recording, "--truth", clip.folder, "--frames", count,
                      "--shutter", shutter, "--format", format});
  INFO(filmed_here.err);
  REQUIRE(filmed_here.exit_code == 0);
  const auto reader = value_of(open_recording(posix_storage(), recording));
  clip.camera = reader->camera();
  while (auto frame = value_of(reader->next())) clip.frames.push_back(std::move(*frame));
  REQUIRE(static_cast<int>(clip.frames.size()) == frames);
  return clip;
}

EmittedClip emit(const SimulatedClip& clip, const PipelineOptions& options) {
  WorkerPool pool(2);
  Pipeline pipeline(options, clip.camera, pool);
  EmittedClip emitted;
  const Pipeline::Deliver keep = [&](const HdrFrame& frame, const FrameEstimate&,
                                     const FrameRecord& record) -> Result<void> {
    HdrFrame& kept = emitted.frames.emplace_back();
    kept.facts = frame.facts;
    kept.radiance = frame.radiance.clone();
    kept.sigma = frame.sigma.clone();
    kept.provenance = frame.provenance.clone();
    emitted.fit_steps += record.fit_steps;
    return {};
  };
  for (const RawFrame& frame : clip.frames) require_done(pipeline.take(frame, keep));
  require_done(pipeline.finish(keep));
  return emitted;
}

ClipScores scores_of(const SimulatedClip& clip, const EmittedClip& emitted) {
  const std::string folder = clip.folder + "/emitted";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  for (const HdrFrame& frame : emitted.frames)
    write_radiance(fmt::format("{}/{:04d}.exr", folder, frame.facts.sequence), frame.radiance);
  ScoreOptions options;
  options.skip = kSkip;
  return value_of(score_clip(posix_storage(), clip.folder, folder, options));
}

Calibration calibration_of(const SimulatedClip& clip, const EmittedClip& emitted, const ClipScores& scores) {
  const GroundTruth truth = value_of(GroundTruth::open(posix_storage(), clip.folder));
  // below `dark` differences do not count: sigma knows the same offset (render/emission.cpp)
  const auto white = static_cast<float>(scores.shared.white), dark = white / 5000;
  struct Sums {
    double error = 0, variance = 0;
    std::vector<float> ratios;
  };
  std::array<Sums, kProvenances> sums;
  int bounds = 0, kept = 0;
  for (std::size_t i = kSkip; i + kSkip < emitted.frames.size(); ++i) {
    const HdrFrame& frame = emitted.frames[i];
    const Image<float> expected = value_of(truth.radiance(static_cast<int>(i)));
    for (int y = 0; y < expected.rows(); ++y)
      for (int x = 0; x < expected.cols(); ++x) {
        double error = 0;
        bool is_white = false, is_bound = true;
        for (int c = 0; c < 3; ++c) {
          const auto gain = static_cast<float>(scores.shared.gain[static_cast<std::size_t>(c)]);
          const float estimate = gain * frame.radiance.at(c, y, x), actual = expected.at(c, y, x);
          const double e = std::log(static_cast<double>((estimate + dark) / (actual + dark)));
          error += e * e / 3;
          is_white = is_white || actual > 0.9f * white;
          is_bound = is_bound && actual > 0.9f * std::min(estimate, white);
        }
        const std::size_t from = frame.provenance.at(0, y, x);
        if (from == static_cast<std::size_t>(Provenance::Bound)) ++bounds, kept += is_bound ? 1 : 0;
        if (is_white) continue;
        const auto sigma = static_cast<double>(frame.sigma.at(0, y, x));
        sums[from].error += error, sums[from].variance += sigma * sigma;
        sums[from].ratios.push_back(static_cast<float>(error / (sigma * sigma)));
      }
  }
  Calibration calibration;
  for (std::size_t k = 0; k < kProvenances; ++k)
    if (const int pixels = static_cast<int>(sums[k].ratios.size()); pixels >= Calibration::kFewPixels)
      calibration.ratios[k] = {numpy_median(sums[k].ratios), sums[k].error / sums[k].variance, pixels};
  if (bounds > 0) calibration.bounds_kept = static_cast<double>(kept) / bounds;
  return calibration;
}

}  // namespace hdrcam::test
