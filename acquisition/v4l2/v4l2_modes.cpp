#include "acquisition/v4l2/v4l2_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

struct Named {
  std::uint32_t fourcc;
  std::string_view name;
};
constexpr std::array kFormats = {
    Named{V4L2_PIX_FMT_YUYV, "YUYV"},         Named{V4L2_PIX_FMT_UYVY, "UYVY"},
    Named{V4L2_PIX_FMT_NV12, "NV12"},         Named{V4L2_PIX_FMT_MJPEG, "MJPEG"},
    Named{V4L2_PIX_FMT_JPEG, "MJPEG"},        Named{V4L2_PIX_FMT_RGB24, "RGB8"},
    Named{V4L2_PIX_FMT_BGR24, "BGR8"},        Named{V4L2_PIX_FMT_GREY, "Mono8"},
    Named{V4L2_PIX_FMT_Y10, "Mono10"},        Named{V4L2_PIX_FMT_Y12, "Mono12"},
    Named{V4L2_PIX_FMT_Y14, "Mono14"},        Named{V4L2_PIX_FMT_Y16, "Mono16"},
    Named{V4L2_PIX_FMT_SRGGB8, "BayerRG8"},   Named{V4L2_PIX_FMT_SGRBG8, "BayerGR8"},
    Named{V4L2_PIX_FMT_SGBRG8, "BayerGB8"},   Named{V4L2_PIX_FMT_SBGGR8, "BayerBG8"},
    Named{V4L2_PIX_FMT_SRGGB10, "BayerRG10"}, Named{V4L2_PIX_FMT_SGRBG10, "BayerGR10"},
    Named{V4L2_PIX_FMT_SGBRG10, "BayerGB10"}, Named{V4L2_PIX_FMT_SBGGR10, "BayerBG10"},
    Named{V4L2_PIX_FMT_SRGGB12, "BayerRG12"}, Named{V4L2_PIX_FMT_SGRBG12, "BayerGR12"},
    Named{V4L2_PIX_FMT_SGBRG12, "BayerGB12"}, Named{V4L2_PIX_FMT_SBGGR12, "BayerBG12"},
    Named{V4L2_PIX_FMT_SRGGB14, "BayerRG14"}, Named{V4L2_PIX_FMT_SGRBG14, "BayerGR14"},
    Named{V4L2_PIX_FMT_SGBRG14, "BayerGB14"}, Named{V4L2_PIX_FMT_SBGGR14, "BayerBG14"},
    Named{V4L2_PIX_FMT_SRGGB16, "BayerRG16"}, Named{V4L2_PIX_FMT_SGRBG16, "BayerGR16"},
    Named{V4L2_PIX_FMT_SGBRG16, "BayerGB16"}, Named{V4L2_PIX_FMT_SBGGR16, "BayerBG16"},
};

using ModeSize = std::pair<int, int>;
constexpr std::array<ModeSize, 8> kUsualSizes{
    {{320, 240}, {640, 480}, {800, 600}, {1024, 768}, {1280, 720}, {1280, 960}, {1920, 1080}, {3840, 2160}}};

// A mode that the URI leaves open should have at most so many pixels and at least so many frames per second;
// others are chosen only where there is none. Guessed: 24 is the rate of film, at which a hand moves little
// between two frames.
constexpr int kMostPixels = 1920 * 1080;
constexpr double kFastEnough = 24;
constexpr std::uint32_t kMostEntries = 1000;  // against a driver whose lists do not end; guessed
// Relative difference up to which two frame rates are the same: 29.97 is 30.
constexpr double kSameFps = 0.01;

