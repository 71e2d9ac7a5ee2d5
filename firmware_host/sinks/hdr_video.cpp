#include "firmware_host/sinks/hdr_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/video_target.h"
#include "hal/video/picture_converter.h"
#include "render/display_light.h"
#include "render/srgb.h"
#include "render/tone_curve.h"

namespace hdrcam {
namespace {

constexpr double kHlgPeak_nits = 1000;  // the display for which zimg's system gamma of 1.2 is made

ColorTags tags_of(VideoTransfer transfer) {
  if (transfer == VideoTransfer::Sdr)
    return {h273::kPrimariesBt709, h273::kTransferBt709, h273::kMatrixBt709};
  return {h273::kPrimariesBt2020, transfer == VideoTransfer::Pq ? h273::kTransferPq : h273::kTransferHlg,
          h273::kMatrixBt2020Ncl};
}

// Where the samples of halved chroma are: of BT.2020 and BT.2100 at the first luma sample of each four, of
// BT.709 by custom between it and the one below.
ChromaSite chroma_site_of(VideoTransfer transfer) {
  return transfer == VideoTransfer::Sdr ? ChromaSite::Left : ChromaSite::TopLeft;
}

// What --codec takes besides auto.
struct NamedCodec {
  CodecChoice choice;
  VideoCodec codec;
  const char* word;
};
constexpr NamedCodec kCodecs[] = {{CodecChoice::Hevc, VideoCodec::Hevc, "hevc"},
                                  {CodecChoice::Av1, VideoCodec::Av1, "av1"},
                                  {CodecChoice::H264, VideoCodec::H264, "h264"}};

const NamedCodec& codec_of(const VideoOptions& options) {
  CodecChoice choice = options.codec;
  if (choice == CodecChoice::Suitable)
    choice = options.transfer == VideoTransfer::Sdr ? CodecChoice::H264 : CodecChoice::Hevc;
  return *std::ranges::find(kCodecs, choice, &NamedCodec::choice);
}

// What the frames hold.
enum class FrameLight { Radiance, Display };

// The frames as the planes of a video, whatever becomes of them.
class HdrVideo : public FrameSink {
 public:
  HdrVideo(VideoTarget target, VideoFormat format, const VideoOptions& options,
           FrameLight holds = FrameLight::Radiance)
      : target_(std::move(target)), format_(format), options_(options), holds_(holds) {
    format_.tags = tags_of(options.transfer);
    format_.chroma_site = chroma_site_of(options.transfer);
    format_.crf = options.crf;
    if (options.transfer == VideoTransfer::Pq) format_.mastering.emplace().peak_nits = options.peak_nits;
  }

  Result<void> emit(const EmittedFrame& emitted) override {
    const HdrFrame& frame = emitted.hdr;
    if (!writer_) TRY(open(frame));
    if (frame.radiance.rows() != format_.height_px || frame.radiance.cols() != format_.width_px)
      return Error{ErrorCode::SizeChanged,
                   fmt::format("frame {} has {}x{} pixels, and the video {}x{}; give frames of one size",
                               frame.facts.sequence, frame.radiance.cols(), frame.radiance.rows(),
                               format_.width_px, format_.height_px)};
    show(frame.radiance);
    repeat_edges();
    TRY(converter_->convert(planes_of(light_), writer_->planes()));
    return writer_->append(frame.facts.timestamp - start_);
  }

  Result<void> finish() override {
    if (!writer_) return {};
    const auto nits = [](double value) { return std::clamp(static_cast<int>(std::ceil(value)), 1, 10000); };
    TRY(writer_->finish(LightLevel{nits(largest_.largest_nits), nits(largest_.mean_nits)}));
    return target_.sync_name();
  }

 private:
  // The first frame says how large the video is, and how bright it may become.
  Result<void> open(const HdrFrame& first) {
    start_ = first.facts.timestamp;
    format_.width_px = first.radiance.cols(), format_.height_px = first.radiance.rows();
    if (options_.transfer != VideoTransfer::Sdr)
      display_.emplace(options_.white_nits, options_.peak_nits, static_cast<double>(first.white));
    PictureFormat light = format_.picture();
    light.bits = 0, light.colors = PictureColors::Rgb, light.range = CodeRange::Full;
    light.chroma_shift_x = light.chroma_shift_y = 0;
    light.tags = display_ ? ColorTags{h273::kPrimariesBt2020, h273::kTransferLinear, h273::kMatrixRgb}
                          : ColorTags{h273::kPrimariesBt709, h273::kTransferSrgb, h273::kMatrixRgb};
    converter_ = TRY(PictureConverter::create(light, format_.picture()));
    light_ = Image<float>(3, format_.coded_height_px(),
                          PictureConverter::aligned_cols<float>(format_.coded_width_px()));
    writer_ = TRY(target_.open(format_));
    return {};
  }

  void show(const Image<float>& radiance) {
    if (display_) {
      const PictureLight light = display_->show(radiance, light_);
      largest_.largest_nits = std::max(largest_.largest_nits, light.largest_nits);
      largest_.mean_nits = std::max(largest_.mean_nits, light.mean_nits);
      return;
    }
    if (holds_ == FrameLight::Display) return show_by(srgb_level, radiance);
    const ToneCurve& curve = tone_.follow(radiance);
    show_by([&curve](float value) { return curve.level(value) / 255; }, radiance);
  }

