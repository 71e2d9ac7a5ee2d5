#include "firmware_host/sinks/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>

#include "capture/exposure.h"
#include "firmware_host/signed_text.h"
#include "firmware_host/sinks/canvas.h"
#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "hal/core/quantile.h"
#include "render/png.h"

namespace hdrcam {
namespace {

constexpr int kRowsShown = 4;
// A stride that grows by this many has no factor in common with a cycle of 2 to 4: the rows kept walk through
// all of its exposures, whatever the stride.
constexpr std::size_t kStrideGrowth = 5;
constexpr std::size_t kRowsKept = kRowsShown * kStrideGrowth;
constexpr int kCellWidth_px = 320;
constexpr int kGap_px = 8, kCaption_px = 22, kText_px = 9;
constexpr int kTitleRise_px = 6, kCaptionRise_px = 7;  // baselines, above the lower edge of their strip
constexpr Rgb kPaper{24, 26, 30}, kInk{214, 218, 224}, kUnknown{96, 96, 96};
constexpr float kBrightest = 0.98f;  // quantile of 1 / depth shown as the brightest

int cell_rows(int rows, int cols) {
  return cols <= kCellWidth_px ? rows : rows_at_width(rows, cols, kCellWidth_px);
}
int cell_cols(int cols) { return std::min(cols, kCellWidth_px); }

template <class T>
Image<T> as_cell(const Image<T>& picture) {
  return resized(picture, cell_rows(picture.rows(), picture.cols()), cell_cols(picture.cols()));
}

Image<std::uint8_t> as_codes(const Image<float>& codes) {
  Image<std::uint8_t> result;
  result.reshape(codes.channels(), codes.rows(), codes.cols());
  std::transform(codes.samples().begin(), codes.samples().end(), result.samples().begin(),
                 [](float code) { return static_cast<std::uint8_t>(std::clamp(code, 0.0f, 255.0f) + 0.5f); });
  return result;
}

// Labels cannot be averaged: each pixel of the cell takes the one nearest to its centre.
Image<std::uint8_t> sampled(const Image<std::uint8_t>& labels) {
  Image<std::uint8_t> result;
  result.reshape(1, cell_rows(labels.rows(), labels.cols()), cell_cols(labels.cols()));
  for (int y = 0; y < result.rows(); ++y)
    for (int x = 0; x < result.cols(); ++x)
      result.at(0, y, x) = labels.at(0, (2 * y + 1) * labels.rows() / (2 * result.rows()),
                                     (2 * x + 1) * labels.cols() / (2 * result.cols()));
  return result;
}

Image<float> inverted(const Image<float>& depth) {
  Image<float> nearness;
  nearness.reshape_like(depth);
  std::transform(depth.samples().begin(), depth.samples().end(), nearness.samples().begin(),
                 [](float z) { return z > 0 ? 1 / z : 0.0f; });
  return nearness;
}

Image<std::uint8_t> scaled(const Image<float>& nearness, float brightest) {
  Image<float> codes;
  codes.reshape_like(nearness);
  std::transform(nearness.samples().begin(), nearness.samples().end(), codes.samples().begin(),
                 [brightest](float value) { return brightest > 0 ? 255 * value / brightest : 0.0f; });
  return as_codes(codes);
}

// Grey where the depth is not known.
Image<std::uint8_t> depth_colours(const Image<float>& nearness, float brightest) {
  Image<std::uint8_t> picture = false_colours(scaled(nearness, brightest));
  for (std::size_t i = 0; i < nearness.size(); ++i)
    if (!(nearness.samples()[i] > 0))
      picture.plane(0)[i] = kUnknown.r, picture.plane(1)[i] = kUnknown.g, picture.plane(2)[i] = kUnknown.b;
  return picture;
}

Image<std::uint8_t> coloured(const Image<std::uint8_t>& provenance) {
  Image<std::uint8_t> picture;
  picture.reshape(3, provenance.rows(), provenance.cols());
  for (std::size_t i = 0; i < provenance.size(); ++i) {
    const std::size_t value = std::min<std::size_t>(provenance.samples()[i], kProvenanceLooks.size() - 1);
    const Rgb colour = kProvenanceLooks[value].colour;
    picture.plane(0)[i] = colour.r, picture.plane(1)[i] = colour.g, picture.plane(2)[i] = colour.b;
  }
  return picture;
}

// Where each column begins, which is as wide as its cells and its title, and where the last one ends.
std::vector<int> lefts_of(const std::vector<std::string>& titles, int cell_width) {
  std::vector<int> lefts{kGap_px};
  for (const std::string& title : titles)
    lefts.push_back(lefts.back() + std::max(cell_width, text_width(title, kText_px)) + kGap_px);
  return lefts;
}

// Returns the column behind it. canvas: null to measure only.
int draw_legend(Canvas* canvas, int baseline) {
  int left = kGap_px;
  const auto write = [&](const std::string& words) {
    if (canvas != nullptr) canvas->write(baseline, left, words, kText_px, kInk);
    left += text_width(words, kText_px);
  };
  write("provenance:");
  for (const ProvenanceLook& look : kProvenanceLooks) {
    left += 2 * kGap_px;
    if (canvas != nullptr) canvas->fill(baseline - kText_px, left, kText_px, kText_px, look.colour);
    left += kText_px + kGap_px / 2;
    write(look.name);
  }
  return left;
}

}  // namespace

std::string ContactSheet::Row::caption() const {
  return fmt::format("frame {}    exposure {} EV", sequence, signed_text(std::log2(exposure), 1));
}

ContactSheet::ContactSheet(Storage& storage, std::string path) : storage_(storage), path_(std::move(path)) {}

Result<void> ContactSheet::emit(const EmittedFrame& frame) {
  const ToneCurve& curve = tone_.follow(frame.hdr.radiance);
  if (frames_++ % stride_ != 0) return {};
  if (rows_.size() == kRowsKept) {
    std::vector<Row> kept;
    for (std::size_t i = 0; i < rows_.size(); i += kStrideGrowth) kept.push_back(std::move(rows_[i]));
    rows_ = std::move(kept);
    stride_ *= static_cast<int>(kStrideGrowth);
  }
  Row& row = rows_.emplace_back();
  row.sequence = frame.hdr.facts.sequence;
  row.exposure = frame.hdr.exposure;
  row.input = as_cell(as_codes(frame.input.codes));
  row.shown = as_cell(tone_mapped(frame.hdr.radiance, curve));
  row.provenance = sampled(frame.hdr.provenance);
  if (!frame.hdr.depth.empty()) row.nearness = as_cell(inverted(frame.hdr.depth));
  return {};
}

Result<void> ContactSheet::finish() {
  if (rows_.empty()) return {};
  png_ = TRY(encode_png(composed(), PngEffort::Small));
  return path_.empty() ? Result<void>{} : write_whole(storage_, path_, png_);
}

// Of the choices that show the most exposures, the one that is spread most evenly.
std::vector<const ContactSheet::Row*> ContactSheet::chosen_rows() const {
  const int n = static_cast<int>(rows_.size()), shown = std::min(n, kRowsShown);
  std::vector<char> taken(rows_.size());
  std::fill_n(taken.begin(), shown, 1);
  std::vector<const Row*> best;
  std::pair<int, int> merit_of_best{-1, 0};
  do {
    std::vector<const Row*> rows;
    int exposures = 0, aside = 0;  // aside: of the even places, in rows
    for (int i = 0; i < n; ++i) {
      const Row& row = rows_[static_cast<std::size_t>(i)];
      if (!taken[static_cast<std::size_t>(i)]) continue;
      const int even = shown > 1 ? static_cast<int>(rows.size()) * (n - 1) / (shown - 1) : 0;
      aside += std::abs(i - even);
      exposures += std::ranges::none_of(rows, [&row](const Row* other) {
        return std::abs(std::log(row.exposure / other->exposure)) <= kSameExposure;
      });
      rows.push_back(&row);
    }
    if (const std::pair merit(exposures, -aside); merit > merit_of_best)
      merit_of_best = merit, best = std::move(rows);
  } while (std::ranges::prev_permutation(taken).found);
  return best;
}

// The cells of a film may be of another size than its input.
template <class Side>
int ContactSheet::largest(const std::vector<const Row*>& rows, const Side& side) {
  int most = 1;
  for (const Row* row : rows)
    for (const Image<std::uint8_t>* cell : {&row->input, &row->shown, &row->provenance})
      most = std::max(most, side(*cell));
  return most;
}

// The nearness that is shown as the brightest, in all rows; 0 where no depth is known.
float ContactSheet::brightest_of(const std::vector<const Row*>& rows) {
  std::vector<float> nearness;
  for (const Row* row : rows)
    nearness.insert(nearness.end(), row->nearness.samples().begin(), row->nearness.samples().end());
  return quantile(std::span(nearness), kBrightest);
}

ContactSheet::Layout ContactSheet::layout_of(const std::vector<const Row*>& rows,
                                             const std::vector<std::string>& titles) {
  const int cell_height = largest(rows, [](const Image<std::uint8_t>& cell) { return cell.rows(); });
  const int cell_width = largest(rows, [](const Image<std::uint8_t>& cell) { return cell.cols(); });
  Layout layout;
  layout.lefts = lefts_of(titles, cell_width);
  layout.step_down = cell_height + kCaption_px;
  layout.height = 2 * kCaption_px + static_cast<int>(rows.size()) * layout.step_down + kGap_px;
  layout.width = std::max(layout.lefts.back(), draw_legend(nullptr, 0) + kGap_px);
  for (const Row* row : rows)
    layout.width = std::max(layout.width, text_width(row->caption(), kText_px) + 2 * kGap_px);
  return layout;
}

void ContactSheet::draw(const Row& row, int top, const Layout& layout, float brightest, Canvas& canvas) {
  const auto paste = [&](std::size_t column, const Image<std::uint8_t>& cell) {
    canvas.paste(top, layout.lefts[column], cell);
  };
  paste(0, row.input);
  paste(1, row.shown);
  paste(2, coloured(row.provenance));
  if (!row.nearness.empty()) paste(3, depth_colours(row.nearness, brightest));
  canvas.write(top + layout.step_down - kCaptionRise_px, kGap_px, row.caption(), kText_px, kInk);
}

Image<std::uint8_t> ContactSheet::composed() const {
  const auto rows = chosen_rows();
  const float brightest = brightest_of(rows);
  std::vector<std::string> titles{"input", "HDR, tone-mapped", "provenance"};
  if (brightest > 0) titles.emplace_back("inverse depth (near is bright)");

  const Layout layout = layout_of(rows, titles);
  Canvas canvas(layout.height, layout.width, kPaper);
  for (std::size_t i = 0; i < titles.size(); ++i)
    canvas.write(kCaption_px - kTitleRise_px, layout.lefts[i], titles[i], kText_px, kInk);
  int top = kCaption_px;
  for (const Row* row : rows) {
    draw(*row, top, layout, brightest, canvas);
    top += layout.step_down;
  }
  draw_legend(&canvas, top + kCaption_px - kCaptionRise_px);
  return canvas.picture().clone();
}

Result<std::unique_ptr<FrameSink>> create_contact_sheet(Storage& storage, const std::string& path) {
  if (!path.ends_with(".png"))
    return Error{ErrorCode::Invalid,
                 fmt::format("--sheet '{}' is not the name of a PNG picture; name it sheet.png", path)};
  TRY(make_folder_of(storage, path));
  return std::unique_ptr<FrameSink>(std::make_unique<ContactSheet>(storage, path));
}

}  // namespace hdrcam
