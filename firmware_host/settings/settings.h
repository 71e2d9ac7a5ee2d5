// The settings of a run. Every setting has a working default, a key in a TOML file and a flag; one list of
// fields (setting_fields.h) defines all three, the help and the printed configuration. Plain value: a setting
// that is one of several words is an enum here, checked when it was read.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "capture/exposure_limits.h"
#include "capture/frame_matcher.h"
#include "firmware_host/log_format.h"
#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/output_paths.h"
#include "firmware_host/sinks/video_options.h"
#include "hal/camera.h"
#include "hal/recording/recording.h"
#include "hal/replay/replay_pace.h"
#include "hal/trigger_line.h"
#include "online/knobs.h"
#include "render/render_stage.h"

namespace hdrcam {

// What a driver's timestamp marks.
enum class StampMeaning { AsDriverSays, ExposureBegin, ExposureEnd };

// Of EXR files. Auto: the smallest files, beside a camera those that take the least time.
enum class FrameCompression { Auto, None, Rle, Zip, Piz };

// The word for a time that is not wanted.
inline constexpr std::string_view kOff = "off";

struct Settings {
  struct Camera {
    std::string id;             // "": the only camera; a device, "sim:SCENE", "replay:FILE"
    std::string format;         // "": the highest bit depth available in a set size; or a name as "YUYV"
    int width = 0, height = 0;  // pixels; 0: the largest of up to 640x480
    double framerate_hz = 0;    // 0: the camera's default, or 30
    int buffers = 8;            // queued capture requests, 4..32
    std::string control_delay;  // "": as the driver reports; "2,1": frames, of exposure and gain
    double black_level = -1;    // codes of 255, of raw formats; -1: the camera's or the table's of sensors
    StampMeaning timestamp = StampMeaning::AsDriverSays;
    std::optional<YuvRange> yuv_range;            // none: as the camera states it
    ReplayPace pace = ReplayPace::AsFastAsAsked;  // of a replayed camera
  } camera;
  struct Schedule {
    std::string shutter = "1ms,4ms,16ms";  // the cycle, 1 to 4 times
    std::string gain;                      // analogue gains of the cycle, or one for all; "": usual_gain()
    Adapt adapt = Adapt::Off;              // what the cycle follows while it runs
    Mains mains = Mains::Off;              // mains frequency (anti-flicker)
  } schedule;
  struct Sync {
    std::string line;  // "": none; "gpiochip0:17" or a line's name: strobe edges; "sim", as trigger_line
    StrobePulse strobe = StrobePulse::MarksFrame;
    std::string strobe_delay = "0us";  // from the driver's timestamp to the pulse's edge; may be negative
    bool active_low = false;
    std::string trigger_line;  // "": none; a GPIO line, or "sim": the wire of a simulated camera
    TriggerMode trigger = TriggerMode::Off;
    std::string trigger_width = "200us";  // of pulses that only start a frame
    std::string trigger_gap = "1ms";      // between pulses, at least
    std::string trigger_tolerance = "500us";
    bool trigger_active_low = false;
  } sync;
  struct Fit {
    std::string deadline;  // per frame; "": a camera's frame interval, none of a recording; "33ms"; kOff
    Preset preset = Preset::Balanced;
    EmitLayer emit = EmitLayer::Merged;
    int threads = 0;              // 0: all processors
    std::string readout;          // of a rolling shutter; "": as the frames state it; "12ms"; kOff
    std::string backend = "cpu";  // or "vulkan", "vulkan:NAME": the compute device (run/backend.h)
    int seed = 1;                 // of the fit's random rays
    // Knobs of the method (online/knobs.h) that were set, by name, also those with a flag of their own:
    // --lookahead. All others have the preset's values.
    std::map<std::string, std::string> knobs;
  } fit;
  struct Output {
    static constexpr const char* kSnapshot = "snapshot";  // among the paths: that of the saved scene
    OutputPaths paths;
    ExrLayers layers;
    FrameCompression compression = FrameCompression::Auto;
    std::string white_balance = "none";  // or "camera", or gains "2,1,1.5" (render/white_balance.h)
    std::string http_token;              // of the live view's actions; "": made at the start
    std::string http_takes;              // recordings that its page starts: "takes/%03d.mkv"; "": none

    // "" where it is not wanted.
    const std::string& path(std::string_view sink) const { return path_in(paths, sink); }
  } output;
  VideoOptions video;  // of every output that is a video
  struct Record {
    std::string file;  // the raw recording
    RecordingCodec codec = RecordingCodec::Huffyuv;
    int memory_mib = 256;  // for frames that wait for the disk, 1..65536
  } record;
  struct Machine {
    int memory_mib = 0;  // of the whole run, estimated before it starts; 0: half of the machine's
    LogFormat log_format = LogFormat::Text;
    std::string trace;  // a file; "": none
  } machine;
};

// The number of threads; by default one for each processor.
int thread_count(const Settings::Fit& fit);

// Which settings a verb takes.
enum class SettingGroup { Camera, Schedule, Sync, Fit, Knobs, Output, Record, Machine };

}  // namespace hdrcam
