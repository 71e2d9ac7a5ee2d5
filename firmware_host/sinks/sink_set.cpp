#include "firmware_host/sinks/sink_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "firmware_host/sinks/sink_name.h"
#include "hal/core/counted.h"
#include "hal/core/stopwatch.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

// The standard output takes the frames and nothing else.
Result<void> check_standard_output(std::span<const SinkKind> kinds, const OutputPaths& paths) {
  for (const SinkKind& kind : kinds)
    if (path_in(paths, kind.name) == kStandardOutput && kind.name != sink_name::kFrames)
      return not_to_standard_output(kind.flag);
  return {};
}

// What stands at an output's name: of a model's folder, which is made before its files, at that of its first
// file. Nothing where it cannot be told.
FileFacts standing_at(Storage& storage, const SinkKind& kind, const std::string& path) {
  const bool model = kind.target == SinkTarget::Model;
  const auto facts = storage.look_at(model ? fmt::format("{}/{}", path, kColmapFiles.front()) : path);
  return facts ? facts.value() : FileFacts{};
}

}  // namespace

PicturePatterns patterns_of(const OutputPaths& paths) {
  const std::string& frames = path_in(paths, sink_name::kFrames);
  const bool numbered = FramePattern::is_one(frames);
  return {numbered ? frames : path_in(paths, sink_name::kPreview), path_in(paths, sink_name::kDepth)};
}

Result<SinkSet> SinkSet::open(std::span<const SinkKind> kinds, const OutputPaths& paths,
                              const SinkRequest& request, RunPace pace) {
  TRY(check_standard_output(kinds, paths));
  SinkSet set;
  for (const SinkKind& kind : kinds) {
    Open open{.kind = &kind, .path = path_in(paths, kind.name)};
    if (open.path.empty()) continue;
    if (kind.target != SinkTarget::Address) open.earlier = standing_at(request.storage, kind, open.path);
    SinkRequest its = request;
    its.path = open.path;
    its.patterns = patterns_of(paths);
    open.sink = TRY(kind.open(its));
    if (kind.pace != SinkPace::Light) {
      const bool camera = pace == RunPace::Camera;
      const WhenFull when_full =
          camera && kind.pace == SinkPace::Latest ? WhenFull::DropFrame : WhenFull::Wait;
      auto async = std::make_unique<AsyncSink>(std::move(open.sink), when_full,
                                               camera ? ThreadPriority::Background : ThreadPriority::Usual,
                                               fmt::format("sink {}", kind.name), request.trace);
      open.async = async.get();
      open.sink = std::move(async);
    }
    set.open_.push_back(std::move(open));
  }
  return set;
}

Result<void> SinkSet::emit(const EmittedFrame& frame, Previews previews) {
  for (Open& open : open_) {
    if (previews == Previews::LeftOut && open.kind->pace == SinkPace::Latest) {
      ++open.left_out;
      continue;
    }
    Stopwatch watch;
    const Result<void> done = open.sink->emit(frame);
    open.failed |= !done;
    TRY(done);
    const double ms = watch.lap_ms();
    ++open.here.frames, open.here.total_ms += ms;
    open.here.longest_ms = std::max(open.here.longest_ms, ms);
  }
  return {};
}

Result<void> SinkSet::finish() {
  return each([](FrameSink& sink) { return sink.finish(); });
}

Result<void> SinkSet::conclude(const RunRecord& record) {
  return each([&](FrameSink& sink) { return sink.conclude(record); });
}

Result<void> SinkSet::each(const std::function<Result<void>(FrameSink&)>& work) {
  Result<void> first;
  std::exception_ptr first_thrown;
  for (Open& open : open_) {
    Result<void> done;
    const std::exception_ptr thrown = thrown_by([&] { done = work(*open.sink); });
    open.failed |= !done || thrown != nullptr;
    if (first && first_thrown == nullptr) first = std::move(done), first_thrown = thrown;
  }
  if (first_thrown != nullptr) std::rethrow_exception(first_thrown);
  return first;
}

// A file is replaced by another one (FileInMaking): one of an earlier run that this one left alone is the
// same.
bool SinkSet::is_written(const Open& open, Storage& storage) {
  const FileFacts now = standing_at(storage, *open.kind, open.path);
  return now.kind != FileKind::Missing && (now.kind != FileKind::Regular || !same_file(now, open.earlier));
}

std::string SinkSet::whole_outputs(Storage& storage) const {
  std::string text;
  for (const Open& open : open_) {
    if (open.kind->target == SinkTarget::Address || open.path == kStandardOutput) continue;
    const SinkTimes times = times_of(open);
    const bool numbered = open.kind->extension != nullptr && FramePattern::is_one(open.path);
    const bool some = times.frames + times.left_out > 0;
    if (numbered ? !some : open.failed || !is_written(open, storage)) continue;
    text += numbered ? fmt::format("{}: {}", open.path, counted(times.frames, "frame")) : open.path;
    if (numbered && times.left_out > 0) text += fmt::format(", {} left out to keep up", times.left_out);
    text += '\n';
  }
  return text;
}

bool SinkSet::has_previews() const {
  return std::ranges::any_of(open_, [](const Open& open) { return open.kind->pace == SinkPace::Latest; });
}

SinkTimes SinkSet::times_of(const Open& open) {
  SinkTimes times = open.async != nullptr ? open.async->times() : open.here;
  times.name = open.kind->name;
  times.left_out += open.left_out;
  return times;
}

std::vector<SinkTimes> SinkSet::times() const {
  std::vector<SinkTimes> all;
  all.reserve(open_.size());
  for (const Open& open : open_) all.push_back(times_of(open));
  return all;
}

}  // namespace hdrcam
