// HDR frames as a video: HDR10, HLG, or tone-mapped for displays without HDR. One scale, one shoulder or one
// tone curve for the whole clip; each frame at its sensor time, counted from the first. The file is made
// with the first frame and has its name from then on, because what is cut plays up to the cut
// (hal/video/video_writer.h). Thread-bound.
#pragma once

#include <memory>
#include <string>

#include "firmware_host/sinks/frame_sink.h"
#include "firmware_host/sinks/video_options.h"
#include "hal/storage.h"
#include "hal/video/video_writer.h"

namespace hdrcam {

// Errors: Invalid for options that contradict each other.
Result<void> check_video(const VideoOptions& options);

// Of a video in a file. Errors: Invalid for a rate factor that its codec does not take.
Result<void> check_rate_factor(const VideoOptions& options);

// Whether the codec takes frames of this size. Errors: Unsupported.
Result<void> check_video_size(const VideoOptions& options, int width_px, int height_px);

// path: .mp4, .mov or .mkv; its folder is created. Errors: Invalid for another extension, for options that
// contradict each other and for a codec that such a file does not hold, Permission, NoSpace, Io; with the
// first frame also Unsupported, where the codec refuses it; with a later one SizeChanged.
Result<std::unique_ptr<FrameSink>> create_hdr_video(Storage& storage, const std::string& path,
                                                    double framerate_hz, const VideoOptions& options);

// Of frames that hold display light, 0..1 (render/views/re_exposure.h): SDR, shown as it is.
Result<std::unique_ptr<FrameSink>> create_display_video(Storage& storage, const std::string& path,
                                                        double framerate_hz, VideoOptions options);

// Uncompressed into a pipe, Nut or Y4m: 10 bits, of SDR 8.
Result<std::unique_ptr<FrameSink>> create_video_pipe(std::unique_ptr<StorageFile> pipe, double framerate_hz,
                                                     const VideoOptions& options);

}  // namespace hdrcam
