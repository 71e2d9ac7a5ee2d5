// The name of one file per frame: "out/%06d.exr" -> out/000041.exr. The file's name has exactly one %0Nd,
// which stands for the sensor's sequence number; that of its folder has none, and may have other '%'. The
// pattern is parsed here and never passed to printf. Value type, reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hal/core/result.h"

namespace hdrcam {

class FramePattern {
 public:
  // flag: the flag that the message names, e.g. "--output"; extension: with its dot, e.g. ".exr".
  // Errors: Invalid.
  static Result<FramePattern> parse(std::string_view flag, std::string_view text, std::string_view extension);
  // Whether an output of that name is one file per frame, with whatever extension.
  static bool is_one(std::string_view text);

  std::string path(std::uint64_t sequence) const;
  // The number of a file of that name, without its folder; nullopt where the pattern makes no such name.
  std::optional<std::uint64_t> sequence_of(std::string_view name) const;
  // Whether a file of that name, without its folder, is numbered as the pattern says, with any number of
  // digits: "0041.exr" is also one of "%06d.exr".
  bool fits(std::string_view name) const;
  bool same_names_but_for_digits(const FramePattern& other) const;  // in whatever folders
  std::string folder() const;                             // of the files; "." where the pattern names none
  std::string_view name_before() const;                   // the number, without the folder
  std::string_view name_after() const { return after_; }  // the number, with the extension

 private:
  // Between what comes before the number and what comes after it; nullopt where there is nothing or another
  // name.
  std::optional<std::string_view> number_in(std::string_view name) const;

  FramePattern(std::string before, int digits, std::string after)
      : before_(std::move(before)), digits_(digits), after_(std::move(after)) {}

  std::string before_;
  int digits_;
  std::string after_;
};

// Whether a number such as "%06d" is anywhere in a path, in the name of a folder as well. Any other '%' is a
// character like others.
bool holds_frame_number(std::string_view text);

// How many digits such a name ends in, without its extension: 4 of "f0041", 0 of "f".
std::size_t digits_at_end(std::string_view stem);

}  // namespace hdrcam
