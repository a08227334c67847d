#include "core/video/video_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/ffmpeg/ffmpeg_calls.h"
#include "core/image/files/picture_projection.h"
#include "core/video/container_end.h"
#include "core/video/video_light.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNameAnother = "; name a video, a folder of photographs or a light field";

// No file may make this process read others: a playlist may name addresses.
FfmpegOwned<AVFormatContext> Open(const fs::path& file) {
  RouteFfmpegLog();
  AVDictionary* options = nullptr;
  Ffmpeg().av_dict_set(&options, "protocol_whitelist", "file", 0);
  AVFormatContext* opened = nullptr;
  const int status =
      Ffmpeg().avformat_open_input(&opened, ("file:" + file.string()).c_str(), nullptr, &options);
  Ffmpeg().av_dict_free(&options);
  if (status < 0) {
    const std::string missing = MissingEnd(file);
    throw Error("{}: is no video that can be opened: {}", file.string(),
                missing.empty() ? FfmpegErrorText(status) + kNameAnother
                                : missing + "; copy it again from its source");
  }
  return FfmpegOwned<AVFormatContext>(opened);
}

// To FFmpeg one photograph is a stream of one picture.
bool IsPictureFormat(const AVFormatContext& input) {
  const std::string name = input.iformat->name;
  return name.starts_with("image2") || name.ends_with("_pipe");
}

// Detects text that FFmpeg draws as a terminal would have shown it.
bool IsDrawnText(const AVFormatContext& input) {
  constexpr std::array<std::string_view, 5> kTexts{"tty", "bin", "xbin", "adf", "idf"};
  return std::ranges::find(kTexts, std::string_view(input.iformat->name)) != kTexts.end();
}

