// One picture of a whole run: a few frames, spread over the clip and over the exposures of the cycle, each as
// a row of
//   what came in | the HDR frame, tone-mapped | provenance | inverse depth (where the field ran).
// The clip's length is not known beforehand: it keeps every n-th frame, and n grows whenever too many are
// held, so the memory is bounded. Thread-bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"
#include "render/tone_curve.h"

namespace hdrcam {

class Canvas;

class ContactSheet : public FrameSink {
 public:
  // path: of the PNG that finish() writes; "" to write none (the report takes png()). The storage outlives
  // the sink.
  ContactSheet(Storage& storage, std::string path);

  InputUse input_use() const override { return InputUse::Codes; }
  Result<void> emit(const EmittedFrame& frame) override;
  Result<void> finish() override;

  // The sheet as a PNG, after finish(); empty where no frame was emitted.
  const std::vector<std::byte>& png() const { return png_; }

 private:
  struct Row {
    std::uint64_t sequence = 0;
    float exposure = 1;                // E / E_ref
    Image<std::uint8_t> input, shown;  // [rgb, rows, cols]
    Image<float> nearness;             // [1, rows, cols] 1 / depth; empty without depth
    Image<std::uint8_t> provenance;    // [1, rows, cols]

    std::string caption() const;
  };
  // Where columns and rows lie, in pixels of the sheet.
  struct Layout {
    std::vector<int> lefts;  // of the columns, and where the last one ends
    int step_down = 0;       // from a row to the next
    int height = 0, width = 0;
  };
  Image<std::uint8_t> composed() const;
  std::vector<const Row*> chosen_rows() const;
  static float brightest_of(const std::vector<const Row*>& rows);
  static Layout layout_of(const std::vector<const Row*>& rows, const std::vector<std::string>& titles);
  // top: of the row; brightest: the nearness shown as the brightest.
  static void draw(const Row& row, int top, const Layout& layout, float brightest, Canvas& canvas);
  // Of the rows' cells; side: of one.
  template <class Side>
  static int largest(const std::vector<const Row*>& rows, const Side& side);

  Storage& storage_;
  const std::string path_;
  ToneAdaptation tone_;
  std::vector<Row> rows_;
  int frames_ = 0, stride_ = 1;
  std::vector<std::byte> png_;
};

// path: of the PNG; its folder is created.
Result<std::unique_ptr<FrameSink>> create_contact_sheet(Storage& storage, const std::string& path);

}  // namespace hdrcam
