// Footage as other cameras leave it, of pictures whose codes are known: videos of several codecs, JPEG with
// EXIF.
#pragma once

#include <cstdio>

#include <jpeglib.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/image.h"
#include "hal/recording/libav.h"
#include "hal/video/picture_converter.h"
#include "hal/video/video_writer.h"
#include "tests/support/tiff_directory.h"

namespace hdrcam::test {

// rgb: [rgb, rows, cols] codes of 8 bits, even sides. times_s: of each picture, or none: regular.
inline Result<void> write_video(const std::string& path, VideoCodec codec,
                                const std::vector<Image<std::uint16_t>>& rgb,
                                const std::vector<double>& times_s = {}, double framerate_hz = 30) {
  VideoFormat format;
  format.width_px = rgb[0].cols(), format.height_px = rgb[0].rows();
  format.framerate_hz = framerate_hz;
  format.codec = codec, format.container = *video_container_of(path);
  format.bits = codec == VideoCodec::H264 ? 8 : 10;
  format.tags = {h273::kPrimariesBt709, h273::kTransferBt709, h273::kMatrixBt709};
  format.crf = 4;
  PictureFormat codes = format.picture();
  codes.colors = PictureColors::Rgb, codes.bits = 8, codes.store = SampleStore::Words,
  codes.range = CodeRange::Full;
  codes.chroma_shift_x = codes.chroma_shift_y = 0;
  auto converter = TRY(PictureConverter::create(codes, format.picture()));
  auto file = TRY(posix_storage().create(path));
  auto writer = TRY(VideoWriter::create(std::move(file), StorageStream::Direction::Write, format));
  Image<std::uint16_t> aligned(3, format.height_px,
                               PictureConverter::aligned_cols<std::uint16_t>(format.width_px));
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rgb[i].rows(); ++y) std::copy_n(rgb[i].row(c, y), rgb[i].cols(), aligned.row(c, y));
    TRY(converter.convert(planes_of(aligned), writer->planes()));
    const double time_s = times_s.empty() ? static_cast<double>(i) / framerate_hz : times_s[i];
    TRY(writer->append(from_seconds(time_s)));
  }
  return writer->finish(std::nullopt);
}

// The packets of a video in another container, "h264" or "nut". stated_duration: of its track, as a tag; "":
// none.
inline Result<void> remux(const std::string& video, const std::string& path, const char* container,
                          const std::string& stated_duration = "") {
  const Error failed{ErrorCode::Io, "cannot write '" + path + "'"};
  AVFormatContext *from = nullptr, *to = nullptr;
  if (avformat_open_input(&from, video.c_str(), nullptr, nullptr) < 0) return failed;
  const auto whole = [&] {
    if (avformat_find_stream_info(from, nullptr) < 0) return false;
    if (avformat_alloc_output_context2(&to, nullptr, container, path.c_str()) < 0) return false;
    AVStream* const track = avformat_new_stream(to, nullptr);
    if (avcodec_parameters_copy(track->codecpar, from->streams[0]->codecpar) < 0) return false;
    track->codecpar->codec_tag = 0;
    track->time_base = from->streams[0]->time_base;
    if (!stated_duration.empty()) av_dict_set(&track->metadata, "DURATION", stated_duration.c_str(), 0);
    if (avio_open(&to->pb, path.c_str(), AVIO_FLAG_WRITE) < 0) return false;
    if (avformat_write_header(to, nullptr) < 0) return false;
    const libav::Packet packet(av_packet_alloc());
    while (av_read_frame(from, packet.get()) >= 0) {
      av_packet_rescale_ts(packet.get(), from->streams[0]->time_base, track->time_base);
      if (av_interleaved_write_frame(to, packet.get()) < 0) return false;
    }
    return av_write_trailer(to) >= 0;
  }();
  avformat_close_input(&from);
  if (to != nullptr) avio_closep(&to->pb);
  avformat_free_context(to);
  return whole ? Result<void>() : failed;
}

// The H.264 of a video as a raw stream, which has no times.
inline Result<void> write_raw_h264(const std::string& video, const std::string& path) {
  return remux(video, path, "h264");
}

