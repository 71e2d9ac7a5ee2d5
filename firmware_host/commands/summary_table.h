// What the summaries of recordings and of saved scenes have in common (recording_summary.h,
// snapshot_summary.h): the look of a table and of a lens. Reentrant.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "firmware_host/printable.h"
#include "hal/core/frame.h"

namespace hdrcam {

// The name of the file, then a line for each fact. Plain value.
class SummaryTable {
 public:
  explicit SummaryTable(const std::string& path) : text_(printable(path) + "\n") {}

  void row(const char* what, const std::string& value) { text_ += fmt::format("  {:<12}{}\n", what, value); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

inline std::string shown_name(const std::string& camera) {
  return camera.empty() ? "(no name)" : printable(camera);
}

inline std::string describe(const Intrinsics& lens) {
  return fmt::format("f {:.6g} x {:.6g} px, centre {:.6g}, {:.6g}", lens.fx_px, lens.fy_px, lens.cx_px,
                     lens.cy_px);
}

inline nlohmann::ordered_json json_of(const Intrinsics& lens) {
  return {{"fx_px", lens.fx_px}, {"fy_px", lens.fy_px}, {"cx_px", lens.cx_px}, {"cy_px", lens.cy_px}};
}

inline std::string describe_size(std::uint64_t bytes) {
  return fmt::format("{:.2f} MB", static_cast<double>(bytes) * 1e-6);
}

}  // namespace hdrcam
