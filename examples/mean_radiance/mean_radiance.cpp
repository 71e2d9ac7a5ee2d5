// mean_radiance RECORDING: sends a recording through the pipeline and prints, for each HDR frame, its time,
// its exposure relative to the clip's reference, and the mean radiance of red, green and blue (1 saturates
// the reference exposure). The exposure changes from frame to frame; the radiance of a steady scene does not.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <numeric>
#include <thread>

#include "firmware_host/run/pipeline.h"
#include "firmware_host/run/recording_source.h"
#include "hal/storage.h"

using namespace hdrcam;

namespace {

double mean_of_plane(const Image<float>& picture, int channel) {
  const float* first = picture.plane(channel);
  return std::accumulate(first, first + picture.plane_size(), 0.0) /
         static_cast<double>(picture.plane_size());
}

Result<void> print(const HdrFrame& frame, const FrameEstimate&, const FrameRecord& record) {
  std::printf("%7.3f s  exposure %7.4f  radiance %.4f %.4f %.4f\n", record.time_s, record.exposure,
              mean_of_plane(frame.radiance, 0), mean_of_plane(frame.radiance, 1),
              mean_of_plane(frame.radiance, 2));
  return {};
}

Result<void> print_radiance_of(const char* recording) {
  const std::atomic<bool> stop{false};
  const auto source = TRY(RecordingSource::open(posix_storage(), recording, {}, stop));
  WorkerPool pool(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  Pipeline pipeline(options_of(Settings(), FieldUse::Fills), source->camera(), pool);
  while (const RawFrame* frame = TRY(source->next())) TRY(pipeline.take(*frame, print));
  return pipeline.finish(print);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: mean_radiance RECORDING\n", stderr);
    return 2;
  }
  const Result<void> done = print_radiance_of(argv[1]);
  if (!done) std::fprintf(stderr, "mean_radiance: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
