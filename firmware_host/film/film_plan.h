// What a virtual camera films: which moments of a recording, from where, for how long each, at which size and
// rate. Made of the settings and of the recording's times before anything is opened, so that what cannot be
// is refused before any work. Scene times are seconds since the recording's first frame; playback times are
// those of the film. Plain values, reentrant.
#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "firmware_host/film/view_path.h"
#include "firmware_host/settings/settings.h"

namespace hdrcam {

enum class FilmedKind { Recording, Snapshot, SnapshotWithoutField };

// The recording that is filmed, from a pass over its facts, or the snapshot (scene_snapshot.h).
struct FilmedRecording {
  Instant first = {};     // time stamp of the recording's first frame, from which scene times count
  double begin_s = 0;     // of a snapshot: its own first frame
  double duration_s = 0;  // from the recording's first frame to the last
  double framerate_hz = 30;
  int width = 0, height = 0;
  bool has_poses = false;
  bool stands_still = false;       // of a snapshot: its camera was taken for fixed
  bool has_exposure_times = true;  // not only their ratios
  FilmedKind kind = FilmedKind::Recording;

  bool is_snapshot() const { return kind != FilmedKind::Recording; }
};
// Errors: those of open_recording; Interrupted once `stop` is set. A damaged recording counts as far as it
// can be read.
Result<FilmedRecording> look_through(Storage& storage, const std::string& path,
                                     const std::atomic<bool>& stop);

// What the user asks of a film, in the words of the flags; empty texts and zeros: not given.
struct FilmOptions {
  std::string view = {};      // "dx,dy,dz[,yaw,pitch,roll]"
  std::string path = {};      // a file of poses
  std::string time = {};      // "T" or "FROM..TO", seconds
  double speed = 1;           // scene seconds in a second of the film, 0.001..1000
  double framerate_hz = 0;    // of the film, 0.1..1000; 0: the recording's
  double shutter_deg = 0;     // 0..360: the share of a film frame's time that it is exposed for
  bool ldr = false;           // 8-bit pictures instead of HDR frames
  std::string exposure = {};  // of these, "4ms"; "": the reference exposure
  std::string size = {};      // "WxH"
  std::string stereo = {};    // the distance between the eyes, "63mm"
  bool stabilize = false;
};

struct FilmPlan {
  ViewPath view;
  Instant first;                  // from which scene times count
  double begin_s = 0, end_s = 0;  // scene time of the first and the last moment
  bool frozen = false;            // time stands still at begin_s
  double speed = 1;               // scene seconds in a second of the film
  double framerate_hz = 30;       // of the film
  int frames = 1;
  double shutter_s = 0;  // of the film, that a frame is exposed for; 0: an instant
  int width = 0, height = 0;
  double baseline = 0;  // between the eyes, in the scene's unit; 0: one picture
  bool stabilize = false;
  std::optional<double> exposure;  // seconds x gains of the 8-bit pictures; 0: the reference; none: HDR

  double playback_s(int frame) const { return frame / framerate_hz; }
  double scene_s(int frame) const { return frozen ? begin_s : begin_s + playback_s(frame) * speed; }
  // Scene time that passes in it: none where a path is filmed in a frozen moment, so that it alone blurs.
  double scene_shutter_s() const { return frozen && view.is_path() ? 0 : shutter_s * speed; }
};

// fit: of the run that films a recording; a snapshot's is done. Errors: Invalid, naming the flag and what it
// takes; those of reading a path.
Result<FilmPlan> plan_film(Storage& storage, const FilmOptions& options, const Settings::Fit& fit,
                           const FilmedRecording& recording);

// Memory for the virtual camera's own pictures.
std::uint64_t view_bytes(const FilmPlan& plan);
// The same, and for the frames that it keeps of a recording.
std::uint64_t film_bytes(const FilmPlan& plan, const FilmedRecording& recording);

}  // namespace hdrcam
