#include "firmware_host/sinks/sink_set.h"

#include <algorithm>
#include <utility>

#include "hal/core/stopwatch.h"

namespace hdrcam {
namespace {

using Paths = std::map<std::string, std::string, std::less<>>;

std::string path_in(const Paths& paths, std::string_view sink) {
  const auto path = paths.find(sink);
  return path == paths.end() ? std::string() : path->second;
}

// The HDR frames where they are pictures, else the previews.
PicturePatterns patterns_of(const Paths& paths) {
  const std::string frames = path_in(paths, "frames");
  const bool numbered = frames.find('%') != std::string::npos;
  return {numbered ? frames : path_in(paths, "preview"), path_in(paths, "depth")};
}

}  // namespace

Result<SinkSet> SinkSet::open(std::span<const SinkKind> kinds,
                              const std::map<std::string, std::string, std::less<>>& paths,
                              const SinkRequest& request, RunPace pace) {
  SinkSet set;
  for (const SinkKind& kind : kinds) {
    const auto path = paths.find(kind.name);
    if (path == paths.end() || path->second.empty()) continue;
    Open open{.name = kind.name, .pace = kind.pace};
    SinkRequest its = request;
    its.path = path->second;
    its.patterns = patterns_of(paths);
    open.sink = TRY(kind.open(its));
    if (kind.pace != SinkPace::Light) {
      const bool camera = pace == RunPace::Camera;
      const WhenFull when_full =
          camera && kind.pace == SinkPace::Latest ? WhenFull::DropFrame : WhenFull::Wait;
      auto async = std::make_unique<AsyncSink>(std::move(open.sink), when_full,
                                               camera ? ThreadPriority::Background : ThreadPriority::Usual,
                                               std::string("sink ") + kind.name, request.trace);
      open.async = async.get();
      open.sink = std::move(async);
    }
    set.open_.push_back(std::move(open));
  }
  return set;
}

Result<void> SinkSet::emit(const EmittedFrame& frame, Previews previews) {
  for (Open& open : open_) {
    if (previews == Previews::LeftOut && open.pace == SinkPace::Latest) {
      ++open.left_out;
      continue;
    }
    Stopwatch watch;
    TRY(open.sink->emit(frame));
    const double ms = watch.lap_ms();
    ++open.here.frames, open.here.total_ms += ms;
    open.here.longest_ms = std::max(open.here.longest_ms, ms);
  }
  return {};
}

Result<void> SinkSet::finish() {
  Result<void> first;
  for (Open& open : open_)
    if (Result<void> finished = open.sink->finish(); first && !finished) first = std::move(finished);
  return first;
}

Result<void> SinkSet::conclude(const RunRecord& record) {
  for (Open& open : open_) TRY(open.sink->conclude(record));
  return {};
}

bool SinkSet::has_previews() const {
  return std::ranges::any_of(open_, [](const Open& open) { return open.pace == SinkPace::Latest; });
}

std::vector<SinkTimes> SinkSet::times() const {
  std::vector<SinkTimes> all;
  for (const Open& open : open_) {
    all.push_back(open.async != nullptr ? open.async->times() : open.here);
    all.back().name = open.name;
    all.back().left_out += open.left_out;
  }
  return all;
}

}  // namespace hdrcam
