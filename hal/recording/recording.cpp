#include "hal/recording/recording.h"

#include <fmt/ranges.h>

namespace hdrcam {

std::string_view name(RecordingCodec codec) { return codec == RecordingCodec::Ffv1 ? "ffv1" : "huffyuv"; }

std::string LeftOut::sentence() const {
  if (count == 0) return reason.empty() ? "" : fmt::format("damaged, but no frame is lost ({})", reason);
  return fmt::format("{} damaged frame(s) left out: {}{} ({})", count, fmt::join(places, ", "),
                     count > places.size() ? " .." : "", reason);
}

const LeftOut& RecordingReader::left_out() const {
  static const LeftOut none;
  return none;
}

Result<std::optional<FrameFacts>> RecordingReader::next_facts() {
  auto frame = TRY(next());
  if (!frame) return std::optional<FrameFacts>();
  return std::optional<FrameFacts>(frame->facts);
}

}  // namespace hdrcam