struct Exif {
  std::uint32_t time_numerator = 1, time_denominator = 250;
  std::uint16_t iso = 100;  // 0: not stated
  std::uint32_t f_number_tenths = 28;
  // DateTimeOriginal and what goes with it; "": none.
  std::string date_time = {}, sub_second = {}, offset = {};
  std::string model = {};            // of the camera; "": none
  std::uint16_t orientation = 1;     // as EXIF numbers them
  std::uint32_t exposure_index = 0;  // the sensitivity beyond 16 bits; 0: not stated
  std::uint16_t focal_35mm_mm = 0;   // equivalent for 35 mm film; 0: not stated
  // In tenths of APEX, instead of time and f-number; both or none.
  std::optional<std::int32_t> time_apex = {}, aperture_apex = {};
};

// The APP1 segment of a JPEG file: a TIFF structure, little endian, with an EXIF directory.
inline std::vector<std::uint8_t> exif_segment(const Exif& exif) {
  constexpr std::uint32_t kFirst = 8;  // place of the first directory
  const auto first = [&](std::uint32_t second) {
    TiffDirectory file;
    if (!exif.model.empty()) file.text(tiff_tag::kModel, exif.model);
    file.shorts(tiff_tag::kOrientation, {exif.orientation});
    file.longs(tiff_tag::kExifDirectory, {second});
    return file.at(kFirst);
  };
  const auto second = static_cast<std::uint32_t>(kFirst + first(0).size());
  TiffDirectory tags;
  if (!exif.time_apex) {
    tags.rationals(tiff_tag::kExposureTime, {exif.time_numerator, exif.time_denominator});
    tags.rationals(tiff_tag::kFNumber, {exif.f_number_tenths, 10});
  }
  if (exif.iso > 0) tags.shorts(tiff_tag::kIsoSpeed, {exif.iso});
  if (exif.exposure_index > 0) tags.longs(tiff_tag::kRecommendedExposureIndex, {exif.exposure_index});
  const auto text = [&](std::uint16_t tag, const std::string& value) {
    if (!value.empty()) tags.text(tag, value);
  };
  text(tiff_tag::kDateTimeOriginal, exif.date_time);
  text(tiff_tag::kOffsetTimeOriginal, exif.offset);
  if (exif.time_apex && exif.aperture_apex) {
    tags.signed_rationals(tiff_tag::kShutterSpeedValue, {static_cast<std::uint32_t>(*exif.time_apex), 10});
    tags.rationals(tiff_tag::kApertureValue, {static_cast<std::uint32_t>(*exif.aperture_apex), 10});
  }
  text(tiff_tag::kSubSecTimeOriginal, exif.sub_second);
  if (exif.focal_35mm_mm > 0) tags.shorts(tiff_tag::kFocalLengthIn35mmFilm, {exif.focal_35mm_mm});
  std::vector<std::uint8_t> bytes{'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0, kFirst, 0, 0, 0};
  for (const auto& directory : {first(second), tags.at(second)})
    bytes.insert(bytes.end(), directory.begin(), directory.end());
  return bytes;
}
// rgb: as above. Without chroma subsampling, of quality 100.
inline void write_jpeg(const std::string& path, const Image<std::uint16_t>& rgb,
                       const std::optional<Exif>& exif) {
  jpeg_compress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(rgb.cols()),
  jpeg.image_height = static_cast<JDIMENSION>(rgb.rows());
  jpeg.input_components = 3, jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&jpeg, TRUE);
  if (exif) {
    const std::vector<std::uint8_t> segment = exif_segment(*exif);
    jpeg_write_marker(&jpeg, JPEG_APP0 + 1, segment.data(), static_cast<unsigned>(segment.size()));
  }
  std::vector<std::uint8_t> row(static_cast<std::size_t>(rgb.cols()) * 3);
  for (int y = 0; y < rgb.rows(); ++y) {
    for (int x = 0; x < rgb.cols(); ++x)
      for (int c = 0; c < 3; ++c)
        row[static_cast<std::size_t>(3 * x + c)] = static_cast<std::uint8_t>(rgb.at(c, y, x));
    std::uint8_t* rows[] = {row.data()};
    jpeg_write_scanlines(&jpeg, rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
}

}  // namespace hdrcam::test
