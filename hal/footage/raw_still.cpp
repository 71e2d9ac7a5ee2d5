#include "hal/footage/raw_still.h"

#include <fmt/format.h>
#include <libraw/libraw.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/core/file_extension.h"
#include "hal/core/sound_facts.h"
#include "hal/footage/exif_exposure.h"
#include "hal/footage/tiff_fields.h"

namespace hdrcam {
namespace {

// Those of Bayer sensors. Most are TIFF, of which FFmpeg would decode the preview.
constexpr std::string_view kExtensions[] = {".3fr", ".arw", ".cr2", ".cr3", ".dng", ".erf",
                                            ".iiq", ".mef", ".nef", ".nrw", ".orf", ".pef",
                                            ".raf", ".rw2", ".rwl", ".sr2", ".srw"};

constexpr int kMostTextBytes = 64;  // of EXIF's times

// What EXIF states beside what LibRaw takes from it.
struct ExifExtras {
  std::string date_time, sub_second, offset;  // when the still was taken
  std::uint32_t sensitivity = 0;              // beyond 16 bits; 0: not stated
  bool endless = false;  // an exposure time divided by 0, which LibRaw takes for whole seconds
};

std::uint32_t read_long(LibRaw_abstract_datastream& file, unsigned byte_order) {
  constexpr unsigned kLittleEndian = 0x4949;
  std::uint8_t bytes[4]{};
  if (file.read(bytes, 1, sizeof bytes) != sizeof bytes) return 0;
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | bytes[byte_order == kLittleEndian ? 3 - i : i];
  return value;
}

// Called by LibRaw for every entry of the EXIF directory, with the file at its value.
void read_extras(void* extras, int tag, int type, int length, unsigned byte_order, void* file, INT64) {
  constexpr int kDateTimeOriginal = 0x9003, kOffsetTimeOriginal = 0x9011, kSubSecTimeOriginal = 0x9291;
  constexpr int kOutputSensitivity = 0x8831, kRecommendedExposureIndex = 0x8832, kIsoSpeed = 0x8833,
                kLong = 4;
  constexpr int kExposureTime = 0x829a, kRational = 5;
  auto& found = *static_cast<ExifExtras*>(extras);
  auto& stream = *static_cast<LibRaw_abstract_datastream*>(file);
  const bool is_sensitivity =
      tag == kOutputSensitivity || tag == kRecommendedExposureIndex || tag == kIsoSpeed;
  if (is_sensitivity && type == kLong && found.sensitivity == 0)
    found.sensitivity = read_long(stream, byte_order);
  if (tag == kExposureTime && type == kRational) {
    read_long(stream, byte_order);
    found.endless = read_long(stream, byte_order) == 0;
  }
  std::string* const text = tag == kDateTimeOriginal     ? &found.date_time
                            : tag == kOffsetTimeOriginal ? &found.offset
                            : tag == kSubSecTimeOriginal ? &found.sub_second
                                                         : nullptr;
  if (text == nullptr || length <= 0 || length > kMostTextBytes) return;
  text->resize(static_cast<std::size_t>(length));
  const int read = stream.read(text->data(), 1, text->size());
  text->resize(static_cast<std::size_t>(std::max(read, 0)));
}

// The gains as shot, green 1; none where the file does not state them, or states impossible ones.
std::optional<ChannelGains> white_balance_of(const libraw_colordata_t& color) {
  const auto gain = [&color](int c) { return static_cast<double>(color.cam_mul[c]); };
  for (int c = 0; c < 3; ++c)
    if (!(gain(c) > 0)) return std::nullopt;
  const double green = gain(3) > 0 ? 0.5 * (gain(1) + gain(3)) : gain(1);
  const ChannelGains gains{gain(0) / green, 1, gain(2) / green};
  return objection_to(gains) ? std::nullopt : std::optional(gains);
}

// By the colours of the first two rows.
std::optional<PixelLayout> layout_of(LibRaw& raw) {
  const auto color = [&raw](int row, int col) { return raw.imgdata.idata.cdesc[raw.COLOR(row, col)]; };
  const std::string pattern{color(0, 0), color(0, 1), color(1, 0), color(1, 1)};
  if (pattern == "RGGB") return PixelLayout::BayerRggb;
  if (pattern == "GRBG") return PixelLayout::BayerGrbg;
  if (pattern == "GBRG") return PixelLayout::BayerGbrg;
  if (pattern == "BGGR") return PixelLayout::BayerBggr;
  return std::nullopt;
}

// Of all colours together. levels, as LibRaw's cblack: what comes on top of the common level for each of four
// colours, then the rows and columns of a pattern that repeats, then what comes on top for each of its cells.
template <class Level>
double mean_black(Level common, const Level (&levels)[LIBRAW_CBLACK_SIZE]) {
  constexpr unsigned kColours = 4, kRowsAt = 4, kColsAt = 5, kCellsAt = 6;
  double black = common;
  for (unsigned i = 0; i < kColours; ++i) black += static_cast<double>(levels[i]) / kColours;
  const auto cells =
      std::min(static_cast<unsigned>(levels[kRowsAt] * levels[kColsAt]), LIBRAW_CBLACK_SIZE - kCellsAt);
  for (unsigned i = 0; i < cells; ++i) black += static_cast<double>(levels[kCellsAt + i]) / cells;
  return black;
}

// LibRaw counts columns from the end by its first bit, rows by its second; by its third they change places.
Orientation orientation_of_flip(int flip) {
  constexpr Orientation kByFlip[] = {Orientation::Upright,
                                     Orientation::Mirrored,
                                     Orientation::MirroredHalfTurn,
                                     Orientation::HalfTurn,
                                     Orientation::MirroredThreeQuarterTurn,
                                     Orientation::ThreeQuarterTurn,
                                     Orientation::QuarterTurn,
                                     Orientation::MirroredQuarterTurn};
  return kByFlip[flip & 7];
}

// In codes. LibRaw makes whole codes of the levels of a DNG, which may be fractions.
double black_of(const libraw_data_t& raw) {
  const libraw_colordata_t& color = raw.color;
  const double black = mean_black(color.black, color.cblack);
  const double stated = mean_black(color.dng_levels.dng_fblack, color.dng_levels.dng_fcblack);
  const bool is_measured = std::abs(stated - black) >= 1;  // in masked pixels
  return raw.idata.dng_version == 0 || is_measured ? black : stated;
}

// From which code on all is clipped. Some files state 2^n for codes of n bits, whose largest is one less.
unsigned white_of(const libraw_colordata_t& color) {
  constexpr unsigned kFewestCodes = 256;
  const unsigned stated = color.maximum;
  return stated >= kFewestCodes && std::has_single_bit(stated) ? stated - 1 : stated;
}

// The codes of a sensor as those of so many bits: the white level of the clip becomes the largest code. Never
// narrower, so that no two codes become one. What this file states as clipped is clipped.
class CodeStretch {
 public:
  // own_white: of this file.
  CodeStretch(unsigned white, unsigned own_white, int bits)
      : largest_((1u << bits) - 1), white_(std::max(1u, white)), codes_(1u << 16) {
    for (unsigned code = 0; code < codes_.size(); ++code)
      codes_[code] = static_cast<std::uint16_t>(
          code >= own_white ? largest_ : std::min(std::round(level(code)), largest_));
  }

