#include "firmware_host/exit_code.h"

#include <algorithm>
#include <array>

namespace hdrcam {
namespace {

constexpr std::array kExitCodes{
    ExitCode{kExitOk, std::nullopt, "done"},
    ExitCode{kExitInternal, std::nullopt, "a bug in hdrcam, or no memory left"},
    ExitCode{kExitUsage, ErrorCode::Invalid, "a flag, value or setting that is not valid"},
    ExitCode{3, ErrorCode::NotFound, "the named file, folder, device or address does not exist"},
    ExitCode{4, ErrorCode::NotRecording, "the file exists but is not a recording"},
    ExitCode{5, ErrorCode::Truncated, "the recording is truncated; the frames before the cut were used"},
    ExitCode{6, ErrorCode::Corrupt, "a checksum or structure in the file is wrong"},
    ExitCode{
        7, ErrorCode::BadExposure,
        "an exposure is missing or not positive, does not fit sensor or frame, or contradicts the pictures"},
    ExitCode{8, ErrorCode::SizeChanged, "frames of different size within one clip"},
    ExitCode{9, ErrorCode::TooShort, "fewer frames than the method needs"},
    ExitCode{10, ErrorCode::Permission, "exists, but may not be read or written"},
    ExitCode{11, ErrorCode::NoSpace, "the disk or quota is full"},
    ExitCode{12, ErrorCode::Io, "any other failure of the operating system"},
    ExitCode{13, ErrorCode::Busy, "another program holds the device or file"},
    ExitCode{14, ErrorCode::Unplugged, "the device was unplugged"},
    ExitCode{15, ErrorCode::Timeout, "nothing arrived within the time limit"},
    ExitCode{16, ErrorCode::Unsupported, "valid, but beyond this build, device or --memory"},
    ExitCode{17, ErrorCode::Exists, "an output exists already; --force replaces it"},
    ExitCode{kExitInterrupted, ErrorCode::Interrupted, "stopped by ^C; the files written so far are whole"},
};

}  // namespace

std::span<const ExitCode> exit_codes() { return kExitCodes; }

int exit_code_of(ErrorCode error) {
  const auto* found = std::find_if(kExitCodes.begin(), kExitCodes.end(),
                                   [error](const ExitCode& code) { return code.error == error; });
  return found == kExitCodes.end() ? kExitInternal : found->number;
}

}  // namespace hdrcam
