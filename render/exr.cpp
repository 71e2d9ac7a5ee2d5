#include "render/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "render/exr_header.h"
#include "render/half_kernels.h"

namespace hdrcam {
namespace {

// 2 GiB of floats, 7680x4320 pixels with all layers of a frame: a larger size means damage.
constexpr std::size_t kMaxSamples = std::size_t{1} << 29;
constexpr int kMaxSide = 1 << 16;

class BytesOut : public Imf::OStream {
 public:
  explicit BytesOut(std::vector<std::byte> room) : OStream("memory"), bytes_(std::move(room)) {
    bytes_.clear();
  }

  void write(const char c[], int n) override {
    const auto bytes = std::as_bytes(std::span(c, static_cast<std::size_t>(n)));
    if (position_ > bytes_.size()) bytes_.resize(position_);
    const std::size_t replaced = std::min(bytes.size(), bytes_.size() - position_);
    std::copy_n(bytes.begin(), replaced, bytes_.data() + position_);
    bytes_.insert(bytes_.end(), bytes.begin() + static_cast<std::ptrdiff_t>(replaced), bytes.end());
    position_ += bytes.size();
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t position_ = 0;
};

class BytesIn : public Imf::IStream {
 public:
  BytesIn(std::span<const std::byte> bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}

  bool read(char c[], int n) override {
    const auto wanted = static_cast<std::size_t>(n);
    if (position_ > bytes_.size() || wanted > bytes_.size() - position_) {
      ended_early_ = true;
      throw std::runtime_error("unexpected end of the file");
    }
    std::memcpy(c, bytes_.data() + position_, wanted);
    position_ += wanted;
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

  bool ended_early() const { return ended_early_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  bool ended_early_ = false;
};

Imf::Compression library_name(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::None:
      return Imf::NO_COMPRESSION;
    case ExrCompression::Rle:
      return Imf::RLE_COMPRESSION;
    case ExrCompression::Zip:
      return Imf::ZIP_COMPRESSION;
    case ExrCompression::Piz:
      return Imf::PIZ_COMPRESSION;
  }
  return Imf::ZIP_COMPRESSION;
}

bool all_finite(std::span<const float> samples) {
  bool finite = true;
  for (const float v : samples) finite &= std::isfinite(v);
  return finite;
}

std::vector<std::uint16_t> to_half(std::span<const float> samples) {
  std::vector<std::uint16_t> halves(samples.size());
  HDRCAM_CHECK(half_kernels().to_half(samples.data(), samples.size(), halves.data()));
  return halves;
}

// The library requires a writable pointer to data that it only reads.
Imf::Slice slice_of(const void* samples, Imf::PixelType type, std::size_t bytes_per_sample, int cols) {
  return {type, const_cast<char*>(static_cast<const char*>(samples)), bytes_per_sample,
          bytes_per_sample * static_cast<std::size_t>(cols)};
}

std::vector<std::byte> write_file(const ExrPicture& picture, std::vector<std::byte> room) {
  Imf::Header header(picture.cols, picture.rows);
  header.compression() = library_name(picture.compression);
  add_attributes(picture.attributes, header);
  Imf::FrameBuffer frame;
  std::vector<std::vector<std::uint16_t>> halves;
  halves.reserve(picture.channels.size());
  for (const ExrChannel& channel : picture.channels) {
    const bool half = channel.stored == ExrSample::Half;
    const Imf::PixelType type = half ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(channel.name, Imf::Channel(type));
    const void* samples = half
                              ? static_cast<const void*>(halves.emplace_back(to_half(channel.samples)).data())
                              : channel.samples.data();
    frame.insert(channel.name,
                 slice_of(samples, type, half ? sizeof(std::uint16_t) : sizeof(float), picture.cols));
  }
  BytesOut out(std::move(room));
  {
    Imf::OutputFile file(out, header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(picture.rows);
  }
  return out.take();
}

// Whether a file of so many bytes can hold so many samples: a few damaged bytes of a header must not cost
// gigabytes. Deflate packs 1032 to 1 at most, PIZ about 410 and the others less; only the discrete cosine
// transform (DWA) of a flat picture does better.
bool can_hold(std::size_t file_bytes, const Imf::Header& header, std::size_t samples) {
  const bool transform =
      header.compression() == Imf::DWAA_COMPRESSION || header.compression() == Imf::DWAB_COMPRESSION;
  const std::size_t most_per_byte = transform ? 100'000 : 1100;
  constexpr std::size_t kBytesPerSample = 2;  // at least
  return samples / most_per_byte <= file_bytes / kBytesPerSample;
}

// The picture may be larger than the data; by how much, or how many pixels in any case. Else a few damaged
// bytes of a header would cost memory.
constexpr std::size_t kMostBesideData = 64, kUltraHighDefinition = std::size_t{1} << 23;

int width_of(const Imath::Box2i& window) { return window.max.x - window.min.x + 1; }
int height_of(const Imath::Box2i& window) { return window.max.y - window.min.y + 1; }

// The picture is what is displayed: a file may have data beyond it, or only of a part, outside which it is
// black.
Image<float> shown(const Image<float>& data, const Imath::Box2i& window, const Imath::Box2i& display) {
  Image<float> picture(data.channels(), height_of(display), width_of(display));
  const int left = std::max(window.min.x, display.min.x), right = std::min(window.max.x, display.max.x);
  const int top = std::max(window.min.y, display.min.y), bottom = std::min(window.max.y, display.max.y);
  for (int c = 0; c < data.channels(); ++c)
    for (int y = top; y <= bottom && left <= right; ++y)
      std::copy_n(data.row(c, y - window.min.y) + (left - window.min.x), right - left + 1,
                  picture.row(c, y - display.min.y) + (left - display.min.x));
  return picture;
}

Result<std::vector<std::string>> channel_names(const Imf::Header& header, const std::string& name) {
  std::vector<std::string> names;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
      return Error{
          ErrorCode::Unsupported,
          fmt::format("channel '{}' of '{}' is subsampled; save it at full resolution", it.name(), name)};
    names.emplace_back(it.name());
  }
  return names;
}

// Before any memory is taken for it.
Result<void> check_possible(const Imf::Header& header, std::size_t channels, std::size_t file_bytes,
                            const std::string& name) {
  // The library limits the data but not what is displayed, whose samples may be more than a size_t counts.
  const auto samples_of = [&](const Imath::Box2i& window) -> std::size_t {
    const std::size_t pixels = pixel_count(height_of(window), width_of(window));
    return channels != 0 && pixels > kMaxSamples / channels ? kMaxSamples + 1 : pixels * channels;
  };
  const Imath::Box2i &window = header.dataWindow(), &display = header.displayWindow();
  const std::size_t samples = samples_of(window), shown_samples = samples_of(display);
  const std::size_t most_shown = std::max(kMostBesideData * samples, kUltraHighDefinition * channels);
  if (samples == 0 || samples > kMaxSamples || shown_samples == 0 || shown_samples > kMaxSamples ||
      shown_samples > most_shown)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' states {} channels of {}x{} in a picture of {}x{}, which is none or more "
                             "than hdrcam reads ({} samples, and {} times the data): it is damaged, or to be "
                             "saved smaller",
                             name, channels, width_of(window), height_of(window), width_of(display),
                             height_of(display), kMaxSamples, kMostBesideData)};
  if (!can_hold(file_bytes, header, samples))
    return Error{ErrorCode::Truncated,
                 fmt::format("'{}' has {} bytes, too few for {} channels of {}x{}: it was cut, or is damaged",
                             name, file_bytes, channels, width_of(window), height_of(window))};
  return {};
}

Result<ExrImage> read_file(BytesIn& in, std::size_t file_bytes, const std::string& name) {
  Imf::InputFile file(in, 0);
  const Imf::Header& header = file.header();
  const Imath::Box2i &window = header.dataWindow(), &display = header.displayWindow();
  const int cols = width_of(window), rows = height_of(window);
  ExrImage image;
  image.names = TRY(channel_names(header, name));
  TRY(check_possible(header, image.names.size(), file_bytes, name));
  image.attributes = attributes_of(header);
  image.samples = Image<float>(static_cast<int>(image.names.size()), rows, cols);
  Imf::FrameBuffer frame;
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(cols);
  for (int c = 0; c < image.samples.channels(); ++c)
    frame.insert(image.names[static_cast<std::size_t>(c)],
                 Imf::Slice::Make(Imf::FLOAT, image.samples.plane(c), window, sizeof(float), row_bytes));
  file.setFrameBuffer(frame);
  file.readPixels(window.min.y, window.max.y);
  if (window != display) image.samples = shown(image.samples, window, display);
  return image;
}

bool is_openexr(std::span<const std::byte> bytes) {
  constexpr std::array kMagic{std::byte{0x76}, std::byte{0x2f}, std::byte{0x31}, std::byte{0x01}};
  const std::size_t known = std::min(bytes.size(), kMagic.size());  // of a cut file fewer
  return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), kMagic.begin());
}

