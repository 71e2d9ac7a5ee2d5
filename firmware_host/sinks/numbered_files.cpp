#include "firmware_host/sinks/numbered_files.h"

#include <utility>

#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/sinks/frame_pattern.h"

namespace hdrcam {
namespace {

class NumberedFiles : public FrameSink {
 public:
  NumberedFiles(Storage& storage, std::string_view names, FramePattern pattern, WriteFrame write)
      : storage_(storage),
        pattern_(std::move(pattern)),
        write_(std::move(write)),
        earlier_(storage, std::string(names)) {}

  Result<void> emit(const EmittedFrame& frame) override {
    const std::string path = pattern_.path(frame.hdr.facts.sequence);
    if (begun_) return write_(frame, storage_, path);
    TRY(write_first(frame, path));
    begun_ = true;
    return {};
  }

 private:
  // Of two runs that began together with the same names the later one ends here, and replaces no file.
  Result<void> write_first(const EmittedFrame& frame, const std::string& path) {
    FileInMaking making = TRY(FileInMaking::beside_or_through(storage_, path));
    if (!making.is_through()) TRY(earlier_.check_none_came());
    TRY(making.as_asked(write_(frame, storage_, making.path())));
    return making.commit(Durability::WrittenBack, Forestalled::Goes);
  }

  Storage& storage_;
  const FramePattern pattern_;
  const WriteFrame write_;
  const EarlierFrames earlier_;
  bool begun_ = false;
};

}  // namespace

Result<std::unique_ptr<FrameSink>> create_numbered_files(Storage& storage, std::string_view flag,
                                                         std::string_view pattern, std::string_view extension,
                                                         WriteFrame write) {
  auto parsed = TRY(FramePattern::parse(flag, pattern, extension));
  TRY(storage.make_directories(parsed.folder()));
  return std::unique_ptr<FrameSink>(
      std::make_unique<NumberedFiles>(storage, pattern, std::move(parsed), std::move(write)));
}

}  // namespace hdrcam
