#include "firmware_host/live/takes.h"

#include <fmt/format.h>

#include "firmware_host/cut_recording.h"
#include "hal/core/counted.h"

namespace hdrcam {

Result<Takes::Created> Takes::create(const CameraFacts& camera) {
  TRY(storage_.make_directories(names_.folder()));
  for (;; ++next_) {
    const std::string path = names_.path(next_);
    auto writer = create_recording(storage_, path, camera, Creation::New, codec_);
    if (writer) return Created{path, std::move(writer).value()};
    if (writer.error().code != ErrorCode::Exists) return writer.error();
  }
}

Error Takes::cut(Error error, std::uint64_t frames) const {
  if (started_.empty()) return error;
  return cut_recording(std::move(error), started_.back().path, frames - started_.back().before);
}

std::string Takes::account(std::uint64_t frames) const {
  std::string text;
  for (auto take = started_.rbegin(); take != started_.rend(); ++take) {
    text.insert(0, fmt::format("{}: {}\n", take->path, counted(frames - take->before, "frame")));
    frames = take->before;
  }
  return text;
}

}  // namespace hdrcam
