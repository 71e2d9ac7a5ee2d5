#include "firmware_host/sinks/numbered_files.h"

#include <utility>

#include "firmware_host/sinks/frame_pattern.h"

namespace hdrcam {
namespace {

class NumberedFiles : public FrameSink {
 public:
  NumberedFiles(Storage& storage, FramePattern pattern, WriteFrame write)
      : storage_(storage), pattern_(std::move(pattern)), write_(std::move(write)) {}

  Result<void> emit(const EmittedFrame& frame) override {
    return write_(frame, storage_, pattern_.path(frame.hdr.facts.sequence));
  }

 private:
  Storage& storage_;
  const FramePattern pattern_;
  const WriteFrame write_;
};

}  // namespace

Result<std::unique_ptr<FrameSink>> create_numbered_files(Storage& storage, std::string_view flag,
                                                         std::string_view pattern, std::string_view extension,
                                                         WriteFrame write) {
  auto parsed = TRY(FramePattern::parse(flag, pattern, extension));
  TRY(storage.make_directories(parsed.folder()));
  return std::unique_ptr<FrameSink>(
      std::make_unique<NumberedFiles>(storage, std::move(parsed), std::move(write)));
}

}  // namespace hdrcam
