// A clip.json: what is accepted is sound, and is accepted again once it was written.
#include <string>

#include "hal/core/sound_facts.h"
#include "hal/recording/clip_json.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto clip = clip_from_json(std::string(reinterpret_cast<const char*>(data), size), "clip.json");
  if (!clip) return 0;
  const FrameFacts* before = nullptr;
  for (const ClipFrame& frame : clip.value().frames) {
    HDRCAM_CHECK(!objection_to(frame.facts, before));
    before = &frame.facts;
  }
  const auto again = clip_from_json(clip_to_json(clip.value()), "clip.json");
  HDRCAM_CHECK(again.ok());
  HDRCAM_CHECK_EQ(again.value().frames.size(), clip.value().frames.size());
  return 0;
}
