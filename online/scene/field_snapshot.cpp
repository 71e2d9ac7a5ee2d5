#include "online/scene/field_snapshot.h"

namespace hdrcam {

SceneView reduced(const SceneView& view, int step) {
  HDRCAM_CHECK(step >= 1);
  SceneView small = view;
  small.rows = (view.rows + step - 1) / step, small.cols = (view.cols + step - 1) / step;
  small.lens = {view.lens.fx_px / step, view.lens.fy_px / step, view.lens.cx_px / step,
                view.lens.cy_px / step};
  small.wanted = nullptr;  // of the whole view's pixels
  return small;
}

Result<void> FieldSnapshot::save(SectionWriter&) const {
  return Error{ErrorCode::Unsupported, "this kind of field cannot be saved"};
}

}  // namespace hdrcam
