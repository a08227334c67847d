#include "core/video/video_light.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/ffmpeg/ffmpeg_calls.h"

namespace ulf {
namespace {

// BT.2408's reference white, a sheet of paper, in cd/m2 under PQ and as a signal under HLG.
constexpr double kPaperNits = 203, kPaperSignal = 0.75;

// Decodes SMPTE ST 2084, in cd/m2.
double NitsFromPq(double signal) {
  constexpr double m1 = 2610.0 / 16384, m2 = 2523.0 / 4096 * 128;
  constexpr double c1 = 3424.0 / 4096, c2 = 2413.0 / 4096 * 32, c3 = 2392.0 / 4096 * 32;
  const double power = std::pow(signal, 1 / m2);
  return 10000 * std::pow(std::max(0.0, power - c1) / (c2 - c3 * power), 1 / m1);
}

// Decodes ARIB STD-B67 to the scene's light, 1 at the largest signal.
double SceneFromHlg(double signal) {
  constexpr double a = 0.17883277, b = 1 - 4 * a;
  const double c = 0.5 - a * std::log(4 * a);
  return signal <= 0.5 ? signal * signal / 3 : (std::exp((signal - c) / a) + b) / 12;
}

// Convert BT.2020 (ITU-R BT.2087) and P3 with D65 (SMPTE EG 432-1) to linear R, G, B of BT.709's primaries.
const cv::Matx33f kFromBt2020(1.660491F, -0.587641F, -0.072850F, -0.124550F, 1.132900F, -0.008349F,
                              -0.018151F, -0.100579F, 1.118730F);
const cv::Matx33f kFromP3(1.224940F, -0.224940F, 0, -0.042057F, 1.042057F, 0, -0.019638F, -0.078636F,
                          1.098274F);

const char* Word(const char* name) { return name ? name : "unknown"; }

// Chooses a matrix for a stream without one, as players do.
AVColorSpace UsualMatrix(int height) {
  constexpr int kHighDefinition = 720;
  return height >= kHighDefinition ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
}

bool IsMarkedFull(AVPixelFormat format) { return WithoutRange(format) != format; }

}  // namespace

AVPixelFormat WithoutRange(AVPixelFormat format) {
  static const std::map<AVPixelFormat, AVPixelFormat> kUnmarked{{AV_PIX_FMT_YUVJ420P, AV_PIX_FMT_YUV420P},
                                                                {AV_PIX_FMT_YUVJ422P, AV_PIX_FMT_YUV422P},
                                                                {AV_PIX_FMT_YUVJ444P, AV_PIX_FMT_YUV444P},
                                                                {AV_PIX_FMT_YUVJ440P, AV_PIX_FMT_YUV440P},
                                                                {AV_PIX_FMT_YUVJ411P, AV_PIX_FMT_YUV411P}};
  const auto found = kUnmarked.find(format);
  return found == kUnmarked.end() ? format : found->second;
}

VideoLight::VideoLight(const AVFrame& frame)
    : format_(static_cast<AVPixelFormat>(frame.format)),
      matrix_(frame.colorspace),
      range_(frame.color_range),
      primaries_(frame.color_primaries),
      curve_(frame.color_trc) {
  InterpretTags(frame);
  if (is_deep_) MakeCurve();
}

bool VideoLight::IsOf(const AVFrame& frame) const {
  return frame.format == format_ && frame.colorspace == matrix_ && frame.color_range == range_ &&
         frame.color_primaries == primaries_ && frame.color_trc == curve_;
}

void VideoLight::InterpretTags(const AVFrame& frame) {
  const AVPixFmtDescriptor* layout = Ffmpeg().av_pix_fmt_desc_get(format_);
  is_rgb_ = layout && (layout->flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) != 0;
  const bool is_gray = layout && layout->nb_components <= 2 && !is_rgb_;
  // swscale always takes 8-bit grey values for full range.
  is_full_ = is_rgb_ || is_gray || IsMarkedFull(format_) || range_ == AVCOL_RANGE_JPEG;
  if (is_gray && range_ == AVCOL_RANGE_MPEG) gray_bits_ = layout->comp[0].depth;
  if (is_gray && range_ == AVCOL_RANGE_UNSPECIFIED)
    notes_.emplace_back("it does not say the range of its grey values: taken as full, from black to white");
  switch (curve_) {
    case AVCOL_TRC_SMPTE2084:
      is_linear_ = is_deep_ = true;
      notes_.push_back(
          fmt::format("it has a high dynamic range (PQ) and is converted to linear light, in which paper "
                      "({:g} cd/m2) is 1",
                      kPaperNits));
      break;
    case AVCOL_TRC_ARIB_STD_B67:
      is_linear_ = is_deep_ = true;
      notes_.push_back(
          fmt::format("it has a high dynamic range (HLG) and is converted to linear light, in which paper "
                      "({:g} % of the signal) is 1",
                      100 * kPaperSignal));
      break;
    case AVCOL_TRC_LINEAR:
      is_linear_ = is_deep_ = true;
      break;
    case AVCOL_TRC_LOG:
    case AVCOL_TRC_LOG_SQRT:
    case AVCOL_TRC_SMPTE428:
    case AVCOL_TRC_SMPTE240M:
      warnings_.push_back(
          fmt::format("its transfer curve ({}) is not understood and taken for that of BT.709",
                      Word(Ffmpeg().av_color_transfer_name(curve_))));
      break;
    default:
      break;  // curves for displays, which players show unchanged
  }
  switch (primaries_) {
    case AVCOL_PRI_BT2020:
      srgb_from_primaries_ = kFromBt2020;
      is_deep_ = true;
      notes_.emplace_back("its colours have the primaries of BT.2020 and are converted to sRGB's");
      break;
    case AVCOL_PRI_SMPTE432:
      srgb_from_primaries_ = kFromP3;
      is_deep_ = true;
      notes_.emplace_back("its colours have the primaries of P3 and are converted to sRGB's");
      break;
    case AVCOL_PRI_FILM:
    case AVCOL_PRI_SMPTE428:
    case AVCOL_PRI_SMPTE431:
    case AVCOL_PRI_EBU3213:
    case AVCOL_PRI_BT470M:
      warnings_.push_back(fmt::format("its primaries ({}) are not understood and taken for those of BT.709",
                                      Word(Ffmpeg().av_color_primaries_name(primaries_))));
      break;
    default:
      break;  // BT.601's differ from BT.709's by less than cameras do
  }
  if (layout && (layout->flags & AV_PIX_FMT_FLAG_ALPHA) != 0 && (layout->flags & AV_PIX_FMT_FLAG_PAL) == 0)
    notes_.emplace_back("what it says of opacity (alpha) is left out");
  // swscale converts red, green and blue of more than 8 bits through it and back.
  used_matrix_ = is_rgb_ || is_gray ? static_cast<AVColorSpace>(SWS_CS_DEFAULT) : matrix_;
  if (is_rgb_ || is_gray) return;
  const AVColorSpace usual = UsualMatrix(frame.height);
  const char* const usual_name = usual == AVCOL_SPC_BT709 ? "BT.709" : "BT.601";
  switch (matrix_) {
    case AVCOL_SPC_BT709:
    case AVCOL_SPC_FCC:
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
    case AVCOL_SPC_SMPTE240M:
    case AVCOL_SPC_BT2020_NCL:
      return;
    case AVCOL_SPC_UNSPECIFIED:
    case AVCOL_SPC_RESERVED:
      used_matrix_ = usual;
      notes_.push_back(
          fmt::format("it does not say how its colours are coded: taken as {}, as players do for {} lines",
                      usual_name, frame.height));
      return;
    case AVCOL_SPC_BT2020_CL:
      used_matrix_ = AVCOL_SPC_BT2020_NCL;
      warnings_.emplace_back(
          "its colours are coded with BT.2020's constant luminance, which is taken for the usual one: "
          "saturated colours are off");
      return;
    case AVCOL_SPC_YCGCO:
    case AVCOL_SPC_SMPTE2085:
    case AVCOL_SPC_CHROMA_DERIVED_NCL:
    case AVCOL_SPC_CHROMA_DERIVED_CL:
    case AVCOL_SPC_ICTCP:
      throw Error(
          "its colours are coded as {}, which is not understood here; export it again as BT.709 or BT.2020",
          Word(Ffmpeg().av_color_space_name(matrix_)));
    default:
      used_matrix_ = usual;
      warnings_.push_back(fmt::format("its colour matrix ({}) is not understood and taken for {}",
                                      Word(Ffmpeg().av_color_space_name(matrix_)), usual_name));
  }
}

void VideoLight::Set(SwsContext& scaler) const {
  constexpr int kAsIs = 1 << 16;
  Ffmpeg().sws_setColorspaceDetails(&scaler, Ffmpeg().sws_getCoefficients(used_matrix_), is_full_ ? 1 : 0,
                                    Ffmpeg().sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, kAsIs, kAsIs);
}

void VideoLight::MakeCurve() {
  constexpr int kValues = 1 << 16;
  linear_.resize(kValues);
  const double paper = SceneFromHlg(kPaperSignal);
  for (int value = 0; value < kValues; ++value) {
    const double signal = value / (kValues - 1.0);
    double light = signal;
    if (curve_ == AVCOL_TRC_SMPTE2084)
      light = NitsFromPq(signal) / kPaperNits;
    else if (curve_ == AVCOL_TRC_ARIB_STD_B67)
      light = SceneFromHlg(signal) / paper;
    else if (curve_ != AVCOL_TRC_LINEAR)
      light = LinearFromSrgb(static_cast<float>(signal));
    linear_[static_cast<std::size_t>(value)] = static_cast<float>(light);
  }
}

cv::Mat VideoLight::ToSrgbOrLinear(const cv::Mat& scaled) const {
  cv::Mat bgr = scaled;
  if (gray_bits_ > 0) {  // limited range: black is 16, white 235, of 8 bits
    const double codes = (std::pow(2, gray_bits_) - 1) / std::pow(2, gray_bits_ - 8),
                 most = is_deep_ ? 65535 : 255;
    scaled.convertTo(bgr, -1, codes / 219, -16 * most / 219);
  }
  if (!is_deep_) return bgr;
  cv::Mat linear(bgr.size(), CV_32FC3);
  for (int y = 0; y < bgr.rows; ++y) {
    const auto* from = bgr.ptr<cv::Vec<std::uint16_t, 3>>(y);
    auto* to = linear.ptr<cv::Vec3f>(y);
    for (int x = 0; x < bgr.cols; ++x) {
      const cv::Vec3f rgb(linear_[from[x][2]], linear_[from[x][1]], linear_[from[x][0]]);
      const cv::Vec3f in_srgb = srgb_from_primaries_ * rgb;
      for (int channel = 0; channel < 3; ++channel) to[x][2 - channel] = std::max(0.0F, in_srgb[channel]);
    }
  }
  return is_linear_ ? linear : Srgb8FromLinear(linear);
}

}  // namespace ulf