  std::uint16_t code(ushort of_file) const { return codes_[of_file]; }
  double level(double of_file) const { return of_file * largest_ / white_; }

 private:
  double largest_, white_;
  std::vector<std::uint16_t> codes_;
};

// Whether the picture that the file states is more than its raw data holds.
bool reaches_beyond(const libraw_image_sizes_t& sizes) {
  return sizes.left_margin + sizes.width > sizes.raw_width ||
         sizes.top_margin + sizes.height > sizes.raw_height ||
         sizes.raw_width * sizeof(ushort) > sizes.raw_pitch;
}

// LibRaw before 0.21 reads the tiles of a DNG without compression as if their rows went across the picture.
bool mixes_tiles([[maybe_unused]] LibRaw& raw) {
#if LIBRAW_COMPILE_CHECK_VERSION_NOTLESS(0, 21)
  return false;
#else
  const auto& tile = raw.get_internal_data_pointer()->unpacker_data;
  const bool untiled = tile.tile_width == std::numeric_limits<int>::max();
  return !untiled && std::string_view(raw.unpack_function_name()) == "packed_dng_load_raw()" &&
         (tile.tile_width != raw.imgdata.sizes.raw_width || tile.tile_length < raw.imgdata.sizes.raw_height);
#endif
}

// Whether parts of the compressed mosaic of a DNG lie behind the end of the file: LibRaw leaves them black.
bool lacks_parts(std::span<const std::uint8_t> file) {
  constexpr std::uint32_t kMosaic = 32803, kJpeg = 7;  // PhotometricInterpretation, Compression
  TiffFields fields(file);
  const auto reach_beyond = [&](TiffTag offsets, TiffTag lengths) {
    const std::vector<std::uint32_t> begin = fields.values(offsets), bytes = fields.values(lengths);
    for (std::size_t i = 0; i < std::min(begin.size(), bytes.size()); ++i)
      if (begin[i] + std::uint64_t{bytes[i]} > file.size()) return true;
    return false;
  };
  const auto lacking = [&] {
    return fields.first_value(TiffTag::PhotometricInterpretation) == kMosaic &&
           fields.first_value(TiffTag::Compression) == kJpeg &&
           (reach_beyond(TiffTag::StripOffsets, TiffTag::StripByteCounts) ||
            reach_beyond(TiffTag::TileOffsets, TiffTag::TileByteCounts));
  };
  if (lacking()) return true;
  constexpr std::size_t kMost = 64;  // LibRaw reads fewer; a damaged file may name any number
  const std::vector<std::uint32_t> directories = fields.values(TiffTag::SubIfds);
  for (std::size_t i = 0; i < std::min(kMost, directories.size()); ++i) {
    fields.enter(directories[i]);
    if (lacking()) return true;
  }
  return false;
}

class RawStill : public PictureFile {
 public:
  const PictureFileFacts& facts() const override { return facts_; }