// Cover pictures do not count.
int VideosIn(const AVFormatContext& input) {
  int videos = 0;
  for (unsigned i = 0; i < input.nb_streams; ++i)
    videos += input.streams[i]->codecpar->codec_type == AVMEDIA_TYPE_VIDEO &&
              (input.streams[i]->disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;
  return videos;
}

int StreamOf(AVFormatContext& input) {
  const int stream = Ffmpeg().av_find_best_stream(&input, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  const bool is_cover =
      stream >= 0 && (input.streams[stream]->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0;
  return is_cover ? -1 : stream;
}

// Describes how stored pictures become upright: by quarter turns, and mirrored first if a camera showed its
// user.
struct DisplayTurn {
  bool transposes = false, flips_x = false, flips_y = false;  // applied in this order
  bool any() const { return transposes || flips_x || flips_y; }
  int Degrees() const {  // clockwise, mirrored or not
    if (!transposes) return flips_y ? 180 : 0;
    return flips_x ? 90 : 270;
  }
  bool IsMirrored() const { return (transposes != flips_x) != flips_y; }
};

// A display matrix takes stored places (x right, y down) to shown ones: x' = a x + c y, y' = b x + d y.
std::optional<DisplayTurn> TurnOf(const std::int32_t* matrix) {
  const std::array<double, 4> m{static_cast<double>(matrix[0]), static_cast<double>(matrix[1]),
                                static_cast<double>(matrix[3]), static_cast<double>(matrix[4])};
  const double largest = std::abs(*std::ranges::max_element(m, {}, [](double v) { return std::abs(v); }));
  if (!(largest > 0)) return std::nullopt;
  std::array<int, 4> sign{};
  for (std::size_t i = 0; i < m.size(); ++i) {
    const double share = m[i] / largest;
    constexpr double kNear = 0.02;  // of a quarter turn. Guessed.
    if (std::abs(share) > kNear && std::abs(share) < 1 - kNear) return std::nullopt;
    sign[i] = std::abs(share) > kNear ? (share > 0 ? 1 : -1) : 0;
  }
  const auto [a, b, c, d] = sign;
  if (a != 0 && d != 0 && b == 0 && c == 0) return DisplayTurn{false, a < 0, d < 0};
  if (a == 0 && d == 0 && b != 0 && c != 0) return DisplayTurn{true, c < 0, b < 0};
  return std::nullopt;
}

cv::Mat Turned(const cv::Mat& stored, const DisplayTurn& turn) {
  if (!turn.any()) return stored;
  cv::Mat upright = stored;
  if (turn.transposes) cv::transpose(stored, upright);
  if (!turn.flips_x && !turn.flips_y) return upright;
  cv::Mat flipped;
  cv::flip(upright, flipped, turn.flips_x && turn.flips_y ? -1 : turn.flips_x ? 1 : 0);
  return flipped;
}

// Lines of a frame: all of them, or one of the two fields of an interlaced one, exposed at one time.
struct Field {
  std::array<const std::uint8_t*, 4> data{};
  std::array<int, 4> line_bytes{};
  int height = 0;
};

// Takes every `step`-th line from `first` on.
Field FieldOf(const AVFrame& frame, int first, int step) {
  Field field;
  field.height = (frame.height + step - 1 - first) / step;
  for (std::size_t plane = 0; plane < field.data.size(); ++plane) {
    if (!frame.data[plane]) continue;
    field.data[plane] = frame.data[plane] + first * frame.linesize[plane];
    field.line_bytes[plane] = step * frame.linesize[plane];
  }
  return field;
}

// Interpolates the lines between those of a field from the lines above and below.
cv::Mat WithLinesBetween(const cv::Mat& field, bool is_bottom, int height) {
  const cv::Matx23d full_from_field(1, 0, 0, 0, 2, is_bottom ? 1 : 0);
  cv::Mat full;
  cv::warpAffine(field, full, full_from_field, {field.cols, height}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return full;
}

double Ratio(const AVRational& ratio) { return ratio.num > 0 && ratio.den > 0 ? av_q2d(ratio) : 0; }

}  // namespace

struct VideoReader::State {
  explicit State(const fs::path& file)
      : name(file.string()),
        input(Open(file)),
        missing_end(MissingEnd(file)),
        packet(Ffmpeg().av_packet_alloc()),
        frame(Ffmpeg().av_frame_alloc()) {
    if (IsPictureFormat(*input))
      throw Error(
          "{}: is one picture and no video; name the folder that holds it (?glob= chooses among its files)",
          name);
    if (IsDrawnText(*input)) throw Error("{}: is no video{}", name, kNameAnother);
    if (const int status = Ffmpeg().avformat_find_stream_info(input.get(), nullptr); status < 0)
      throw Error("{}: is no video that can be read: {}", name, FfmpegErrorText(status));
    index = StreamOf(*input);
    if (index < 0) throw Error("{}: holds sound or data and no video{}", name, kNameAnother);
    RefuseDolbyVision();
    OpenCodec();
    for (unsigned i = 0; i < input->nb_streams; ++i)
      if (static_cast<int>(i) != index) input->streams[i]->discard = AVDISCARD_ALL;
    if (!Decode())
      throw Error(
          "{}: no picture could be decoded from the video{}; play it once in a viewer, or export it again",
          name, problem.empty() ? "" : " (" + problem + ")");
    RequireOneLens();
    TellFacts();
    has_first = true;
  }
  const AVStream& Stream() const { return *input->streams[index]; }

  // Its profile 5 stores pictures in its own colours, and only this tag says so.
  void RefuseDolbyVision() const {
    const std::uint8_t* data = Ffmpeg().av_stream_get_side_data(&Stream(), AV_PKT_DATA_DOVI_CONF, nullptr);
    if (!data) return;
    AVDOVIDecoderConfigurationRecord told;
    std::memcpy(&told, data, sizeof(told));
    constexpr int kWithoutOtherBase = 5;
    if (told.dv_profile == kWithoutOtherBase)
      throw Error(
          "{}: its colours are those of Dolby Vision (profile {}), which are not understood here; export it "
          "again as BT.709 or HLG",
          name, told.dv_profile);
  }

  void OpenCodec() {
    const AVCodecParameters* parameters = Stream().codecpar;
    const AVCodec* decoder = Ffmpeg().avcodec_find_decoder(parameters->codec_id);
    if (!decoder)
      throw Error(
          "{}: its pictures are coded as {}, which FFmpeg's libraries here cannot decode; export it as H.264",
          name, Ffmpeg().avcodec_get_name(parameters->codec_id));
    codec.reset(Ffmpeg().avcodec_alloc_context3(decoder));
    codec->pkt_timebase = Stream().time_base;
    codec->thread_type = FF_THREAD_SLICE;
    codec->thread_count = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 16);
    int status = Ffmpeg().avcodec_parameters_to_context(codec.get(), parameters);
    if (status >= 0) status = Ffmpeg().avcodec_open2(codec.get(), decoder, nullptr);
    if (status < 0)
      throw Error("{}: the decoder of {} cannot be opened: {}", name, decoder->name, FfmpegErrorText(status));
  }

  // Decodes the next picture into `frame`; returns false at the end.
  bool Decode() {
    while (true) {
      const int status = Ffmpeg().avcodec_receive_frame(codec.get(), frame.get());
      if (status == 0) {
        if (frame->decode_error_flags == 0 && (frame->flags & AV_FRAME_FLAG_CORRUPT) == 0) return true;
        ++damaged;
        continue;
      }
      if (status == AVERROR_EOF) return false;
      if (status != AVERROR(EAGAIN)) {
        ++damaged;
        if (drains) return false;
      }
      if (!Feed()) return false;
    }
  }

  // Gives the decoder another packet, or the end of stream. Returns false if it has had that.
  bool Feed() {
    if (drains) return false;
    while (true) {
      const int status = Ffmpeg().av_read_frame(input.get(), packet.get());
      if (status < 0) {
        if (status != AVERROR_EOF) problem = FfmpegErrorText(status);
        drains = true;
        Ffmpeg().avcodec_send_packet(codec.get(), nullptr);
        return true;
      }
      const bool is_ours = packet->stream_index == index;
      int sent = 0;
      if (is_ours) {
        if ((packet->flags & AV_PKT_FLAG_CORRUPT) != 0) problem = "a part of it is missing";
        sent = Ffmpeg().avcodec_send_packet(codec.get(), packet.get());
      }
      Ffmpeg().av_packet_unref(packet.get());
      if (!is_ours) continue;
      if (sent < 0 && sent != AVERROR(EAGAIN)) ++damaged;
      return true;
    }
  }

  // Returns data of the stream, or of its pictures; null if there are none of this kind.
  template <typename Facts>
  const Facts* SideData(AVPacketSideDataType of_stream, AVFrameSideDataType of_picture) const {
    if (const AVFrameSideData* data = Ffmpeg().av_frame_get_side_data(frame.get(), of_picture))
      return reinterpret_cast<const Facts*>(data->data);
    return reinterpret_cast<const Facts*>(Ffmpeg().av_stream_get_side_data(&Stream(), of_stream, nullptr));
  }

  void RequireOneLens() const {
    if (const auto* sphere = SideData<AVSphericalMapping>(AV_PKT_DATA_SPHERICAL, AV_FRAME_DATA_SPHERICAL))
      throw Error("{}: is a panorama (it says that its pictures are spherical), which no lens made; {}", name,
                  PanoramaRemedy(sphere->projection == AV_SPHERICAL_EQUIRECTANGULAR, "OUT%05d.png"));
    if (const auto* stereo = SideData<AVStereo3D>(AV_PKT_DATA_STEREO3D, AV_FRAME_DATA_STEREO3D);
        stereo && stereo->type != AV_STEREO3D_2D)
      throw Error("{}: shows stereo pairs{}, which no single lens made; {}", name,
                  stereo->type == AV_STEREO3D_SIDEBYSIDE  ? ", side by side"
                  : stereo->type == AV_STEREO3D_TOPBOTTOM ? ", one above the other"
                                                          : "",
                  StereoPairRemedy(stereo->type == AV_STEREO3D_SIDEBYSIDE  ? StereoLayout::kSideBySide
                                   : stereo->type == AV_STEREO3D_TOPBOTTOM ? StereoLayout::kOverUnder
                                                                           : StereoLayout::kOther));
  }

  void TellFacts() {
    stored = {frame->width, frame->height};
    try {
      light.emplace(*frame);
    } catch (const Error& error) {
      throw Error("{}: {}", name, error.what());
    }
    facts.frame_rate = Ratio(Ffmpeg().av_guess_frame_rate(input.get(), input->streams[index], nullptr));
    facts.frames = Stream().nb_frames > 0 ? static_cast<double>(Stream().nb_frames) : LengthByDuration();
    facts.pixel_aspect =
        Ratio(Ffmpeg().av_guess_sample_aspect_ratio(input.get(), input->streams[index], frame.get()));
    if (facts.pixel_aspect == 0) facts.pixel_aspect = 1;
    TellTurn();
    facts.width = turn.transposes ? stored.height : stored.width;
    facts.height = turn.transposes ? stored.width : stored.height;
    if (turn.transposes) facts.pixel_aspect = 1 / facts.pixel_aspect;
    facts.notes.insert(facts.notes.end(), light->notes().begin(), light->notes().end());
    facts.warnings.insert(facts.warnings.end(), light->warnings().begin(), light->warnings().end());
    if (facts.pixel_aspect != 1)
      facts.notes.push_back(fmt::format(
          "its pixels are {:.4g} times as wide as high: the focal lengths of x and y differ by that",
          facts.pixel_aspect));
    if (const int videos = VideosIn(*input); videos > 1)
      facts.warnings.push_back(fmt::format("it holds {} videos; this is the one of {}x{} that players show",
                                           videos, stored.width, stored.height));
    const AVFieldOrder order = Stream().codecpar->field_order;
    is_interlaced =
        frame->interlaced_frame != 0 || (order != AV_FIELD_UNKNOWN && order != AV_FIELD_PROGRESSIVE);
    is_bottom_first = frame->interlaced_frame != 0 ? frame->top_field_first == 0
                                                   : order == AV_FIELD_BB || order == AV_FIELD_TB;
    if (is_interlaced)
      facts.warnings.push_back(
          "it is interlaced: every second line was taken later; the earlier lines are used, and those "
          "between are interpolated (half the detail from top to bottom)");
  }

  double LengthByDuration() const {
    const double duration_s = Stream().duration > 0
                                  ? static_cast<double>(Stream().duration) * av_q2d(Stream().time_base)
                              : input->duration > 0 ? static_cast<double>(input->duration) / AV_TIME_BASE
                                                    : 0;
    return std::round(duration_s * facts.frame_rate);
  }

  void TellTurn() {
    const auto* data = SideData<std::uint8_t>(AV_PKT_DATA_DISPLAYMATRIX, AV_FRAME_DATA_DISPLAYMATRIX);
    if (!data) return;
    std::array<std::int32_t, 9> matrix{};
    std::memcpy(matrix.data(), data, sizeof(matrix));
    const std::optional<DisplayTurn> told = TurnOf(matrix.data());
    if (!told) {
      facts.warnings.push_back(
          "the file asks for a turn that is no quarter turn: the pictures are shown as they are stored");
      return;
    }
    turn = *told;
    if (!turn.any()) return;
    facts.notes.push_back(fmt::format(
        "its pictures are stored {}x{} and {}{} as the file asks; a calibration must be of upright pictures, "
        "too",
        stored.width, stored.height,
        turn.Degrees() == 0 ? std::string() : fmt::format("turned by {} degrees clockwise", turn.Degrees()),
        !turn.IsMirrored()    ? ""
        : turn.Degrees() == 0 ? "mirrored"
                              : " and mirrored"));
  }

  // Converts `frame` to upright pixels.
  Image Picture() {
    cv::Mat pixels = Converted(is_interlaced ? FieldOf(*frame, is_bottom_first, 2) : FieldOf(*frame, 0, 1));
    if (is_interlaced) pixels = WithLinesBetween(pixels, is_bottom_first, frame->height);
    return {Turned(light->ToSrgbOrLinear(pixels), turn), light->transfer()};
  }

  cv::Mat Converted(const Field& field) {
    const auto format = static_cast<AVPixelFormat>(frame->format);
    const AVPixelFormat wanted = light->is_deep() ? AV_PIX_FMT_BGR48 : AV_PIX_FMT_BGR24;
    if (!scaler) {
      scaler.reset(Ffmpeg().sws_getContext(
          frame->width, field.height, WithoutRange(format), frame->width, field.height, wanted,
          light->is_deep() ? SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT : SWS_BICUBIC, nullptr,
          nullptr, nullptr));
      if (!scaler)
        throw Error("{}: its pixels are stored as {}, which cannot be converted", name,
                    Ffmpeg().av_get_pix_fmt_name(format) ? Ffmpeg().av_get_pix_fmt_name(format)
                                                         : "an unknown format");
      light->Set(*scaler);
    }
    cv::Mat pixels(field.height, frame->width, light->is_deep() ? CV_16UC3 : CV_8UC3);
    std::array<std::uint8_t*, 4> data{pixels.data};
    std::array<int, 4> line_bytes{static_cast<int>(pixels.step)};
    const int lines = Ffmpeg().sws_scale(scaler.get(), field.data.data(), field.line_bytes.data(), 0,
                                         field.height, data.data(), line_bytes.data());
    if (lines != field.height)
      throw Error("{}: a picture cannot be converted: {}", name, FfmpegErrorText(lines));
    return pixels;
  }

  double TimeOfFrame() {
    const std::int64_t stamp = frame->best_effort_timestamp;
    const double time_s =
        stamp == AV_NOPTS_VALUE ? NAN : static_cast<double>(stamp) * av_q2d(Stream().time_base);
    if (!first_time_s && !std::isnan(time_s)) first_time_s = time_s;
    const double since_first_s = first_time_s ? time_s - *first_time_s : NAN;
    constexpr double kUsualRate = 30;
    if (delivered == 0)
      last_time_s = 0;
    else if (since_first_s > last_time_s)
      last_time_s = since_first_s;
    else  // no time, or one that does not increase
      last_time_s += 1 / (facts.frame_rate > 0 ? facts.frame_rate : kUsualRate);
    return last_time_s;
  }

  // A stream may change its matrix or range on the way, as joined films do. Returns false if its pictures
  // would be of another kind than the first ones.
  bool FollowLight() {
    if (light->IsOf(*frame)) return true;
    try {
      const VideoLight other(*frame);
      if (other.transfer() != light->transfer()) return false;
      light = other;
    } catch (const Error&) {
      return false;
    }
    scaler.reset();
    return true;
  }

  std::optional<VideoPicture> Next() {
    while (true) {
      if (!has_first && !Decode()) return std::nullopt;
      has_first = false;
      const bool has_other_size = frame->width != stored.width || frame->height != stored.height;
      if (has_other_size || !FollowLight()) {
        if (others++ == 0)
          first_other =
              has_other_size
                  ? fmt::format("from picture {} on some are {}x{}, where the others are {}x{}",
                                delivered + 1, frame->width, frame->height, stored.width, stored.height)
                  : fmt::format("from picture {} on the light of some is coded otherwise", delivered + 1);
        continue;
      }
      VideoPicture picture{Picture(), TimeOfFrame()};
      ++delivered;
      return picture;
    }
  }

  std::string Problem() const {
    std::string words;
    const auto add = [&](const std::string& more) { words += (words.empty() ? "" : "; ") + more; };
    if (!missing_end.empty())
      add(fmt::format("the video is truncated after {}: {}", Counted(delivered, "picture"), missing_end));
    else if (!problem.empty())
      add(fmt::format("the video is truncated or damaged after {}: {}", Counted(delivered, "picture"),
                      problem));
    if (damaged > 0)
      add(fmt::format("{} could not be decoded whole and left out", Counted(damaged, "picture")));
    if (others > 0) add(fmt::format("{}: {} left out", first_other, Counted(others, "picture")));
    return words;
  }

  std::string name;
  FfmpegOwned<AVFormatContext> input;
  FfmpegOwned<AVCodecContext> codec;
  FfmpegOwned<SwsContext> scaler;
  std::string missing_end;
  FfmpegOwned<AVPacket> packet;
  FfmpegOwned<AVFrame> frame;
  int index = -1;
  cv::Size stored;
  DisplayTurn turn;
  std::optional<VideoLight> light;
  VideoFacts facts;
  bool is_interlaced = false, is_bottom_first = false;
  bool has_first = false;  // in `frame`
  bool drains = false;     // the decoder has had all packets
  std::size_t delivered = 0, damaged = 0, others = 0;
  std::string problem, first_other;
  std::optional<double> first_time_s;
  double last_time_s = 0;
};

VideoReader::VideoReader(const fs::path& file) : state_(std::make_unique<State>(file)) {}
VideoReader::~VideoReader() = default;
const VideoFacts& VideoReader::Facts() const { return state_->facts; }
std::optional<VideoPicture> VideoReader::Next() { return state_->Next(); }
std::string VideoReader::Problem() const { return state_->Problem(); }

}  // namespace ulf
