#include "firmware_host/sinks/frame_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "firmware_host/sinks/dash.h"
#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

constexpr int kMaxDigits = 19;  // of a 64-bit sequence number
constexpr std::string_view kTakesVideos = "--output", kNumbersRecordings = "--http-record";

// What the files of a flag are of.
std::string_view content_of(std::string_view flag) {
  return flag == kNumbersRecordings ? "recording" : "frame";
}

// As a message shows it.
std::string_view usual_number(std::string_view flag) { return flag == kNumbersRecordings ? "%03d" : "%06d"; }

Error refused(std::string_view flag, std::string_view text, std::string_view why,
              std::string_view extension) {
  return {ErrorCode::Invalid,
          fmt::format("{} '{}' {}; write it as '{}/{}{}'", flag, text, why,
                      flag == kNumbersRecordings ? "takes" : "out", usual_number(flag), extension)};
}

// Of a name without a number. One without an extension is a folder's, but for that of the standard output.
Error not_numbered(std::string_view flag, std::string_view text, std::string_view extension) {
  Error refusal =
      refused(flag, text, fmt::format("would put every {} into one file", content_of(flag)), extension);
  if (!text.empty() && text != kStandardOutput && std::filesystem::path(text).extension().empty())
    refusal.message =
        fmt::format("{} '{}' names no files; write it as '{}/{}{}'", flag, text,
                    text.substr(0, text.find_last_not_of('/') + 1), usual_number(flag), extension);
  if (flag == kTakesVideos) refusal.message += ", or name a video: out.mp4, out.mov or out.mkv";
  return refusal;
}

// The "06" of a text that begins with "%06d"; none of one that does not.
std::optional<std::string_view> width_of_number(std::string_view text) {
  const std::size_t end = text.find_first_not_of("0123456789", 1);
  if (end == std::string_view::npos || text[end] != 'd') return std::nullopt;
  const std::string_view width = text.substr(1, end - 1);
  if (!width.starts_with('0') || width.size() < 2 || width.size() > 3) return std::nullopt;
  return width;
}

}  // namespace

bool holds_frame_number(std::string_view text) {
  for (std::size_t at = text.find('%'); at != std::string_view::npos; at = text.find('%', at + 1)) {
    const std::size_t end = text.find_first_not_of("0123456789", at + 1);
    if (end != std::string_view::npos && end > at + 1 && text[end] == 'd') return true;
  }
  return false;
}

Result<FramePattern> FramePattern::parse(std::string_view flag, std::string_view text,
                                         std::string_view extension) {
  const std::size_t slash = text.rfind('/'), begin = slash == std::string_view::npos ? 0 : slash + 1;
  if (holds_frame_number(text.substr(0, begin)))
    return refused(flag, text, fmt::format("has the {} number in a folder's name", content_of(flag)),
                   extension);
  const auto percents = std::count(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), '%');
  if (percents == 0) return not_numbered(flag, text, extension);
  if (percents > 1) return refused(flag, text, "has more than one '%'", extension);
  if (!text.ends_with(extension)) {
    Error other_kind = refused(flag, text, fmt::format("does not end in '{}'", extension), extension);
    if (flag == kTakesVideos && text.ends_with(".png"))
      other_kind.message += ", or give it to --preview, which makes tone-mapped pictures";
    return other_kind;
  }

  const std::size_t percent = text.find('%', begin);
  const auto width = width_of_number(text.substr(percent));
  if (!width)
    return refused(
        flag, text,
        fmt::format("has a '%' that is not a {} number like '{}'", content_of(flag), usual_number(flag)),
        extension);
  const int digits = parse_number<int>(*width).value();
  if (digits < 1 || digits > kMaxDigits)
    return refused(flag, text, fmt::format("asks for {} digits, not 1 to {}", digits, kMaxDigits), extension);
  const std::size_t end = percent + width->size() + 2;  // behind '%' and 'd'
  return FramePattern(std::string(text.substr(0, percent)), digits, std::string(text.substr(end)));
}

bool FramePattern::is_one(std::string_view text) {
  return parse("", text, std::filesystem::path(text).extension().string()).ok();
}

std::string FramePattern::path(std::uint64_t sequence) const {
  return fmt::format("{}{:0{}}{}", before_, sequence, digits_, after_);
}

std::string_view FramePattern::name_before() const {
  const std::size_t slash = before_.rfind('/');
  return std::string_view(before_).substr(slash == std::string::npos ? 0 : slash + 1);
}

std::optional<std::string_view> FramePattern::number_in(std::string_view name) const {
  const std::string_view before = name_before();
  if (name.size() <= before.size() + after_.size() || !name.starts_with(before) || !name.ends_with(after_))
    return std::nullopt;
  return name.substr(before.size(), name.size() - before.size() - after_.size());
}

std::optional<std::uint64_t> FramePattern::sequence_of(std::string_view name) const {
  const auto sequence = parse_number<std::uint64_t>(number_in(name).value_or(""));
  return sequence && std::filesystem::path(path(*sequence)).filename() == name ? sequence : std::nullopt;
}

bool FramePattern::fits(std::string_view name) const {
  const auto number = number_in(name);
  return number && number->find_first_not_of("0123456789") == std::string_view::npos;
}

bool FramePattern::same_names_but_for_digits(const FramePattern& other) const {
  return name_before() == other.name_before() && after_ == other.after_;
}

std::string FramePattern::folder() const {
  const std::size_t slash = before_.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : before_.substr(0, slash);
}

std::size_t digits_at_end(std::string_view stem) {
  return stem.size() - (stem.find_last_not_of("0123456789") + 1);
}

}  // namespace hdrcam