  Result<bool> next(RawFrame& frame) override {
    if (std::exchange(read_, true)) return false;
    std::swap(frame.facts, frame_.facts);
    std::swap(frame.codes, frame_.codes);
    return true;
  }

  std::optional<ExifTime> taken() const override { return taken_; }
  ExifFactors factors() const override { return factors_; }

  // clip_white: the white level of the clip; 0: that of this file.
  Result<void> develop(LibRaw& raw, const ExifExtras& extras, const std::string& path, int clip_white) {
    const auto layout = layout_of(raw);
    const auto& sizes = raw.imgdata.sizes;
    const ushort* const codes = raw.imgdata.rawdata.raw_image;
    if (codes == nullptr || raw.imgdata.idata.filters < 1000 ||
        !layout)  // small numbers are X-Trans and the like
      return Error{ErrorCode::Unsupported,
                   fmt::format("'{}' is not a Bayer mosaic; develop it to 16-bit TIFF or PNG first", path)};
    if (reaches_beyond(sizes))
      return Error{
          ErrorCode::Corrupt,
          fmt::format("'{}' is damaged: its picture, {}x{} from {},{}, reaches beyond its raw data of "
                      "{}x{}; copy it again, or leave it out",
                      path, sizes.width, sizes.height, sizes.left_margin, sizes.top_margin, sizes.raw_width,
                      sizes.raw_height)};
    const unsigned white = white_of(raw.imgdata.color);
    facts_.bits = std::clamp(static_cast<int>(std::bit_width(white)), 8, 16);
    facts_.orientation = orientation_of_flip(sizes.flip);
    facts_.layout = upright_layout(*layout, facts_.orientation, sizes.height, sizes.width);
    facts_.linear = true, facts_.still = true;
    facts_.model = camera_model(raw.imgdata.idata.make, raw.imgdata.idata.model);
    facts_.format = facts_.model.empty() ? "raw" : "raw of " + facts_.model;
    facts_.focal_35mm_mm = raw.imgdata.lens.FocalLengthIn35mmFormat;
    facts_.white = static_cast<int>(white);
    const CodeStretch stretch(clip_white > 0 ? static_cast<unsigned>(clip_white) : white, white, facts_.bits);
    take_codes(codes, sizes);
    for (std::uint16_t& code : frame_.codes.samples()) code = stretch.code(code);
    facts_.white_balance = white_balance_of(raw.imgdata.color);
    taken_ = exif_time(extras.date_time, extras.sub_second, extras.offset);
    frame_.facts.black_level = BlackLevel::of_code(stretch.level(black_of(raw.imgdata)), facts_.bits);
    add_exposure(raw, extras);
    return {};
  }

