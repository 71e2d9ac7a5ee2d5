#include "firmware_host/run/recording_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "firmware_host/cut_recording.h"
#include "hal/core/counted.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {

Result<std::unique_ptr<RecordingSource>> RecordingSource::open(Storage& storage, const std::string& path,
                                                               const RecordingSourceOptions& options,
                                                               const std::atomic<bool>& stop) {
  auto recording = TRY(RecordingStage::open(storage, path, options.contradiction, options.black_level));
  std::unique_ptr<RecordingWriter> copy;
  if (!options.copy_to.empty())
    copy = TRY(create_recording(storage, options.copy_to, recording->camera(), Creation::Replace,
                                options.copy_codec));
  return std::unique_ptr<RecordingSource>(
      new RecordingSource(path, std::move(recording), std::move(copy), options, stop));
}

std::unique_ptr<RecordingSource> RecordingSource::of(std::unique_ptr<RecordingReader> frames,
                                                     const RecordingSourceOptions& options,
                                                     const std::atomic<bool>& stop) {
  auto recording =
      std::make_unique<RecordingStage>(std::move(frames), options.contradiction, options.black_level);
  return std::unique_ptr<RecordingSource>(
      new RecordingSource("", std::move(recording), nullptr, options, stop));
}

RecordingSource::~RecordingSource() {
  if (copy_) (void)thrown_by([this] { (void)copy_->finish(); });
}

std::optional<int> RecordingSource::frame_count() const {
  const std::optional<int> all = recording_->frame_count();
  if (options_.frames == 0) return all;
  return all ? std::min(*all, options_.frames) : options_.frames;
}

Result<const RawFrame*> RecordingSource::next() {
  if (options_.frames > 0 && read_ == options_.frames) return nullptr;
  if (options_.timeout > Duration::zero() && posix_clock().now() - begin_ >= options_.timeout) {
    timed_out_ = true;
    return nullptr;
  }
  if (stop_) {
    end_ = Error{
        ErrorCode::Interrupted,
        fmt::format("stopped after {}; the files that were written are complete", counted(read_, "frame"))};
    return nullptr;
  }
  auto more = recording_->next(frame_);
  if (!more && more.error().code == ErrorCode::Truncated && read_ > 0) {
    end_ = read_to_cut(more.error(), path_);
    return nullptr;
  }
  if (!TRY(std::move(more))) return nullptr;
  if (copy_) TRY(or_cut(copy_->append(frame_.raw)));
  ++read_;
  if ((frame_.raw.facts.flags & kFrameExposureUnproved) != 0) ++kept_out_;
  return &frame_.raw;
}

std::vector<std::string> RecordingSource::warnings() const {
  std::vector<std::string> all = recording_->warnings();
  if (left_out_ > 0)
    all.push_back(fmt::format("{} of {} {} left out to hold the deadline; give a longer --deadline, or none",
                              left_out_, counted(read_, "frame"), left_out_ == 1 ? "was" : "were"));
  return all;
}

// The outcome of writing the copy. Where it failed the copy has no end.
Result<void> RecordingSource::or_cut(Result<void> wrote) const {
  if (wrote) return wrote;
  return cut_recording(wrote.error(), options_.copy_to, static_cast<std::uint64_t>(read_));
}

Result<void> RecordingSource::finish(RunRecord& record) {
  const CaptureCounters counters = recording_->counters();
  record.notes.push_back(proof_of(counters));
  if (counters.damaged > 0) {
    record.counters.push_back({"dropped.damaged", static_cast<double>(counters.damaged)});
    record.captured += static_cast<int>(counters.damaged);
    record.dropped += static_cast<int>(counters.damaged);
  }
  for (std::string& warning : recording_->warnings()) record.notes.push_back(std::move(warning));
  if (copy_) TRY(or_cut(copy_->finish()));
  const bool too_few = kept_out_ > 0 && read_ >= 2 && read_ - kept_out_ < 2;
  if (!too_few || !end_) return end_;
  return Error{
      ErrorCode::BadExposure,
      fmt::format("{} came, and {} kept out of the fit, because {}", counted(read_, "frame"),
                  kept_out_ == read_ ? "all are" : fmt::format("{} are", kept_out_),
                  counters.contradicted > 0
                      ? "the pictures contradict their exposures; correct each exposure_s, or import the "
                        "pictures with --shutter"
                      : "their exposures are unknown, and the pictures do not tell them; export them, and "
                        "import the pictures alone with --shutter")};
}

}  // namespace hdrcam
