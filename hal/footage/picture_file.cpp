#include "hal/footage/picture_file.h"

#include <fmt/format.h>

#include "hal/core/split_text.h"

namespace hdrcam {

std::string camera_model(std::string_view make, std::string_view model) {
  const std::string_view of = trimmed(make), name = trimmed(model);
  return of.empty() || name.empty() ? std::string(name) : fmt::format("{} {}", of, name);
}

}  // namespace hdrcam
