#include "firmware_host/settings/setting_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "capture/control_latency.h"
#include "firmware_host/settings/member_fields.h"
#include "firmware_host/sinks/sink_table.h"
#include "hal/core/parse_number.h"
#include "hal/video/video_writer.h"

namespace hdrcam {
namespace {

using namespace member_fields;

SettingField path_of(const std::string& name, const char* flag, const char* about) {
  SettingField field;
  field.key = "output." + name, field.flag = flag, field.about = about, field.unset = "none";
  field.names_file = true;
  field.read = [name](const Settings& s) -> SettingValue { return s.output.path(name); };
  field.write = [name](Settings& s, const SettingValue& path) {
    s.output.paths[name] = std::get<std::string>(path);
  };
  return field;
}

SettingField path_of(const SinkKind& sink) {
  SettingField field = path_of(std::string(sink.name), sink.flag, sink.about);
  field.names_file = sink.target != SinkTarget::Address;
  return field;
}

SettingField field_of(const Knob& knob) {
  SettingField field;
  field.type = SettingType::Knob;
  field.key = "knobs." + knob.name, field.unset = "as the preset has it";
  field.about = fmt::format("{}; costs: {}", knob.gives, knob.costs);
  field.knob = &knob;
  field.read = [name = knob.name](const Settings& s) -> SettingValue {
    const auto set = s.fit.knobs.find(name);
    return set == s.fit.knobs.end() ? std::string() : set->second;
  };
  field.write = [name = knob.name](Settings& s, const SettingValue& value) {
    const auto& text = std::get<std::string>(value);
    if (text.empty())
      s.fit.knobs.erase(name);
    else
      s.fit.knobs[name] = text;
  };
  return field;
}

// A flag of its own for a number among the knobs. otherwise: stands for the value of the preset.
template <class T>
SettingField flag_of_knob(const char* knob, const char* key, const char* flag, const char* about,
                          SettingRange range, T otherwise, const char* unset = "") {
  SettingField field;
  field.type = kTypeOf<T>;
  field.key = key, field.flag = flag, field.about = about, field.unset = unset;
  field.range = range;
  const auto found = std::ranges::find(knob_table(), knob, &Knob::name);
  HDRCAM_CHECK(found != knob_table().end());
  field.knob = &*found;
  field.read = [knob, otherwise](const Settings& s) -> SettingValue {
    const auto set = s.fit.knobs.find(knob);
    return set == s.fit.knobs.end() ? otherwise : parse_number<T>(set->second).value_or(otherwise);
  };
  field.write = [knob, otherwise](Settings& s, const SettingValue& value) {
    if (std::get<T>(value) == otherwise)
      s.fit.knobs.erase(knob);
    else
      s.fit.knobs[knob] = to_text(value);
  };
  return field;
}

std::vector<SettingField> camera_fields() {
  using C = Settings::Camera;
  using enum StampMeaning;
  constexpr auto kGroup = &Settings::camera;
  return {
      any<kGroup, &C::id>("camera.id", "--camera", "a device, sim:SCENE or replay:FILE", "the only camera"),
      any<kGroup, &C::format>("camera.format", "--format", "pixel format, such as YUYV",
                              "highest bit depth available in a size that is set"),
      number<kGroup, &C::width>("camera.width", "--width", "picture width in pixels", {16, 65535, 0},
                                "the largest of up to 640x480"),
      number<kGroup, &C::height>("camera.height", "--height", "picture height in pixels", {16, 65535, 0},
                                 "the largest of up to 640x480"),
      number<kGroup, &C::framerate_hz>("camera.framerate", "--framerate",
                                       "frames per second of the camera, or of files that state no time",
                                       {0.1, 1000, 0}, "the camera's default, or 30"),
      number<kGroup, &C::buffers>("camera.buffers", "--buffers", "queued capture requests",
                                  {4, kMostBuffers, {}}),
      list<kGroup, &C::control_delay>("camera.control_delay", "--control-delay",
                                      "exposure,gain control latency in frames, such as 2,1, or one for both",
                                      "as the driver reports"),
      number<kGroup, &C::black_level>("camera.black_level", "--black-level",
                                      "black level of raw formats, in codes of 255 (the scale of 8 bits)",
                                      {0, 254, -1}, "as the camera states it, or from the table of sensors"),
      choice<kGroup, &C::timestamp>(
          "camera.timestamp", "--timestamp",
          "what the timestamp marks: start or end of exposure, or what the driver reports",
          {{"driver", AsDriverSays}, {"begin", ExposureBegin}, {"end", ExposureEnd}}),
      choice<kGroup, &C::yuv_range>(
          "camera.yuv_range", "--yuv-range",
          "luma range of YUV formats: limited is 16..235, full is 0..255, or what the driver reports",
          {{"driver", std::nullopt}, {"limited", YuvRange::Limited}, {"full", YuvRange::Full}}),
      choice<kGroup, &C::pace>("camera.pace", "--pace",
                               "pace of replay:FILE: as fast as the fit or the recording takes its frames, "
                               "or in real time, as from a camera",
                               {{"fit", ReplayPace::AsFastAsAsked}, {"realtime", ReplayPace::AsRecorded}}),
  };
}

std::vector<SettingField> schedule_fields() {
  using S = Settings::Schedule;
  constexpr auto kGroup = &Settings::schedule;
  return {
      times<kGroup, &S::shutter>("schedule.shutter", "--shutter",
                                 "the cycle of 1 to 4 exposure times, such as 250us, 4ms or 1/60"),
      list<kGroup, &S::gain>("schedule.gain", "--gain", "analogue gain of each exposure, or one for all",
                             "1, or the sensor's least"),
      choice<kGroup, &S::adapt>(
          "schedule.adapt", "--adapt",
          "what the cycle follows: the light (shortest exposure keeps the highlights, longest the shadows), "
          "or the error that the fit expects of noise, clipping and motion blur",
          {{"off", Adapt::Off}, {"light", Adapt::Light}, {"motion", Adapt::Motion}}),
      choice<kGroup, &S::mains>("schedule.mains", "--mains",
                                "mains frequency in Hz (anti-flicker): long exposures become whole multiples "
                                "of half a mains period",
                                {{"off", Mains::Off}, {"50", Mains::Hz50}, {"60", Mains::Hz60}}),
  };
}

std::vector<SettingField> sync_fields() {
  using S = Settings::Sync;
  constexpr auto kGroup = &Settings::sync;
  return {
      any<kGroup, &S::line>("sync.line", "--sync-line",
                            "GPIO line of the strobe: gpiochip0:17, its name, or sim", "none"),
      choice<kGroup, &S::strobe>(
          "sync.strobe", "--strobe", "what a strobe pulse does: marks the frame, or spans the exposure",
          {{"frame", StrobePulse::MarksFrame}, {"exposure", StrobePulse::SpansExposure}}),
      delay<kGroup, &S::strobe_delay>(
          "sync.strobe_delay", "--strobe-delay",
          "time from the driver's timestamp to the pulse's rising edge, or to its falling edge where it "
          "spans the exposure and the timestamp marks the end: 250us, -2ms or 0"),
      any<kGroup, &S::active_low>("sync.active_low", "--sync-active-low", "the strobe is active low"),
      any<kGroup, &S::trigger_line>(
          "sync.trigger_line", "--trigger-line",
          "GPIO line that triggers the sensor: gpiochip0:17, its name, or sim for a simulated camera",
          "none"),
      choice<kGroup, &S::trigger>(
          "sync.trigger", "--trigger",
          "what a trigger pulse does: starts a frame, or is as wide as the exposure (external trigger mode)",
          {{"off", TriggerMode::Off},
           {"fsync", TriggerMode::FrameStart},
           {"pulse-width", TriggerMode::PulseWidth}}),
      time<kGroup, &S::trigger_width>("sync.trigger_width", "--trigger-width",
                                      "width of a pulse that starts a frame"),
      time<kGroup, &S::trigger_gap>("sync.trigger_gap", "--trigger-gap",
                                    "minimum time between two trigger pulses, in which the sensor reads out"),
      time<kGroup, &S::trigger_tolerance>(
          "sync.trigger_tolerance", "--trigger-tolerance",
          "a trigger pulse whose edge is later than this is late, and its frame is flagged"),
      any<kGroup, &S::trigger_active_low>("sync.trigger_active_low", "--trigger-active-low",
                                          "the trigger line is active low"),
  };
}

SettingField deadline_field() {
  SettingField field = any<&Settings::fit, &Settings::Fit::deadline>(
      "fit.deadline", "--deadline",
      "time for the work on a frame; to hold it, quality is shed, then HDR frames, never captured ones",
      "the frame interval of a camera, none for a recording");
  field.type = SettingType::TimeOrOff;
  return field;
}

SettingField readout_field() {
  SettingField field = any<&Settings::fit, &Settings::Fit::readout>(
      "fit.readout", "--readout", "read-out time of all rows of a rolling shutter; its skew is corrected",
      "as the camera or the recording states it");
  field.type = SettingType::TimeOrOff;
  return field;
}

SettingField backend_field() {
  SettingField field = any<&Settings::fit, &Settings::Fit::backend>(
      "fit.backend", "--backend",
      "compute device: the processor, or a graphics device that 'hdrcam list' shows");
  field.type = SettingType::Choice;
  field.choices = {"cpu", "vulkan", "vulkan:NAME"};
  return field;
}

std::vector<SettingField> fit_fields() {
  using F = Settings::Fit;
  constexpr auto kGroup = &Settings::fit;
  return {
      choice<kGroup, &F::preset>("fit.preset", "--preset", "quality against time; realtime has no field",
                                 {{"realtime", Preset::Realtime},
                                  {"fast", Preset::Fast},
                                  {"balanced", Preset::Balanced},
                                  {"best", Preset::Best}}),
      choice<kGroup, &F::emit>(
          "fit.emit", "--emit",
          "what HDR frames show: the state (radiance of each pixel) with the field (radiance in space) "
          "fitted beside it, the state alone, or the field alone",
          {{"merged", EmitLayer::Merged}, {"state", EmitLayer::State}, {"field", EmitLayer::Field}}),
      deadline_field(),
      flag_of_knob("look_ahead", "fit.lookahead", "--lookahead", "later frames that an HDR frame waits for",
                   {0, 2, -1}, -1, "those of the preset"),
      number<kGroup, &F::threads>("fit.threads", "--threads", "worker threads", {1, 256, 0},
                                  "all processors"),
      readout_field(),
      backend_field(),
      number<kGroup, &F::seed>("fit.seed", "--seed", "seed of the fit's random rays", {0, kUnlimited, {}}),
      flag_of_knob(
          "code_noise", "fit.code_noise", "--code-noise",
          "start value of the estimated compression noise, codes rms: 0.1 uncompressed, 1 to 2 compressed",
          {0, 20, {}}, 1.0),
  };
}

std::vector<SettingField> knob_fields() {
  std::vector<SettingField> fields;
  for (const Knob& knob : knob_table()) fields.push_back(field_of(knob));
  return fields;
}

std::vector<SettingField> video_fields() {
  using V = VideoOptions;
  using enum VideoTransfer;
  using enum PipeFormat;
  constexpr auto kGroup = &Settings::video;
  return {
      choice<kGroup, &V::transfer>(
          "video.transfer", "--transfer",
          "transfer curve of videos: HDR10, hybrid log-gamma, or tone-mapped for SDR displays",
          {{"pq", Pq}, {"hlg", Hlg}, {"sdr", Sdr}}),
      choice<kGroup, &V::codec>("video.codec", "--codec", "codec of videos; auto: h264 for sdr, else hevc",
                                {{"auto", CodecChoice::Suitable},
                                 {"hevc", CodecChoice::Hevc},
                                 {"av1", CodecChoice::Av1},
                                 {"h264", CodecChoice::H264}}),
      number<kGroup, &V::white_nits>("video.white", "--white", "luminance of radiance 1 in HDR videos, cd/m2",
                                     {1, 10000, {}}),
      number<kGroup, &V::peak_nits>(
          "video.peak", "--peak",
          "peak luminance of HDR videos, cd/m2; brighter light is compressed below it", {100, 10000, {}}),
      number<kGroup, &V::crf>("video.crf", "--crf",
                              "constant rate factor of videos: a lower one is better and takes more space; "
                              "hevc and h264 end at 51",
                              {0, greatest_crf(VideoCodec::Av1), {}}),
      choice<kGroup, &V::pipe>(
          "video.pipe_format", "--pipe-format",
          "format of frames on the standard output: uncompressed video, or bare half-float RGB radiance",
          {{"nut", Nut}, {"y4m", Y4m}, {"half", Half}}),
  };
}

SettingField white_balance_field() {
  SettingField field = list<&Settings::output, &Settings::Output::white_balance>(
      "output.white_balance", "--white-balance",
      "white balance of all outputs: the sensor's own colours, white as the camera's file states it, or "
      "given gains");
  field.type = SettingType::Gains;
  field.choices = {"none", "camera"};
  return field;
}

// First the path of each sink and of the snapshot, then the settings of the frames.
std::vector<SettingField> output_fields() {
  using O = Settings::Output;
  using L = ExrLayers;
  constexpr auto kGroup = &Settings::output;
  std::vector<SettingField> fields;
  for (const SinkKind& sink : sink_kinds()) fields.push_back(path_of(sink));
  fields.push_back(path_of(
      O::kSnapshot, "--snapshot",
      "the scene of the last frames, for 'hdrcam render' to film without the recording: scene.hdrscene"));
  fields.push_back(words<kGroup, &O::layers>(
      "output.layers", "--layers",
      "more EXR channels; flow is the state's motion to the previous frame, field_flow the field's", "none",
      {{"depth", &L::depth},
       {"flow", &L::flow},
       {"flow_forward", &L::flow_forward},
       {"field_flow", &L::field_flow},
       {"field_flow_forward", &L::field_flow_forward},
       {"confidence", &L::confidence},
       {"provenance", &L::provenance}}));
  using C = FrameCompression;
  fields.push_back(choice<kGroup, &O::compression>(
      "output.compression", "--compression",
      "compression of the EXR files, all without loss: piz is the smallest, rle takes a third of its time; "
      "auto: piz, or none in a run at a camera's pace",
      {{"auto", C::Auto}, {"piz", C::Piz}, {"zip", C::Zip}, {"rle", C::Rle}, {"none", C::None}}));
  fields.push_back(white_balance_field());
  fields.push_back(any<kGroup, &O::http_token>(
      "output.http_token", "--http-token", "token that actions on the live page need, 8 characters or more",
      "made at the start"));
  fields.back().secret = true;
  fields.push_back(file<kGroup, &O::http_takes>(
      "output.http_record", "--http-record", "recordings that the live page starts: takes/%03d.mkv", "none"));
  for (SettingField& field : video_fields()) fields.push_back(std::move(field));
  return fields;
}

std::vector<SettingField> record_fields() {
  using R = Settings::Record;
  constexpr auto kGroup = &Settings::record;
  return {
      file<kGroup, &R::file>("record.file", "--record",
                             "the raw recording to write: walk.mkv; {start} becomes the time of the start",
                             "none"),
      choice<kGroup, &R::codec>(
          "record.codec", "--record-codec",
          "lossless codec of the recording: huffyuv takes a fifth of the time, ffv1 a fifth less space",
          {{"huffyuv", RecordingCodec::Huffyuv}, {"ffv1", RecordingCodec::Ffv1}}),
      number<kGroup, &R::memory_mib>("record.memory_mib", "--record-memory",
                                     "memory for frames that wait for the disk, MiB", {1, 65536, {}, "MiB"}),
  };
}

std::vector<SettingField> machine_fields() {
  using M = Settings::Machine;
  constexpr auto kGroup = &Settings::machine;
  return {
      number<kGroup, &M::memory_mib>("machine.memory_mib", "--memory",
                                     "most memory that the run may need, MiB, estimated before it starts",
                                     {64, 1 << 24, 0, "MiB"}, "half of the machine's"),
      choice<kGroup, &M::log_format>(
          "machine.log_format", "--log-format",
          "format of progress, remarks and errors: text, or one JSON object a line",
          {{"text", LogFormat::Text}, {"json", LogFormat::Json}}),
      file<kGroup, &M::trace>("machine.trace", "--trace",
                              "what each thread did when, for ui.perfetto.dev: trace.json", "none"),
  };
}

// A group's heading in --help, and its fields.
struct GroupOfFields {
  SettingGroup group;
  const char* title;
  std::vector<SettingField> (*fields)();
};
constexpr GroupOfFields kGroups[] = {
    {SettingGroup::Camera, "Camera", camera_fields},
    {SettingGroup::Schedule, "Schedule", schedule_fields},
    {SettingGroup::Sync, "Sync and trigger lines", sync_fields},
    {SettingGroup::Fit, "Fit", fit_fields},
    {SettingGroup::Knobs, "Knobs", knob_fields},
    {SettingGroup::Output, "Output", output_fields},
    {SettingGroup::Record, "Recording", record_fields},
    {SettingGroup::Machine, "Machine", machine_fields},
};

std::vector<SettingField> all_fields() {
  std::vector<SettingField> all;
  for (const auto& [group, title, fields] : kGroups)
    for (SettingField& field : fields()) {
      field.group = group;
      all.push_back(std::move(field));
    }
  return all;
}

}  // namespace

std::span<const SettingField> setting_fields() {
  static const std::vector<SettingField> fields = all_fields();
  return fields;
}

const char* title(SettingGroup group) {
  return std::ranges::find(kGroups, group, &GroupOfFields::group)->title;
}

const char* flag_of(const SettingField& field, std::span<const SettingGroup> groups) {
  const bool frames_go_out = std::ranges::find(groups, SettingGroup::Output) != groups.end();
  return field.key == "record.file" && !frames_go_out ? "-o,--output" : field.flag;
}

}  // namespace hdrcam
