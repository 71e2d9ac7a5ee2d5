// The numbered files of an earlier run that lie where a run writes its own, whatever their number of digits.
// They stop a run without --force. --force replaces those of the same names; the others stay, because they
// may be all that is left of a take, and a warning says so: whoever reads the folder as one clip would mix
// two. Thread-bound.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware_host/sinks/output_paths.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

struct SinkKind;

class EarlierFrames {
 public:
  // Looks at the files that are there now. pattern: "out/%06d.exr"; what is none has no files. The storage
  // outlives this.
  EarlierFrames(Storage& storage, const std::string& pattern);

  // Why the folder cannot be listed: which files are there is not known then. Missing, it has none.
  const Result<void>& listed() const { return listed_; }
  std::size_t count() const { return files_.size(); }
  const std::string& first() const { return files_.front().path; }  // by name; there is one

  // Whether that file, of the pattern's folder, was there before the run and the run has not replaced it.
  bool remains(const std::string& path) const;
  // Before the run's first file. Errors: Exists where another program has written one of such a name since.
  Result<void> check_none_came() const;
  // After the run: a sentence about the files that lie beside its own, or that they are not known; "" where
  // there are none, or where the run wrote none.
  std::string warning() const;

 private:
  struct File {
    std::string path;
    FileFacts facts;  // before the run
  };
  bool remains(const File& file) const;
  std::optional<std::string> first_new() const;  // of the files that came since

  Storage& storage_;
  const std::string pattern_;
  Result<void> listed_;
  std::vector<File> files_;  // by path
};

// Of all outputs of a run that are numbered files.
std::vector<EarlierFrames> earlier_frames(Storage& storage, std::span<const SinkKind> kinds,
                                          const OutputPaths& paths);

}  // namespace hdrcam
