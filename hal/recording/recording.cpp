#include "hal/recording/recording.h"

#include <fmt/ranges.h>

#include "hal/core/counted.h"

namespace hdrcam {

std::string_view name(RecordingCodec codec) { return codec == RecordingCodec::Ffv1 ? "ffv1" : "huffyuv"; }

std::string LeftOut::sentence() const {
  if (count == 0 && reason.empty()) return "";
  const char* const end = end_is_missing ? ", and frames may be lost at the end" : "";
  if (count == 0)
    return fmt::format("damaged{} ({})", end_is_missing ? end : ", but no frame is lost", reason);
  return fmt::format("{} left out: {}{}{} ({})", counted(count, "damaged frame"), fmt::join(places, ", "),
                     count > places.size() ? " .." : "", end, reason);
}

std::string told_of_behind(const RecordingReader& reader) {
  const std::uint64_t bytes = reader.bytes_behind();
  if (bytes == 0) return "";
  return fmt::format(
      "another recording, of {0} bytes, follows this one in the file and is not read; 'tail -c {0} FILE > "
      "other.mkv' takes it out",
      bytes);
}

std::vector<std::string> warnings_of(const RecordingReader& reader) {
  std::vector<std::string> warnings{reader.left_out().sentence(), told_of_behind(reader)};
  std::erase(warnings, "");
  return warnings;
}

Error no_whole_frame(const std::string& path) {
  return {ErrorCode::Corrupt, fmt::format("'{}' has no whole frame", path)};
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