double FpsOf(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

std::vector<ModeSize> SizesOf(const V4l2Node& node, std::uint32_t fourcc, std::optional<ModeSize> also) {
  std::vector<ModeSize> sizes;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_frmsizeenum offered{};
    offered.index = i;
    offered.pixel_format = fourcc;
    if (node.Call(VIDIOC_ENUM_FRAMESIZES, &offered) != 0) break;
    if (offered.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      sizes.emplace_back(offered.discrete.width, offered.discrete.height);
      continue;
    }
    const v4l2_frmsize_stepwise& range = offered.stepwise;
    std::vector<ModeSize> candidates(kUsualSizes.begin(), kUsualSizes.end());
    candidates.emplace_back(range.max_width, range.max_height);
    if (also) candidates.push_back(*also);
    for (const auto& [width, height] : candidates) {
      const auto fits = [](std::uint32_t value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
        return value >= least && value <= most && (step <= 1 || (value - least) % step == 0);
      };
      if (fits(static_cast<std::uint32_t>(width), range.min_width, range.max_width, range.step_width) &&
          fits(static_cast<std::uint32_t>(height), range.min_height, range.max_height, range.step_height))
        sizes.emplace_back(width, height);
    }
    break;
  }
  if (sizes.empty()) {  // an old driver, which offers only its present size
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (node.Call(VIDIOC_G_FMT, &format) == 0)
      sizes.emplace_back(format.fmt.pix.width, format.fmt.pix.height);
  }
  return sizes;
}

void FillFps(const V4l2Node& node, V4l2Mode& mode) {
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_frmivalenum offered{};
    offered.index = i;
    offered.pixel_format = mode.fourcc;
    offered.width = static_cast<std::uint32_t>(mode.width);
    offered.height = static_cast<std::uint32_t>(mode.height);
    if (node.Call(VIDIOC_ENUM_FRAMEINTERVALS, &offered) != 0) break;
    if (offered.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      mode.fps.push_back(FpsOf(offered.discrete));
      continue;
    }
    mode.fps = {FpsOf(offered.stepwise.max), FpsOf(offered.stepwise.min)};
    mode.any_fps = true;
    break;
  }
}

std::string FpsList(const V4l2Mode& mode) {
  if (mode.any_fps) return fmt::format("{:g} to {:g}", mode.fps.front(), mode.fps.back());
  return fmt::format("{:g}", fmt::join(mode.fps, ", "));
}

// Returns the distinct descriptions of the modes that `keep` selects, joined.
template <typename Keep, typename Describe>
std::string ListOf(const std::vector<V4l2Mode>& modes, Keep keep, Describe describe) {
  std::string list;
  std::set<std::string> listed;
  for (const V4l2Mode& mode : modes)
    if (keep(mode) && listed.insert(describe(mode)).second)
      list += (list.empty() ? "" : ", ") + describe(mode);
  return list;
}

bool IsBetter(const V4l2Mode& a, const V4l2Mode& b) {
  const auto pixels = [](const V4l2Mode& mode) { return mode.width * mode.height; };
  if (pixels(a) != pixels(b)) return pixels(a) > pixels(b);
  if (a.format.name == b.format.name) return a.FastestFps() > b.FastestFps();
  return PreferredPixelFormat({std::string(a.format.name), std::string(b.format.name)})->name ==
         a.format.name;
}

std::vector<v4l2_fmtdesc> OfferedFormats(const V4l2Node& node) {
  std::vector<v4l2_fmtdesc> list;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_fmtdesc offered{};
    offered.index = i;
    offered.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (node.Call(VIDIOC_ENUM_FMT, &offered) != 0) break;
    if (!(offered.flags & V4L2_FMT_FLAG_EMULATED)) list.push_back(offered);
  }
  return list;
}

}  // namespace

std::optional<PixelFormat> PixelFormatOfFourcc(std::uint32_t fourcc) {
  for (const Named& format : kFormats)
    if (format.fourcc == fourcc) return PixelFormatByName(format.name);
  return std::nullopt;
}

std::string FourccText(std::uint32_t fourcc) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += static_cast<char>(fourcc >> (8 * i) & 0x7F);
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

std::optional<std::uint32_t> FourccByName(const std::string& name) {
  for (const Named& format : kFormats)
    if (format.name == name || FourccText(format.fourcc) == name) return format.fourcc;
  return std::nullopt;
}

double V4l2Mode::FastestFps() const { return fps.empty() ? 0 : *std::max_element(fps.begin(), fps.end()); }