// What the library says of a file, without the name that our message has already, and without its full stop.
std::string reason_of(const std::exception& thrown, const std::string& name) {
  std::string reason = thrown.what();
  const std::string said = fmt::format("Cannot read image file \"{}\". ", name);
  if (reason.starts_with(said)) reason.erase(0, said.size());
  while (reason.ends_with('.')) reason.pop_back();
  return reason;
}

// What `read` makes of an OpenEXR file, whose reader throws.
template <class Read>
auto read_safely(std::span<const std::byte> bytes, const std::string& name, const Read& read)
    -> decltype(read(std::declval<BytesIn&>())) {
  static const bool limited = (Imf::Header::setMaxImageSize(kMaxSide, kMaxSide), true);
  (void)limited;
  if (!is_openexr(bytes))
    return Error{ErrorCode::Corrupt, fmt::format("'{}' is not an OpenEXR picture", name)};
  BytesIn in(bytes, name);
  try {
    return read(in);
  } catch (const std::exception& e) {
    if (in.ended_early() && !bytes.empty())
      return Error{ErrorCode::Truncated, fmt::format("'{}' ends in the middle; write it again", name)};
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' is not a readable OpenEXR picture: {}", name, reason_of(e, name))};
  }
}

}  // namespace

std::optional<int> ExrImage::find(std::string_view name) const {
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) return std::nullopt;
  return static_cast<int>(it - names.begin());
}

