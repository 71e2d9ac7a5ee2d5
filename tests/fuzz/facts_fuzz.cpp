// The facts of a recording as text, behind their checksum, which no fuzzer guesses: what parses is written
// and parses again to the same.
#include <string_view>

#include "hal/core/sound_facts.h"
#include "hal/recording/facts_json.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  (void)seal_holds(text, {});
  if (const auto camera = camera_from_json(text)) {
    (void)objection_to(camera.value());
    HDRCAM_CHECK(camera_from_json(to_json(camera.value(), RecordingCodec::Huffyuv)).ok());
  }
  constexpr int kBits = 12;
  if (const auto record = record_from_json(text, kBits); record && !record.value().is_end) {
    (void)objection_to(record.value().facts, nullptr);
    const auto again = record_from_json(to_json(record.value().index, record.value().facts, kBits), kBits);
    HDRCAM_CHECK(again.ok());
    HDRCAM_CHECK(again.value().facts.sequence == record.value().facts.sequence);
  }
  return 0;
}
