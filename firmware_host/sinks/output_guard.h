// Protects existing files from a run. Before anything is opened, it checks every output against every input
// and every other output: it refuses the same file under any name, and also the results of an earlier run (a
// recording, numbered frames), unless --force is given. Reentrant.
#pragma once

#include <span>
#include <string>

#include "hal/storage.h"

namespace hdrcam {

enum class InputKind {
  File,
  Folder,  // with everything below it
};

struct NamedInput {
  std::string what;  // for messages: "the recording that is read"
  std::string path;
  InputKind kind = InputKind::File;
};

enum class OutputKind {
  Frames,     // a pattern, one file per frame: earlier frames stay unless --force
  Recording,  // an earlier take stays unless --force
  Document,   // what the verb was run for, under a name that it gives: an earlier one stays unless --force
  Settings,   // for --config: an earlier file stays unless --force
  Scene,      // a snapshot: an earlier one stays unless --force
  Poses,      // of the pictures, for other tools: earlier ones, of whatever program, stay unless --force
  List,       // of the frames, beside them (frame_ledger.h): an earlier one stays unless --force
  Page,       // statistics, a report: every run replaces them
  Picture,    // a page that is a PNG, such as a contact sheet; a numbered PNG stays unless --force
};

struct NamedOutput {
  std::string flag;  // "--report"
  std::string path;  // as the user gave it; "": not wanted
  OutputKind kind = OutputKind::Page;
  std::string extension = {};  // of frames, with its dot; "": as the pattern has it
};

enum class Overwrite { Refuse, Force };

// Errors: Invalid where an output is an input, another output or its folder, a folder, "-" or no pattern of
// frames, or one file that is named by such a pattern, or has an unknown word in braces, or a page, picture,
// scene, document or settings over a file of another kind (by its extension), or a scene that is not called
// .hdrscene; Exists where it would replace an earlier take; Permission where numbered frames would go into a
// folder that cannot be listed; those of Storage::look_at.
Result<void> check_outputs(Storage& storage, std::span<const NamedInput> inputs,
                           std::span<const NamedOutput> outputs, Overwrite overwrite);

// Makes the folders of all outputs and finds out, before any work is done, whether files can be made in them.
// Errors: Permission, NoSpace, Io.
Result<void> make_room_for(Storage& storage, std::span<const NamedOutput> outputs);

}  // namespace hdrcam