bool V4l2Mode::Offers(double wanted) const {
  if (fps.empty()) return true;  // unknown until the rate is set
  if (any_fps) return wanted >= fps.front() * (1 - kSameFps) && wanted <= fps.back() * (1 + kSameFps);
  return std::any_of(fps.begin(), fps.end(),
                     [&](double offered) { return std::abs(offered - wanted) <= kSameFps * wanted; });
}

std::vector<V4l2Mode> V4l2Modes(const V4l2Node& node, std::optional<ModeSize> also) {
  std::vector<V4l2Mode> modes;
  for (const v4l2_fmtdesc& offered : OfferedFormats(node)) {
    const auto format = PixelFormatOfFourcc(offered.pixelformat);
    if (!format) continue;
    for (const auto& [width, height] : SizesOf(node, offered.pixelformat, also)) {
      V4l2Mode mode{offered.pixelformat, *format, width, height, {}};
      FillFps(node, mode);
      modes.push_back(std::move(mode));
    }
  }
  return modes;
}

std::vector<std::uint32_t> UnreadV4l2Formats(const V4l2Node& node) {
  std::vector<std::uint32_t> codes;
  for (const v4l2_fmtdesc& offered : OfferedFormats(node))
    if (!PixelFormatOfFourcc(offered.pixelformat)) codes.push_back(offered.pixelformat);
  return codes;
}

V4l2Mode ChooseV4l2Mode(const std::string& uri, const std::vector<V4l2Mode>& all,
                        const V4l2ModeRequest& request) {
  if (all.empty())
    throw Error("{}: the camera has no pixel format that ulf reads; ulf reads {}", uri,
                SupportedPixelFormats());
  const auto any = [](const V4l2Mode&) { return true; };
  const auto is_format = [&](const V4l2Mode& mode) {
    return !request.fourcc || mode.fourcc == *request.fourcc ||
           mode.format.name == PixelFormatOfFourcc(*request.fourcc)->name;
  };
  const auto is_size = [&](const V4l2Mode& mode) {
    return is_format(mode) && (!request.size || ModeSize{mode.width, mode.height} == *request.size);
  };
  const auto is_rate = [&](const V4l2Mode& mode) {
    return is_size(mode) && (!request.fps || mode.Offers(*request.fps));
  };
  if (std::none_of(all.begin(), all.end(), is_format))
    throw Refused(uri, fmt::format("the camera does not send {}", FourccText(*request.fourcc)),
                  fmt::format("it sends {}", ListOf(all, any, [](const V4l2Mode& mode) {
                                return std::string(mode.format.name);
                              })));
  if (std::none_of(all.begin(), all.end(), is_size))
    throw Refused(uri,
                  fmt::format("the camera does not send {}x{}{}", request.size->first, request.size->second,
                              request.fourcc ? " as " + FourccText(*request.fourcc) : ""),
                  fmt::format("it sends {}", ListOf(all, is_format, [](const V4l2Mode& mode) {
                                return fmt::format("{}x{}", mode.width, mode.height);
                              })));
  if (std::none_of(all.begin(), all.end(), is_rate))
    throw Refused(uri,
                  fmt::format("the camera does not send {:g} frames a second in this mode", *request.fps),
                  fmt::format("it sends {}", ListOf(all, is_size, [](const V4l2Mode& mode) {
                                return fmt::format("{} {}x{} at {}", mode.format.name, mode.width,
                                                   mode.height, FpsList(mode));
                              })));
  const auto comfortable = [&](const V4l2Mode& mode) {
    return is_rate(mode) && (request.size || mode.width * mode.height <= kMostPixels) &&
           (request.fps || mode.fps.empty() || mode.FastestFps() >= kFastEnough);
  };
  const bool any_comfortable = std::any_of(all.begin(), all.end(), comfortable);
  const V4l2Mode* best = nullptr;
  for (const V4l2Mode& mode : all)
    if (any_comfortable ? comfortable(mode) : is_rate(mode))
      if (!best || IsBetter(mode, *best)) best = &mode;
  return *best;
}

