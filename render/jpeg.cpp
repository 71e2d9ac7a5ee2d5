#include "render/jpeg.h"

#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>  // jpeglib.h takes it for granted
#include <new>

#include <jerror.h>
#include <jpeglib.h>

namespace hdrcam {
namespace {

constexpr std::size_t kFirstBytes = 64 << 10;  // doubled as often as the file needs it

// libjpeg reports errors through longjmp, so the functions that call it hold no object with a destructor:
// their state is here. The file's bytes are, too: those of jpeg_mem_dest() have no owner after an error.
struct Encoding {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_destination_mgr destination{};
  std::jmp_buf escape{};
  char reason[JMSG_LENGTH_MAX] = "";
  std::vector<JOCTET> bytes;  // the file, then room for more of it
  std::vector<JSAMPLE> line;

  Encoding() = default;
  ~Encoding() { jpeg_destroy_compress(&jpeg); }
  Encoding(const Encoding&) = delete;
  Encoding& operator=(const Encoding&) = delete;
};

[[noreturn]] void give_up(j_common_ptr jpeg) {
  auto& encoding = *static_cast<Encoding*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, encoding.reason);
  std::longjmp(encoding.escape, 1);
}

void no_output(j_common_ptr) {}

// No exception may pass libjpeg's functions.
bool resized(std::vector<JOCTET>& bytes, std::size_t size) noexcept {
  try {
    bytes.resize(size);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

// Adds room behind the first `filled` bytes.
void add_room(j_compress_ptr jpeg, std::size_t filled, std::size_t size) {
  auto& encoding = *static_cast<Encoding*>(jpeg->client_data);
  if (!resized(encoding.bytes, size)) {
    jpeg->err->msg_code = JERR_OUT_OF_MEMORY;
    jpeg->err->msg_parm.i[0] = 0;
    give_up(reinterpret_cast<j_common_ptr>(jpeg));
  }
  encoding.destination.next_output_byte = encoding.bytes.data() + filled;
  encoding.destination.free_in_buffer = size - filled;
}

void begin_file(j_compress_ptr jpeg) { add_room(jpeg, 0, kFirstBytes); }

// libjpeg calls this when all of the room is filled.
boolean enlarge_file(j_compress_ptr jpeg) {
  const std::size_t filled = static_cast<Encoding*>(jpeg->client_data)->bytes.size();
  add_room(jpeg, filled, 2 * filled);
  return TRUE;
}

void end_file(j_compress_ptr jpeg) {
  auto& encoding = *static_cast<Encoding*>(jpeg->client_data);
  encoding.bytes.resize(encoding.bytes.size() - encoding.destination.free_in_buffer);
}

void interleave(const Image<std::uint8_t>& picture, int y, std::vector<JSAMPLE>& line) {
  const std::uint8_t* r = picture.row(0, y);
  const std::uint8_t* g = picture.row(1, y);
  const std::uint8_t* b = picture.row(2, y);
  JSAMPLE* sample = line.data();
  for (int x = 0; x < picture.cols(); ++x) *sample++ = r[x], *sample++ = g[x], *sample++ = b[x];
}

bool encode(Encoding& encoding, const Image<std::uint8_t>& picture, int quality) {
  jpeg_compress_struct& jpeg = encoding.jpeg;
  jpeg.err = jpeg_std_error(&encoding.errors);
  encoding.errors.error_exit = give_up;
  encoding.errors.output_message = no_output;
  jpeg.client_data = &encoding;
  if (setjmp(encoding.escape) != 0) return false;
  jpeg_create_compress(&jpeg);
  encoding.destination.init_destination = begin_file;
  encoding.destination.empty_output_buffer = enlarge_file;
  encoding.destination.term_destination = end_file;
  jpeg.dest = &encoding.destination;
  jpeg.image_width = static_cast<JDIMENSION>(picture.cols());
  jpeg.image_height = static_cast<JDIMENSION>(picture.rows());
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  JSAMPROW line = encoding.line.data();
  for (int y = 0; y < picture.rows(); ++y) {
    interleave(picture, y, encoding.line);
    jpeg_write_scanlines(&jpeg, &line, 1);
  }
  jpeg_finish_compress(&jpeg);
  return true;
}

}  // namespace

Result<std::vector<std::byte>> encode_jpeg(const Image<std::uint8_t>& picture, int quality) {
  if (picture.channels() != 3 || picture.plane_size() == 0 || picture.rows() > JPEG_MAX_DIMENSION ||
      picture.cols() > JPEG_MAX_DIMENSION)
    return Error{ErrorCode::Invalid,
                 fmt::format("a JPEG holds 3 channels of at most {0}x{0} pixels, not {1} of {2}x{3}",
                             JPEG_MAX_DIMENSION, picture.channels(), picture.cols(), picture.rows())};
  Encoding encoding;
  encoding.line.resize(3 * static_cast<std::size_t>(picture.cols()));
  if (!encode(encoding, picture, quality))
    return Error{ErrorCode::Io, fmt::format("libjpeg cannot encode a picture of {}x{} pixels: {}",
                                            picture.cols(), picture.rows(), encoding.reason)};
  const auto* const first = reinterpret_cast<const std::byte*>(encoding.bytes.data());
  return std::vector<std::byte>(first, first + encoding.bytes.size());
}

}  // namespace hdrcam