Result<std::vector<std::byte>> encode_exr(const ExrPicture& picture, std::vector<std::byte> room) {
  HDRCAM_CHECK(picture.rows > 0 && picture.cols > 0 && !picture.channels.empty());
  for (const ExrChannel& channel : picture.channels) {
    HDRCAM_CHECK_EQ(channel.samples.size(), pixel_count(picture.rows, picture.cols));
    if (channel.stored == ExrSample::Float) HDRCAM_CHECK(all_finite(channel.samples));
  }
  try {
    return write_file(picture, std::move(room));
  } catch (const std::exception& e) {
    return Error{ErrorCode::Io, fmt::format("cannot encode a {}x{} picture as OpenEXR: {}", picture.cols,
                                            picture.rows, e.what())};
  }
}

Result<ExrImage> decode_exr(std::span<const std::byte> bytes, const std::string& name) {
  return read_safely(bytes, name, [&](BytesIn& in) { return read_file(in, bytes.size(), name); });
}

Result<ExrAttributes> read_exr_attributes(Storage& storage, const std::string& path) {
  const std::string bytes = TRY(read_whole(storage, path));
  return read_safely(std::as_bytes(std::span(bytes)), path, [](BytesIn& in) -> Result<ExrAttributes> {
    return attributes_of(Imf::InputFile(in, 0).header());
  });
}

Result<ExrImage> read_exr(Storage& storage, const std::string& path) {
  const std::string bytes = TRY(read_whole(storage, path));
  return decode_exr(std::as_bytes(std::span(bytes)), path);
}

}  // namespace hdrcam
