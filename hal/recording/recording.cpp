#include "hal/recording/recording.h"

namespace hdrcam {

Result<std::optional<FrameFacts>> RecordingReader::next_facts() {
  auto frame = TRY(next());
  if (!frame) return std::optional<FrameFacts>();
  return std::optional<FrameFacts>(std::move(frame->facts));
}

}  // namespace hdrcam
