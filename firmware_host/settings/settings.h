// What a run on a camera is told. Every setting has a default that works, a key in a TOML file and a flag;
// one list of fields (setting_fields.h) feeds all three, the help and the printed configuration. What is
// given last in this order wins: default, file, flag. Plain value; what the texts mean is checked by whoever
// uses them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace CLI {
class App;
}

namespace hdrcam {

struct Settings {
  struct Camera {
    std::string id;             // "": the only camera; a device, "sim:SCENE", "replay:FILE"
    std::string format;         // "": the one that keeps most of the sensor's codes; or a name such as "YUYV"
    int width = 0, height = 0;  // pixels; 0: the largest of up to 640x480
    double framerate_hz = 0;    // 0: as the camera usually runs, 30
    int buffers = 8;            // requests under way, 4..32
    std::string control_delay;  // "": what the driver says; "2,1": frames of exposure and gain
    double black_level = -1;    // codes of 255, of raw formats; -1: of the table of sensors
    std::string timestamp =
        "driver";  // "begin" or "end" of the exposure, or what the driver says of its stamp
    std::string yuv_range = "limited";  // or "full"
  } camera;
  struct Schedule {
    std::string shutter = "1ms,4ms,16ms";  // the cycle, 1 to 4 times
    std::string gain;                      // analogue gains of the cycle, or one for all; "": 1
    bool adapt = false;                    // the cycle follows the light
    std::string mains = "off";             // "50" or "60": exposures of whole half periods
  } schedule;
  struct Sync {
    std::string line;                  // "": none; "gpiochip0:17" or a line's name: strobe edges
    std::string strobe = "frame";      // what a pulse means: "frame" marks it, "exposure" spans it
    std::string strobe_delay = "0us";  // of the rising edge after the driver's timestamp
    bool active_low = false;
  } sync;
  struct Fit {
    std::string preset = "balanced";  // fast, balanced, best
    std::string emit = "merged";      // or state, field
    int lookahead = 1;                // frames, 0..2
    int threads = 0;                  // 0: all processors
    int seed = 1;                     // of the fit's random rays
    double code_noise = 1;            // codes rms, 0..20: 1 clean, 2 MJPEG
  } fit;
  struct Output {
    std::string frames, layers, compression = "zip";  // of the EXR sequence
    std::string preview, sheet, stats, report;
  } output;
  struct Record {
    std::string file;      // the raw recording
    int memory_mib = 256;  // frames that may wait for the disk, 1..65536
  } record;
};

// Which settings a verb takes.
enum class SettingGroup { Camera, Schedule, Sync, Fit, Output, Record };

// The flags of one verb, --config and --print-config among them.
class SettingsFlags {
 public:
  SettingsFlags(CLI::App& verb, std::vector<SettingGroup> groups);
  ~SettingsFlags();

  // Defaults, then the file named by --config, then the flags. Errors: those of reading the file; Invalid for
  // TOML that does not parse, an unknown key, a value of another type or outside its range, naming file, line
  // and what would do. A file may hold keys of groups that this verb does not take: one file serves all
  // verbs.
  Result<Settings> read(Storage& storage) const;
  bool print_config() const;

 private:
  struct Given;
  std::unique_ptr<Given> given_;
};

// The settings of these groups as a TOML file with a comment for each: what --print-config prints, and what
// reads back as the same settings.
std::string to_toml(const Settings& settings, const std::vector<SettingGroup>& groups);

}  // namespace hdrcam
