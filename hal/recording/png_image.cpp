#include "hal/recording/png_image.h"

#include <png.h>

#include <csetjmp>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "hal/core/counted.h"

namespace hdrcam {
namespace {

constexpr png_uint_32 kMaxSidePng = 1u << 20;  // larger ones are refused before anything is allocated
constexpr int kCompression = 4, kFastCompression = 1;

// libpng reports errors through longjmp, so the functions that call it hold no object with a destructor:
// their state is here, in the caller.
struct Reading {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const std::byte> rest;  // of the file
  int cols = 0, rows = 0;           // as found
  int bit_depth = 0, color_type = 0;
  std::size_t row_bytes = 0;
  std::vector<png_byte> bytes;
  std::vector<png_bytep> lines;
  std::string failure;

  ~Reading() { png_destroy_read_struct(&png, &info, nullptr); }
};

struct Writing {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::byte> file;
  std::vector<png_byte> bytes;
  std::vector<png_bytep> lines;
  std::string failure;

  ~Writing() { png_destroy_write_struct(&png, &info); }
};

template <class Work>
void keep_failure(png_structp png, png_const_charp message) {
  static_cast<Work*>(png_get_error_ptr(png))->failure = message;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

void take_bytes(png_structp png, png_bytep out, std::size_t size) {
  auto& reading = *static_cast<Reading*>(png_get_io_ptr(png));
  if (size > reading.rest.size()) png_error(png, "the file ends in the middle");
  std::memcpy(out, reading.rest.data(), size);
  reading.rest = reading.rest.subspan(size);
}

void give_bytes(png_structp png, png_bytep bytes, std::size_t size) {
  auto& file = static_cast<Writing*>(png_get_io_ptr(png))->file;
  const auto* begin = reinterpret_cast<const std::byte*>(bytes);
  file.insert(file.end(), begin, begin + size);
}

void no_flush(png_structp) {}

bool read_header(Reading& reading) {
  if (setjmp(png_jmpbuf(reading.png)) != 0) return false;
  png_set_read_fn(reading.png, &reading, take_bytes);
  png_set_user_limits(reading.png, kMaxSidePng, kMaxSidePng);
  png_read_info(reading.png, reading.info);
  reading.cols = static_cast<int>(png_get_image_width(reading.png, reading.info));
  reading.rows = static_cast<int>(png_get_image_height(reading.png, reading.info));
  reading.bit_depth = png_get_bit_depth(reading.png, reading.info);
  reading.color_type = png_get_color_type(reading.png, reading.info);
  if (reading.color_type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(reading.png);
  png_set_strip_alpha(reading.png);
  png_set_interlace_handling(reading.png);
  png_read_update_info(reading.png, reading.info);
  reading.row_bytes = png_get_rowbytes(reading.png, reading.info);
  return true;
}

bool read_pixels(Reading& reading) {
  if (setjmp(png_jmpbuf(reading.png)) != 0) return false;
  png_read_image(reading.png, reading.lines.data());
  png_read_end(reading.png, nullptr);
  return true;
}

bool write_all(Writing& writing, const PngImage& image, int compression) {
  const int rows = image.samples.rows(), cols = image.samples.cols(), channels = image.samples.channels();
  if (setjmp(png_jmpbuf(writing.png)) != 0) return false;
  png_set_write_fn(writing.png, &writing, give_bytes, no_flush);
  png_set_compression_level(writing.png, compression);
  png_set_IHDR(writing.png, writing.info, static_cast<png_uint_32>(cols), static_cast<png_uint_32>(rows),
               image.bits_per_sample, channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writing.png, writing.info);
  if (image.colors) {  // the library has no function for it
    constexpr png_byte kMatrixRgb = 0, kFullRange = 1;
    const png_byte fields[] = {image.colors->primaries, image.colors->transfer, kMatrixRgb, kFullRange};
    png_write_chunk(writing.png, reinterpret_cast<png_const_bytep>("cICP"), fields, sizeof fields);
  }
  png_write_image(writing.png, writing.lines.data());
  png_write_end(writing.png, nullptr);
  return true;
}

template <class Work>
void lay_out_rows(Work& work, int rows, std::size_t row_bytes) {
  work.bytes.resize(static_cast<std::size_t>(rows) * row_bytes);
  for (int y = 0; y < rows; ++y)
    work.lines.push_back(work.bytes.data() + static_cast<std::size_t>(y) * row_bytes);
}

// Interleaved bytes, 16-bit samples big-endian, to planes and back.
void to_planes(const std::vector<png_bytep>& lines, int bits_per_sample, Image<std::uint16_t>& samples) {
  const int channels = samples.channels();
  for (int y = 0; y < samples.rows(); ++y) {
    const png_byte* byte = lines[static_cast<std::size_t>(y)];
    for (int x = 0; x < samples.cols(); ++x)
      for (int c = 0; c < channels; ++c) {
        unsigned value = *byte++;
        if (bits_per_sample == 16) value = value << 8 | *byte++;
        samples.at(c, y, x) = static_cast<std::uint16_t>(value);
      }
  }
}

void to_lines(const Image<std::uint16_t>& samples, int bits_per_sample, const std::vector<png_bytep>& lines) {
  for (int y = 0; y < samples.rows(); ++y) {
    png_byte* byte = lines[static_cast<std::size_t>(y)];
    for (int x = 0; x < samples.cols(); ++x)
      for (int c = 0; c < samples.channels(); ++c) {
        const unsigned value = samples.at(c, y, x);
        if (bits_per_sample == 16) *byte++ = static_cast<png_byte>(value >> 8);
        *byte++ = static_cast<png_byte>(value & 0xffu);
      }
  }
}

// What a file that is no PNG is, where its first bytes tell.
Error no_png(const std::string& path, std::string_view file) {
  using namespace std::string_view_literals;
  constexpr std::pair<std::string_view, const char*> kOthers[] = {
      {"\xff\xd8\xff"sv, "JPEG"},
      {"II*\0"sv, "TIFF"},
      {"MM\0*"sv, "TIFF"},
      {"\x76\x2f\x31\x01"sv, "OpenEXR picture"},
      {"BM"sv, "BMP"},
      {"GIF8"sv, "GIF"},
  };
  for (const auto& [start, what] : kOthers)
    if (file.starts_with(start))
      return {ErrorCode::Unsupported,
              fmt::format("'{}' is a {}; convert the frames to PNG of 8 or 16 bits", path, what)};
  return {ErrorCode::Corrupt, fmt::format("'{}' is not a PNG", path)};
}

}  // namespace

Result<PngImage> read_png(Storage& storage, const std::string& path, int cols, int rows) {
  const std::string file = TRY(read_whole(storage, path));
  if (png_sig_cmp(reinterpret_cast<png_const_bytep>(file.data()), 0, std::min<std::size_t>(file.size(), 8)) !=
          0 ||
      file.size() < 8)
    return no_png(path, file);
  Reading reading;
  reading.rest = std::as_bytes(std::span(file));
  reading.png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, keep_failure<Reading>, ignore_warning);
  reading.info = reading.png ? png_create_info_struct(reading.png) : nullptr;
  HDRCAM_CHECK(reading.info != nullptr);
  const auto broken = [&] {
    return Error{ErrorCode::Corrupt, fmt::format("'{}' is a damaged PNG: {}", path, reading.failure)};
  };
  if (!read_header(reading)) return broken();
  if (reading.cols != cols || reading.rows != rows)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("'{}' is {}x{}, expected {}x{}", path, reading.cols, reading.rows, cols, rows)};
  if (reading.bit_depth < 8 && reading.color_type == PNG_COLOR_TYPE_GRAY)
    return Error{ErrorCode::Unsupported, fmt::format("'{}' has {} a sample; use a PNG of 8 or 16", path,
                                                     counted(reading.bit_depth, "bit"))};