YuvEncoding YuvEncodingOf(const v4l2_pix_format& pixels) {
  std::uint32_t encoding = pixels.ycbcr_enc, quantization = pixels.quantization;
  if (encoding == V4L2_YCBCR_ENC_DEFAULT) encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(pixels.colorspace);
  if (quantization == V4L2_QUANTIZATION_DEFAULT)
    quantization = V4L2_MAP_QUANTIZATION_DEFAULT(false, pixels.colorspace, encoding);
  YuvEncoding result;
  result.full_range = quantization == V4L2_QUANTIZATION_FULL_RANGE;
  if (encoding == V4L2_YCBCR_ENC_709 || encoding == V4L2_YCBCR_ENC_XV709 ||
      encoding == V4L2_YCBCR_ENC_SMPTE240M)  // 240M: 0.212, 0.087, nearest to 709
    result.matrix = YuvMatrix::kBt709;
  if (encoding == V4L2_YCBCR_ENC_BT2020 || encoding == V4L2_YCBCR_ENC_BT2020_CONST_LUM)
    result.matrix = YuvMatrix::kBt2020;
  return result;
}

Transfer TransferOf(const v4l2_pix_format& pixels) {
  std::uint32_t transfer = pixels.xfer_func;
  if (transfer == V4L2_XFER_FUNC_DEFAULT) transfer = V4L2_MAP_XFER_FUNC_DEFAULT(pixels.colorspace);
  if (const auto format = PixelFormatOfFourcc(pixels.pixelformat);
      format && format->mosaic != Mosaic::kNone && pixels.xfer_func == V4L2_XFER_FUNC_DEFAULT)
    return Transfer::kLinear;  // the sensor's own numbers
  // The other curves are close enough to sRGB's.
  return transfer == V4L2_XFER_FUNC_NONE ? Transfer::kLinear : Transfer::kSrgb;
}

V4l2Configured SetV4l2Mode(const V4l2Node& node, const V4l2Mode& mode, std::optional<double> fps) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<std::uint32_t>(mode.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(mode.height);
  format.fmt.pix.pixelformat = mode.fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  node.CallOrThrow("picture format", VIDIOC_S_FMT, &format);
  const v4l2_pix_format& got = format.fmt.pix;
  if (got.pixelformat != mode.fourcc || static_cast<int>(got.width) != mode.width ||
      static_cast<int>(got.height) != mode.height)
    throw Error("{}: the driver changed {} {}x{} to {} {}x{}; choose another size or format", node.Path(),
                FourccText(mode.fourcc), mode.width, mode.height, FourccText(got.pixelformat), got.width,
                got.height);
  if (got.field != V4L2_FIELD_NONE && got.field != V4L2_FIELD_ANY)
    throw Error("{}: sends interlaced pictures, which cannot be used; choose a progressive size",
                node.Path());
  const double wanted = fps.value_or(mode.FastestFps());
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (wanted > 0) {
    rate.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(1000 * wanted))};
    const int error = node.Call(VIDIOC_S_PARM, &rate);
    const double given = error == 0 ? FpsOf(rate.parm.capture.timeperframe) : 0;
    if (fps && std::abs(given - wanted) > kSameFps * wanted)
      throw Error("{}: the driver {}; leave fps out or choose another", node.Path(),
                  error != 0 ? fmt::format("refuses {:g} frames a second", wanted)
                             : fmt::format("changed {:g} frames a second to {:g}", wanted, given));
  } else if (node.Call(VIDIOC_G_PARM, &rate) != 0) {
    rate = {};
  }
  const v4l2_fract& interval = rate.parm.capture.timeperframe;
  return {.format = mode.format,
          .width = mode.width,
          .height = mode.height,
          .layout = {.row_bytes = got.bytesperline, .yuv = YuvEncodingOf(got)},
          .image_bytes = got.sizeimage,
          .transfer = TransferOf(got),
          .period_s =
              interval.denominator == 0 ? 0 : static_cast<double>(interval.numerator) / interval.denominator};
}

}  // namespace ulf::acquisition
