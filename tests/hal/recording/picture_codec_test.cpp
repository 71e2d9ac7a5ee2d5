// The coded picture alone, without the container, whose own checksums would notice first.
#include "hal/recording/picture_codec.h"

#include <algorithm>
#include <tuple>

#include "tests/hal/recording/sample_recordings.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

struct Parameters {
  AVCodecParameters* codec = avcodec_parameters_alloc();
  ~Parameters() { avcodec_parameters_free(&codec); }
};

TEST_CASE("a flipped bit in a coded picture is noticed by the decoder itself, from the slices' checksums") {
  const RecordingCodec codec = RecordingCodec::Ffv1;  // Huffyuv has no checksums of its own
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 12, 96, 72);
  const auto frames = sample::frames(camera, 1, 17);
  PictureEncoder encoder = value_of(PictureEncoder::open(camera, codec));
  Parameters parameters;
  REQUIRE(avcodec_parameters_from_context(parameters.codec, encoder.context()) >= 0);
  AVPacket* packet = value_of(encoder.encode(frames[0].codes));
  REQUIRE(packet->size > 5000);

  PictureDecoder decoder = value_of(PictureDecoder::open(camera, *parameters.codec));
  Image<std::uint16_t> codes;
  require_done(decoder.decode(*packet, codes));
  REQUIRE(sample::same(codes, frames[0].codes));

  int flips = 0, noticed = 0;
  for (int byte = 0; byte < packet->size; byte += 37) {
    packet->data[byte] ^= 0x10;
    PictureDecoder fresh = value_of(PictureDecoder::open(camera, *parameters.codec));
    ++flips, noticed += fresh.decode(*packet, codes).error().code == ErrorCode::Corrupt ? 1 : 0;
    packet->data[byte] ^= 0x10;
  }
  CHECK(noticed == flips);
}

TEST_CASE("FFV1 takes pictures that are too large for four slices") {
  for (const auto& [layout, bits, width, height] :
       {std::tuple{PixelLayout::Rgb, 8, 7680, 4320}, std::tuple{PixelLayout::BayerRggb, 16, 6200, 5800}}) {
    const auto encoder =
        PictureEncoder::open(sample::camera(layout, bits, width, height), RecordingCodec::Ffv1);
    INFO(width << "x" << height << ", " << bits << " bits");
    CHECK(sample::error_of(encoder).message == "no error");
  }
}

TEST_CASE("a picture that is too large for Huffyuv is refused before the run, with a codec that holds it") {
  const auto refused =
      PictureEncoder::open(sample::camera(PixelLayout::Mono, 8, 16384, 10923), RecordingCodec::Huffyuv);
  require_error(refused, ErrorCode::Invalid);
  CHECK(refused.error().message ==
        "Huffyuv holds pictures of up to 178 megapixels, not 16384x10923; choose --record-codec ffv1, or a "
        "smaller size");
}

TEST_CASE("FFV1 keeps pictures that are short and wide, or narrow and high") {
  for (const auto& [width, height] : {std::pair{640, 60}, {4, 353}, {63, 289}, {352, 63}, {63, 288}}) {
    CAPTURE(width, height);
    const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, width, height);
    const auto frames = sample::frames(camera, 1, 5);
    PictureEncoder encoder = value_of(PictureEncoder::open(camera, RecordingCodec::Ffv1));
    Parameters parameters;
    REQUIRE(avcodec_parameters_from_context(parameters.codec, encoder.context()) >= 0);
    const AVPacket* packet = value_of(encoder.encode(frames[0].codes));
    Image<std::uint16_t> codes;
    require_done(value_of(PictureDecoder::open(camera, *parameters.codec)).decode(*packet, codes));
    CHECK(sample::same(codes, frames[0].codes));
  }
}

TEST_CASE("a program that knows nothing of this one finds red where the format has it") {
  const auto [codec, bits] =
      GENERATE(std::pair{RecordingCodec::Huffyuv, 8}, std::pair{RecordingCodec::Huffyuv, 10},
               std::pair{RecordingCodec::Ffv1, 8}, std::pair{RecordingCodec::Ffv1, 10});
  {
    const CameraFacts camera = sample::camera(PixelLayout::Rgb, bits, 32, 24);
    Image<std::uint16_t> codes(3, camera.height, camera.width);
    for (int c = 0; c < 3; ++c)
      std::fill_n(codes.plane(c), codes.plane_size(), static_cast<std::uint16_t>(50 * (c + 1)));
    PictureEncoder encoder = value_of(PictureEncoder::open(camera, codec));
    const AVPacket* packet = value_of(encoder.encode(codes));

    libav::CodecContext player(avcodec_alloc_context3(avcodec_find_decoder(encoder.context()->codec_id)));
    Parameters parameters;
    REQUIRE(avcodec_parameters_from_context(parameters.codec, encoder.context()) >= 0);
    REQUIRE(avcodec_parameters_to_context(player.get(), parameters.codec) >= 0);
    REQUIRE(avcodec_open2(player.get(), nullptr, nullptr) >= 0);
    const libav::Frame frame(av_frame_alloc());
    REQUIRE(avcodec_send_packet(player.get(), packet) >= 0);
    REQUIRE(avcodec_receive_frame(player.get(), frame.get()) >= 0);
    if (codec == RecordingCodec::Huffyuv && bits == 8) {
      REQUIRE(frame->format == AV_PIX_FMT_GBRP);
      CHECK(frame->data[0][0] == 100);
      CHECK(frame->data[1][0] == 150);
      CHECK(frame->data[2][0] == 50);
    } else if (bits == 8) {
      REQUIRE(frame->format == AV_PIX_FMT_0RGB32);
      CHECK((*reinterpret_cast<const std::uint32_t*>(frame->data[0]) & 0xffffffu) ==
            (50u << 16 | 100u << 8 | 150u));
    } else {
      REQUIRE(frame->format == AV_PIX_FMT_GBRP10);
      const auto first_of = [&](int plane) {
        return *reinterpret_cast<const std::uint16_t*>(frame->data[plane]);
      };
      CHECK(first_of(0) == 100);  // green
      CHECK(first_of(1) == 150);  // blue
      CHECK(first_of(2) == 50);   // red
    }
  }
}

}  // namespace
}  // namespace hdrcam