  template <class Level>
  void show_by(const Level& level, const Image<float>& radiance) {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < radiance.rows(); ++y)
        std::transform(radiance.row(c, y), radiance.row(c, y) + radiance.cols(), light_.row(c, y), level);
  }

  // A video has even sides.
  void repeat_edges() {
    const int rows = format_.height_px, cols = format_.width_px;
    for (int c = 0; c < 3; ++c) {
      if (cols % 2 == 1)
        for (int y = 0; y < rows; ++y) light_.at(c, y, cols) = light_.at(c, y, cols - 1);
      if (rows % 2 == 1) std::copy_n(light_.row(c, rows - 1), light_.cols(), light_.row(c, rows));
    }
  }

  VideoTarget target_;
  VideoFormat format_;
  const VideoOptions options_;
  const FrameLight holds_;
  std::unique_ptr<VideoWriter> writer_;
  std::optional<PictureConverter> converter_;
  std::optional<DisplayLight> display_;  // of HDR
  ToneAdaptation tone_;                  // of SDR
  Image<float> light_;                   // [rgb, coded rows, cols and more]: cd/m2; of SDR sRGB levels 0..1
  PictureLight largest_;
  Instant start_;
};

Result<std::unique_ptr<FrameSink>> create_video(Storage& storage, const std::string& path,
                                                double framerate_hz, const VideoOptions& options,
                                                FrameLight holds) {
  TRY(check_video(options));
  TRY(check_rate_factor(options));
  const auto container = video_container_of(path);
  if (!container)
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is not the name of a video; name it film.mp4 (.mov, .mkv)", path)};
  if (*container == VideoContainer::Mov && options.codec == CodecChoice::Av1)
    return Error{ErrorCode::Invalid,
                 fmt::format("--codec av1 does not fit '{}', as .mov holds hevc and h264; name the video "
                             "out.mp4 or out.mkv, or give another codec",
                             path)};
  TRY(make_folder_of(storage, path));
  VideoTarget target = TRY(VideoTarget::at(storage, path));
  VideoFormat format{.framerate_hz = framerate_hz, .codec = codec_of(options).codec, .container = *container};
  format.bits = format.codec == VideoCodec::H264 ? 8 : 10;
  return std::unique_ptr<FrameSink>(std::make_unique<HdrVideo>(std::move(target), format, options, holds));
}

}  // namespace

Result<void> check_video(const VideoOptions& options) {
  if (options.transfer != VideoTransfer::Sdr && options.codec == CodecChoice::H264)
    return Error{ErrorCode::Invalid,
                 "--codec h264 is for --transfer sdr; HDR players expect hevc or av1, choose one of them"};
  if (options.transfer == VideoTransfer::Hlg && options.peak_nits > kHlgPeak_nits)
    return Error{
        ErrorCode::Invalid,
        fmt::format(
            "--peak {:g} does not fit --transfer hlg, whose nominal display shows {:g} cd/m2; give that "
            "or less",
            options.peak_nits, kHlgPeak_nits)};
  if (options.transfer != VideoTransfer::Sdr && options.peak_nits < options.white_nits)
    return Error{ErrorCode::Invalid,
                 fmt::format("--peak {:g} is below --white {:g}: nothing brighter than white "
                             "could be shown; raise the one or lower the other",
                             options.peak_nits, options.white_nits)};
  return {};
}

Result<void> check_rate_factor(const VideoOptions& options) {
  const NamedCodec& named = codec_of(options);
  const int most = greatest_crf(named.codec), most_of_av1 = greatest_crf(VideoCodec::Av1);
  if (options.crf <= most) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("--crf {} is beyond what {} takes, 0 to {}; give less, or --codec av1, which "
                           "takes up to {}",
                           options.crf, named.word, most, most_of_av1)};
}

Result<void> check_video_size(const VideoOptions& options, int width_px, int height_px) {
  return check_picture_size({.width_px = width_px, .height_px = height_px, .codec = codec_of(options).codec});
}

Result<std::unique_ptr<FrameSink>> create_hdr_video(Storage& storage, const std::string& path,
                                                    double framerate_hz, const VideoOptions& options) {
  return create_video(storage, path, framerate_hz, options, FrameLight::Radiance);
}

Result<std::unique_ptr<FrameSink>> create_display_video(Storage& storage, const std::string& path,
                                                        double framerate_hz, VideoOptions options) {
  options.transfer = VideoTransfer::Sdr;
  return create_video(storage, path, framerate_hz, options, FrameLight::Display);
}

Result<std::unique_ptr<FrameSink>> create_video_pipe(std::unique_ptr<StorageFile> pipe, double framerate_hz,
                                                     const VideoOptions& options) {
  TRY(check_video(options));
  const VideoFormat format{
      .framerate_hz = framerate_hz,
      .bits = options.transfer == VideoTransfer::Sdr ? 8 : 10,
      .codec = VideoCodec::Uncompressed,
      .container = options.pipe == PipeFormat::Y4m ? VideoContainer::Y4m : VideoContainer::Nut};
  return std::unique_ptr<FrameSink>(
      std::make_unique<HdrVideo>(VideoTarget(std::move(pipe)), format, options));
}

}  // namespace hdrcam
