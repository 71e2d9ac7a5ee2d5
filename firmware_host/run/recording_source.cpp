#include "firmware_host/run/recording_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdrcam {
namespace {

class RecordingSource : public FrameSource {
 public:
  RecordingSource(std::unique_ptr<RecordingReader> reader, int most, const std::atomic<bool>& stop)
      : reader_(std::move(reader)), most_(most), stop_(stop) {}

  const CameraFacts& camera() const override { return reader_->camera(); }
  RunPace pace() const override { return RunPace::Clip; }
  std::optional<int> frame_count() const override {
    const std::optional<int> all = reader_->frame_count();
    if (most_ == 0) return all;
    return all ? std::min(*all, most_) : most_;
  }

  Result<const RawFrame*> next() override {
    if (most_ > 0 && read_ == most_) return nullptr;
    if (stop_) {
      end_ = Error{ErrorCode::Interrupted, fmt::format("stopped after {} frames; they are complete", read_)};
      return nullptr;
    }
    auto next = reader_->next();
    if (!next && next.error().code == ErrorCode::Truncated && read_ > 0) {
      end_ = next.error();
      return nullptr;
    }
    frame_ = TRY(std::move(next));
    if (!frame_) return nullptr;
    ++read_;
    return &*frame_;
  }

  Result<void> finish(RunRecord&) override { return end_; }

 private:
  const std::unique_ptr<RecordingReader> reader_;
  const int most_;
  const std::atomic<bool>& stop_;
  std::optional<RawFrame> frame_;
  int read_ = 0;
  Result<void> end_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_recording_source(Storage& storage, const std::string& path,
                                                           int frames, const std::atomic<bool>& stop) {
  auto reader = TRY(open_recording(storage, path));
  return std::unique_ptr<FrameSource>(std::make_unique<RecordingSource>(std::move(reader), frames, stop));
}

}  // namespace hdrcam
