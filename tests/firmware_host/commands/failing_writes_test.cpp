// The whole program, when the kernel refuses one of its writes: whichever it is, every file that is left is
// whole as far as it says, and the user is told. tests/failing_writes.cpp is preloaded and fails the call.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "firmware_host/exit_code.h"
#include "hal/recording/png_image.h"
#include "hal/recording/recording.h"
#include "render/exr.h"
#include "tests/allocations.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/decoded_video.h"
#include "tests/support/not_tested.h"
#include "tests/support/ran.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::Ran;

namespace {

namespace fs = std::filesystem;

struct Job {
  const char* name;
  std::string flags;  // {in}: a folder with walk.mkv and clip/; {out}: an empty one
};

const Job kJobs[] = {
    {"record",
     "record --camera 'sim:still?size=64x48&fps=200' --format RGB24 --shutter 1ms,2ms,4ms --frames 10 -o "
     "{out}/raw.mkv"},
    {"import", "import {in}/clip -o {out}/walk.mkv"},
    {"repair", "repair {in}/walk.mkv -o {out}/walk.mkv"},
    {"export", "export {in}/walk.mkv -o {out}/clip"},
    {"replay",
     "replay {in}/walk.mkv -o {out}/%06d.exr --stats {out}/stats.json --report {out}/report.html --preview "
     "{out}/%06d.png --transforms {out}/transforms.json"},
    {"replay into a video", "replay {in}/walk.mkv --set field=none -o {out}/walk.mp4"}};
constexpr int kFrames = 6;

const std::string& input_folder() {
  static const std::string kFolder = [] {
    const std::string folder = sample::scratch_folder("failing_writes");
    const std::string frames = std::to_string(kFrames);
    REQUIRE(test::ran("simulate 'walk?size=64x48' --shutter 1ms,4ms --frames " + frames + " --truth " +
                      folder + "/clip")
                .exit_code == kExitOk);
    REQUIRE(test::ran("import " + folder + "/clip -o " + folder + "/walk.mkv").exit_code == kExitOk);
    return folder;
  }();
  return kFolder;
}

// The job with the library preloaded; fault: "" for none.
Ran ran_with(const Job& job, const std::string& out, const std::string& fault) {
  std::string flags = job.flags;
  for (const auto& [name, folder] :
       {std::pair<std::string, std::string>("{in}", input_folder()), {"{out}", out}})
    for (std::size_t at; (at = flags.find(name)) != std::string::npos;)
      flags.replace(at, name.size(), folder);
  // By its name alone: LD_PRELOAD is split at blanks, which its folder may have.
  const fs::path library = HDRCAM_FAILING_WRITES;
  const std::string environment = "LD_LIBRARY_PATH='" + library.parent_path().string() +
                                  "' LD_PRELOAD=" + library.filename().string() + " HDRCAM_WRITES_COUNTED='" +
                                  input_folder() + "/count' HDRCAM_FAILING_WRITE='" + fault + "'";
  return test::ran(flags, environment);
}

// Frames of a recording that can be read, one after the other; its end may be missing.
std::size_t frames_read(const std::string& path) {
  auto reader = open_recording(posix_storage(), path);
  if (!reader) return 0;
  for (std::size_t n = 0;; ++n) {
    auto next = reader.value()->next();
    if (!next) CHECK(next.error().code == ErrorCode::Truncated);
    if (!next || !*next) return n;
  }
}

// What is wrong with a file that a run left; empty: nothing.
std::string fault_of(const fs::path& path) {
  const std::string ending = path.extension().string(),
                    text = value_of(read_whole(posix_storage(), path.string()));
  if (ending == ".part") return "has no final name";
  if (ending == ".exr") return read_exr(posix_storage(), path.string()).ok() ? "" : "is no OpenEXR file";
  if (ending == ".json") return nlohmann::json::accept(text) ? "" : "is no JSON";
  if (ending == ".html") return text.find("</html>") != std::string::npos ? "" : "has no end";
  if (ending == ".csv" || ending == ".txt")
    return text.empty() || text.back() == '\n' ? "" : "ends within a line";
  if (ending == ".png") return read_png(posix_storage(), path.string(), 64, 48).ok() ? "" : "is no PNG";
  return "";
}

std::map<std::string, int> files_by_ending(const std::string& folder) {
  std::map<std::string, int> count;
  for (const auto& file : fs::recursive_directory_iterator(folder))
    if (file.is_regular_file()) ++count[file.path().extension().string()];
  return count;
}

void check_files(const std::string& folder) {
  for (const auto& file : fs::recursive_directory_iterator(folder)) {
    if (!file.is_regular_file()) continue;
    INFO(file.path());
    CHECK(fault_of(file.path()) == "");
  }
}

// Refused for good: the run ends with the error, or goes on without an output that is only to look at.
void refused(const Job& job, long write, const std::string& kind) {
  const std::string out = sample::scratch_folder("failing_writes_out");
  const Ran ran = ran_with(job, out, std::to_string(write) + " " + kind);
  INFO(job.name << ", write " << write << ": " << kind << "\n" << ran.output);
  CHECK(ran.exit_code == exit_code_of(kind == "EIO" ? ErrorCode::Io : ErrorCode::NoSpace));
  CHECK_THAT(ran.output, Catch::Contains(kind == "EIO" ? "cannot write '" : "no space left to write '"));
  CHECK_THAT(ran.output, !Catch::Contains(".part"));  // which nobody asked for
  check_files(out);
  for (const auto& file : fs::directory_iterator(out)) {
    const std::string path = file.path().string();
    if (path.ends_with(".mkv") && fs::file_size(path) > 0) {
      INFO(path);
      const auto opened = open_recording(posix_storage(), path);
      CHECK((opened.ok() || opened.error().code == ErrorCode::Truncated));
      (void)frames_read(path);
    }
    if (path.ends_with(".mp4") && fs::file_size(path) > 0) (void)test::decoded_video(path);
  }
}

// Interrupted or taken in part: nothing of it shows.
void resumed(const Job& job, long write, const std::string& kind, const std::map<std::string, int>& whole) {
  const std::string out = sample::scratch_folder("failing_writes_out");
  const Ran ran = ran_with(job, out, std::to_string(write) + " " + kind);
  INFO(job.name << ", write " << write << ": " << kind << "\n" << ran.output);
  CHECK(ran.exit_code == kExitOk);
  CHECK(files_by_ending(out) == whole);
  check_files(out);
  for (const auto& file : fs::directory_iterator(out)) {
    const std::string path = file.path().string();
    if (path.ends_with(".mkv"))
      CHECK(frames_read(path) == (job.name == std::string("record") ? 10 : kFrames));
    if (path.ends_with(".mp4")) CHECK(test::decoded_video(path).frames.size() == kFrames);
  }
}

// step: every which write of a job.
void every_write_fails(long step) {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer's build takes no preloaded library");
    return;
  }
  const char* const kKinds[] = {"ENOSPC", "EINTR", "EIO", "SHORT"};
  for (const Job& job : kJobs) {
    const std::string out = sample::scratch_folder("failing_writes_out");
    REQUIRE(ran_with(job, out, "").exit_code == kExitOk);
    const std::map<std::string, int> whole = files_by_ending(out);
    const long writes = std::stol(value_of(read_whole(posix_storage(), input_folder() + "/count")));
    REQUIRE(writes > 0);
    long turn = 0;
    for (long write = 0; write < writes; ++write) {
      for (const std::string kind : kKinds) {
        if (turn++ % step != 0) continue;
        if (kind == "ENOSPC" || kind == "EIO")
          refused(job, write, kind);
        else
          resumed(job, write, kind, whole);
      }
    }
  }
}

}  // namespace

TEST_CASE("a write that the kernel refuses, interrupts or cuts short leaves whole files or none") {
  every_write_fails(9);
}

TEST_CASE("each write of each verb, refused, interrupted and cut short once, leaves whole files or none",
          "[.][full]") {
  every_write_fails(1);
}

TEST_CASE("a limit on the size of files is a full disk to every verb, and leaves nothing half made") {
  const std::string out = sample::scratch_folder("failing_writes_limit");
  const Ran limited = test::ran("import " + input_folder() + "/clip -o " + out + "/walk.mkv", "ulimit -f 8;");
  INFO(limited.output);
  CHECK(limited.exit_code == exit_code_of(ErrorCode::NoSpace));
  CHECK_THAT(limited.output, Catch::Contains("'" + out + "/walk.mkv' is as large as a file can be here"));
  CHECK(fs::is_empty(out));
}