 private:
  // The visible part of the sensor's, upright.
  void take_codes(const ushort* codes, const libraw_image_sizes_t& sizes) {
    const auto stride = static_cast<std::ptrdiff_t>(sizes.raw_pitch / sizeof(ushort));
    const StoredPlane stored{codes + sizes.top_margin * stride + sizes.left_margin, stride, sizes.height,
                             sizes.width};
    reshape_upright(1, stored.rows, stored.cols, facts_.orientation, frame_.codes);
    place_upright(stored, facts_.orientation, frame_.codes.plane(0));
  }

  void add_exposure(const LibRaw& raw, const ExifExtras& extras) {
    FrameFacts& facts = frame_.facts;
    facts.exposure_source = ExposureSource::Unknown;
    const libraw_imgother_t& other = raw.imgdata.other;
    if (!(other.shutter > 0) || extras.endless) return;
    const auto stated = [](float value) {
      return value > 0 ? std::optional(static_cast<double>(value)) : std::nullopt;
    };
    ExifExposure exposure{static_cast<double>(other.shutter), stated(other.iso_speed),
                          stated(other.aperture)};
    constexpr double kOrMore = 65535;  // as in a JPEG (video_file.cpp)
    if (!exposure.iso || *exposure.iso == kOrMore)
      exposure.iso = stated(static_cast<float>(extras.sensitivity));
    take_exif_exposure(exposure, facts);
    factors_ = factors_of(exposure);
  }

  PictureFileFacts facts_;
  std::optional<ExifTime> taken_;
  ExifFactors factors_;
  RawFrame frame_;
  bool read_ = false;
};

}  // namespace

bool is_raw_still(const std::string& path) {
  return std::ranges::find(kExtensions, lower_extension(path)) != std::end(kExtensions);
}

Result<std::unique_ptr<PictureFile>> open_raw_still(Storage& storage, const std::string& path,
                                                    int clip_white) {
  std::string bytes = TRY(read_whole(storage, path));
  const auto raw = std::make_unique<LibRaw>();  // some hundred kilobytes
  ExifExtras extras;
  raw->set_exifparser_handler(read_extras, &extras);
  raw->set_dataerror_handler(nullptr, nullptr);  // which prints; errors are counted all the same
  const int opened = raw->open_buffer(bytes.data(), bytes.size());
  if (opened == LIBRAW_IO_ERROR)
    return Error{
        ErrorCode::NotRecording,
        fmt::format(
            "'{}' ends too early for a raw still: it is none, or was cut; copy it again, or leave it out",
            path)};
  if (opened != LIBRAW_SUCCESS)
    return Error{ErrorCode::NotRecording,
                 fmt::format("'{}' is not a raw still that LibRaw knows: {}", path, libraw_strerror(opened))};
  if (mixes_tiles(*raw))
    return Error{
        ErrorCode::Unsupported,
        fmt::format("'{}' is a DNG in tiles without compression, which this machine's LibRaw reads in "
                    "the wrong order; convert it to a DNG with lossless compression",
                    path)};
  const auto damaged = [&path](const std::string& why) {
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' is damaged: {}; copy it again, or leave it out", path, why)};
  };
  if (raw->imgdata.idata.dng_version != 0 &&
      lacks_parts(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size())))
    return damaged("it was cut, and parts of its picture are missing");
  if (const int code = raw->unpack(); code != LIBRAW_SUCCESS) return damaged(libraw_strerror(code));
  if (raw->error_count() > 0) return damaged("its raw data do not decode");
  auto still = std::make_unique<RawStill>();
  TRY(still->develop(*raw, extras, path, clip_white));
  return std::unique_ptr<PictureFile>(std::move(still));
}

}  // namespace hdrcam
