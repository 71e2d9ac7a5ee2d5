// A recording: opened, listed and read, both ways to meet damage. A frame that comes out has its promised
// size, and with damage skipped no error but that of a cut file ends it.
#include "hal/recording/recording.h"
#include "tests/fuzz/memory_storage.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::MemoryStorage storage({data, size});
  for (const Damage damage : {Damage::Ends, Damage::IsSkipped}) {
    auto reader = open_recording(storage, "x.mkv", damage);
    if (!reader) continue;
    const CameraFacts& camera = reader.value()->camera();
    if (camera.width > 512 || camera.height > 512) continue;  // memory is not what is looked for
    std::optional<FrameFacts> before;
    for (;;) {
      auto frame = reader.value()->next();
      if (!frame) HDRCAM_CHECK(damage == Damage::Ends || frame.error().code != ErrorCode::Corrupt);
      if (!frame || !frame.value()) break;
      const RawFrame& raw = **frame;
      HDRCAM_CHECK_EQ(raw.codes.rows(), camera.height);
      HDRCAM_CHECK_EQ(raw.codes.cols(), camera.width);
      if (before)
        HDRCAM_CHECK(raw.facts.timestamp > before->timestamp && raw.facts.sequence > before->sequence);
      before = raw.facts;
    }
  }
  return 0;
}