  PngImage image;
  image.bits_per_sample = reading.bit_depth == 16 ? 16 : 8;
  const int channels = (reading.color_type & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1;
  HDRCAM_CHECK_EQ(reading.row_bytes, static_cast<std::size_t>(cols * channels * image.bits_per_sample / 8));
  lay_out_rows(reading, rows, reading.row_bytes);
  if (!read_pixels(reading)) return broken();
  image.samples.reshape(channels, rows, cols);
  to_planes(reading.lines, image.bits_per_sample, image.samples);
  return image;
}

Result<std::vector<std::byte>> png_file(const PngImage& image, PngEase ease) {
  const int channels = image.samples.channels(), rows = image.samples.rows(), cols = image.samples.cols();
  HDRCAM_CHECK(channels == 1 || channels == 3);
  Writing writing;
  lay_out_rows(writing, rows, static_cast<std::size_t>(cols * channels * image.bits_per_sample / 8));
  to_lines(image.samples, image.bits_per_sample, writing.lines);
  writing.png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &writing, keep_failure<Writing>, ignore_warning);
  writing.info = writing.png ? png_create_info_struct(writing.png) : nullptr;
  HDRCAM_CHECK(writing.info != nullptr);
  if (!write_all(writing, image, ease == PngEase::Fast ? kFastCompression : kCompression))
    return Error{ErrorCode::Io,
                 fmt::format("a PNG of {}x{} pixels cannot be encoded: {}", cols, rows, writing.failure)};
  return std::move(writing.file);
}

Result<void> write_png(Storage& storage, const std::string& path, const PngImage& image) {
  return write_whole(storage, path, TRY(png_file(image)), Durability::WrittenBack);
}

}  // namespace hdrcam
