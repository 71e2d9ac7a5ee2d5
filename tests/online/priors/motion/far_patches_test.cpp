#include "online/priors/motion/far_patches.h"

#include "online/priors/motion/flow_effort.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 6, kCols = 8;

Image<float> nothing() {
  Image<float> vectors(2, kRows, kCols);
  vectors.fill(kNowhere);
  return vectors;
}
void find(Image<float>& far, int row, int col, float u, float v) {
  far.at(0, row, col) = u, far.at(1, row, col) = v;
}

}  // namespace

TEST_CASE("a patch that alone was found far away is not believed, one among its like is") {
  Image<float> far = nothing(), kept;
  find(far, 0, 0, 30, 0);                                 // alone, in a corner
  for (const int col : {3, 4}) find(far, 0, col, 20, 9);  // two
  for (const int row : {3, 4})
    for (const int col : {5, 6}) find(far, row, col, 20 + static_cast<float>(row - col) / 2, -7);
  find(far, 4, 7, -20, -7);  // beside them, and of another motion
  CHECK(keep_agreeing(far, kept) == 4);
  for (int row = 0; row < kRows; ++row)
    for (int col = 0; col < kCols; ++col) {
      CAPTURE(row, col);
      const bool of_the_four = (row == 3 || row == 4) && (col == 5 || col == 6);
      CHECK(kept.at(0, row, col) == (of_the_four ? far.at(0, row, col) : kNowhere));
    }
}

TEST_CASE("what is far away is looked for in a picture that is searched, however small it is") {
  for (const int rows : {20, 40, 64, 85, 120, 240, 480, 1080})
    for (const FlowQuality quality : {FlowQuality::Coarse, FlowQuality::Fast, FlowQuality::Fine}) {
      CAPTURE(rows);
      const FlowScales scales = scales_of(effort_of(quality), rows, rows * 4 / 3);
      CHECK(scales.far >= scales.finest);
      CHECK(scales.far <= scales.coarsest);
    }
}

TEST_CASE("a patch is looked for in a third of a picture, and in a long strip no farther") {
  constexpr int kShort = 85;  // pixels, of the longest picture that is searched for what is far away
  CHECK(far_reach(kShort) == kShort / 3);
  CHECK(far_reach(3 * kShort) == kShort);
  CHECK(far_reach(16384) < 2 * kShort);
}

TEST_CASE("a patch found far away is a guess of the patches back, where it leads") {
  Image<float> far = nothing(), answers(2, kRows, kCols), back = nothing();
  find(far, 1, 1, 13, 9);  // at 4, 4: leads to 17, 13
  PatchSearch search{};
  search.from.rows = 28, search.from.cols = 36;
  search.grid = {kRows, kCols, 4};
  search.patches = {answers.plane(0), answers.plane(1)};
  take_far(far, search, back);
  CHECK(answers.at(0, 1, 1) == 13);
  CHECK(answers.at(1, 1, 1) == 9);
  CHECK(answers.at(0, 1, 2) == 0);
  for (int row = 0; row < kRows; ++row)
    for (int col = 0; col < kCols; ++col) {
      CAPTURE(row, col);
      const bool there = (row == 3 || row == 4) && (col == 4 || col == 5);
      CHECK(back.at(0, row, col) == (there ? -13 : kNowhere));
      CHECK(back.at(1, row, col) == (there ? -9 : kNowhere));
    }
}
