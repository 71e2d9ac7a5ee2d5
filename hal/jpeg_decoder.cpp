#include "hal/jpeg_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>  // jpeglib.h takes it for granted
#include <memory>
#include <vector>

#include <jerror.h>
#include <jpeglib.h>

namespace hdrcam {
namespace {

constexpr int kTables = 2;  // the standard has one for luma, one for chroma

// libjpeg reports errors through longjmp, so the functions that call it hold no object with a destructor:
// their state is here.
struct Decoding {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_source_mgr source{};
  std::jmp_buf escape{};
  char reason[JMSG_LENGTH_MAX] = "";
  JHUFF_TBL standard_dc[kTables]{}, standard_ac[kTables]{};
  std::vector<JSAMPLE> line;

  Decoding();
  ~Decoding() { jpeg_destroy_decompress(&jpeg); }
  Decoding(const Decoding&) = delete;
  Decoding& operator=(const Decoding&) = delete;
};

[[noreturn]] void give_up(j_common_ptr jpeg) {
  auto& decoding = *static_cast<Decoding*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, decoding.reason);
  std::longjmp(decoding.escape, 1);
}

// level: -1 for a warning. Some cameras pad the data before a marker, which is harmless; every other warning
// means that a part of the picture was invented.
void judge_message(j_common_ptr jpeg, int level) {
  const int code = jpeg->err->msg_code;
  if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_JFIF_MAJOR) give_up(jpeg);
}

void no_output(j_common_ptr) {}

void nothing(j_decompress_ptr) {}

// An end marker follows the last byte, because some cameras omit it. The decoder detects data that is missing
// before it.
boolean give_end_marker(j_decompress_ptr jpeg) {
  static constexpr JOCTET kEnd[] = {0xff, JPEG_EOI};
  jpeg->src->next_input_byte = kEnd;
  jpeg->src->bytes_in_buffer = sizeof kEnd;
  return TRUE;
}

void skip_bytes(j_decompress_ptr jpeg, long count) {
  if (count <= 0) return;
  const auto skipped = std::min(static_cast<std::size_t>(count), jpeg->src->bytes_in_buffer);
  jpeg->src->next_input_byte += skipped;
  jpeg->src->bytes_in_buffer -= skipped;
}

// The standard's Huffman tables, as libjpeg writes them by default.
void copy_standard_tables(Decoding& decoding) {
  jpeg_compress_struct writer{};
  writer.err = &decoding.errors;
  writer.client_data = &decoding;
  jpeg_create_compress(&writer);
  writer.input_components = 3;
  writer.in_color_space = JCS_RGB;
  jpeg_set_defaults(&writer);
  for (int i = 0; i < kTables; ++i) {
    decoding.standard_dc[i] = *writer.dc_huff_tbl_ptrs[i];
    decoding.standard_ac[i] = *writer.ac_huff_tbl_ptrs[i];
  }
  jpeg_destroy_compress(&writer);
}

Decoding::Decoding() {
  jpeg.err = jpeg_std_error(&errors);
  errors.error_exit = give_up;
  errors.emit_message = judge_message;
  errors.output_message = no_output;
  jpeg.client_data = this;
  const bool failed = setjmp(escape) != 0;
  HDRCAM_CHECK(!failed);  // only for want of memory, or of a library that fits its header
  copy_standard_tables(*this);
  jpeg_create_decompress(&jpeg);
  for (int i = 0; i < kTables; ++i) {
    jpeg.dc_huff_tbl_ptrs[i] = jpeg_alloc_huff_table(reinterpret_cast<j_common_ptr>(&jpeg));
    jpeg.ac_huff_tbl_ptrs[i] = jpeg_alloc_huff_table(reinterpret_cast<j_common_ptr>(&jpeg));
  }
  source.init_source = nothing;
  source.fill_input_buffer = give_end_marker;
  source.skip_input_data = skip_bytes;
  source.resync_to_restart = jpeg_resync_to_restart;
  source.term_source = nothing;
  jpeg.src = &source;
}

bool read_header(Decoding& decoding, std::span<const std::byte> bytes) {
  if (setjmp(decoding.escape) != 0) return false;
  jpeg_decompress_struct& jpeg = decoding.jpeg;
  // A frame's own table stays in the object, so the standard's tables are restored for a frame without one.
  for (int i = 0; i < kTables; ++i) {
    *jpeg.dc_huff_tbl_ptrs[i] = decoding.standard_dc[i];
    *jpeg.ac_huff_tbl_ptrs[i] = decoding.standard_ac[i];
  }
  decoding.source.next_input_byte = reinterpret_cast<const JOCTET*>(bytes.data());
  decoding.source.bytes_in_buffer = bytes.size();
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_RGB;
  return true;
}

bool read_pixels(Decoding& decoding, Image<std::uint16_t>& rgb) {
  if (setjmp(decoding.escape) != 0) return false;
  jpeg_start_decompress(&decoding.jpeg);
  JSAMPROW line = decoding.line.data();
  for (int y = 0; y < rgb.rows(); ++y) {
    jpeg_read_scanlines(&decoding.jpeg, &line, 1);
    std::uint16_t* r = rgb.row(0, y);
    std::uint16_t* g = rgb.row(1, y);
    std::uint16_t* b = rgb.row(2, y);
    for (int x = 0; x < rgb.cols(); ++x) r[x] = line[3 * x], g[x] = line[3 * x + 1], b[x] = line[3 * x + 2];
  }
  return true;
}

Result<void> decode(Decoding& decoding, std::span<const std::byte> bytes, Image<std::uint16_t>& rgb) {
  HDRCAM_CHECK_EQ(rgb.channels(), 3);
  jpeg_decompress_struct& jpeg = decoding.jpeg;
  jpeg_abort_decompress(&jpeg);  // discards the state of the last picture
  const auto damaged = [&] {
    return Error{ErrorCode::Corrupt,
                 fmt::format("a JPEG of {} bytes is damaged: {}", bytes.size(), decoding.reason)};
  };
  if (!read_header(decoding, bytes)) return damaged();
  if (static_cast<int>(jpeg.image_width) != rgb.cols() || static_cast<int>(jpeg.image_height) != rgb.rows())
    return Error{ErrorCode::Corrupt,
                 fmt::format("a JPEG is {}x{} where the stream is {}x{}", jpeg.image_width, jpeg.image_height,
                             rgb.cols(), rgb.rows())};
  // Each further scan costs a pass over the picture for a handful of bytes.
  if (jpeg_has_multiple_scans(&jpeg))
    return Error{ErrorCode::Corrupt, "a JPEG has several scans; MJPEG is baseline, with one"};
  decoding.line.resize(3 * static_cast<std::size_t>(rgb.cols()));
  if (!read_pixels(decoding, rgb)) return damaged();
  return {};
}

}  // namespace

DecodeJpeg jpeg_decoder() {
  return
      [decoding = std::make_shared<Decoding>()](std::span<const std::byte> jpeg, Image<std::uint16_t>& rgb) {
        return decode(*decoding, jpeg, rgb);
      };
}

}  // namespace hdrcam
