// What a run writes into its record (sinks/run_record.h): its settings at the start, one entry per emitted
// frame, and at the end what the method found and how good the frames are; and what it tells the user of its
// outputs. Reentrant.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "firmware_host/run/run.h"
#include "firmware_host/run_pace.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/sinks/run_record.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

class Governor;
class Pipeline;
class VirtualCamera;

// Records of frames that a run keeps, the latest; of a clip all of them, where anything reads them.
constexpr std::size_t kFramesKept = 2048;
std::size_t frames_kept(const RunPlan& plan, RunPace pace);

// With room for the frames of a camera, so that keep() does not allocate there.
RunRecord opened_record(const RunPlan& plan, const CameraFacts& camera, RunPace pace, int threads);

// Counts an emitted frame and returns its entry, valid until the next call. most: frames_kept().
FrameRecord& keep(const FrameRecord& frame, std::size_t most, RunRecord& record);

// How the deadline was held.
void add_deadline(const Governor& governor, RunRecord& record);
// The curves of all channels.
ResponseCurves curves_of(const Response& response);
// The camera parameters that the method estimated.
void add_findings(const Pipeline& pipeline, RunRecord& record);
// How much of a film the field filled.
void add_findings(const VirtualCamera& film, RunRecord& record);
// Interrupted where the user stopped the run before the end of its film.
Result<void> check_not_stopped(const RunPlan& plan, const VirtualCamera& film);
// What lay in the folder of the HDR frames before the run; nothing where none are scored.
struct EarlierEstimates {
  EarlierFrames frames, novel_views;
};
EarlierEstimates earlier_estimates(const RunPlan& plan, Storage& storage);
// The scores of the HDR frames and novel views that the run wrote, where the plan has a clip with ground
// truth; not of `earlier` ones. Errors: those of score_clip.
Result<void> add_scores(const RunPlan& plan, const EarlierEstimates& earlier, Storage& storage,
                        RunRecord& record);
// The frames in order, and what the whole run took. most: as for keep(); wall_s: seconds.
void close_record(std::size_t most, double wall_s, RunRecord& record);
// Whether something went wrong. ^C is none: whatever else went wrong says more.
bool is_failure(const Result<void>& outcome);
// Warns of earlier frames that stayed beside the new ones; and, where somebody follows the run, says where
// its outputs are: `where`, a list.
void tell_of_outputs(const RunPlan& plan, std::span<const EarlierFrames> earlier, std::string_view where);

}  // namespace hdrcam
