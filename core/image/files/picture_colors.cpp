#include "core/image/files/picture_colors.h"

#include <fmt/core.h>
#include <lcms2.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/image/files/exif.h"
#include "core/image/image.h"

namespace ulf {
namespace {

struct CloseProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
struct DeleteTransform {
  void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
struct FreeCurve {
  void operator()(cmsToneCurve* curve) const { cmsFreeToneCurve(curve); }
};
using Profile = std::unique_ptr<void, CloseProfile>;
using Transform = std::unique_ptr<void, DeleteTransform>;
using Curve = std::unique_ptr<cmsToneCurve, FreeCurve>;

cmsCIExyY WhiteOf(const Primaries& xy) { return {xy[6], xy[7], 1}; }

// Makes a profile with a tone curve that all channels share.
Profile RgbProfile(const Primaries& xy, cmsToneCurve* curve) {
  const cmsCIExyYTRIPLE colors{{xy[0], xy[1], 1}, {xy[2], xy[3], 1}, {xy[4], xy[5], 1}};
  const cmsCIExyY white = WhiteOf(xy);
  cmsToneCurve* curves[3] = {curve, curve, curve};
  return Profile(cmsCreateRGBProfile(&white, &colors, curves));
}

// None means sRGB's curve.
Curve CurveOf(std::optional<double> exponent) {
  constexpr int kSrgbShape = 4;
  const double srgb[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  return Curve(exponent ? cmsBuildGamma(nullptr, *exponent)
                        : cmsBuildParametricToneCurve(nullptr, kSrgbShape, srgb));
}

// Returns the profile of the result: encoded for display, or linear for float pixels.
Profile Target(int depth, int channels) {
  const Curve curve = CurveOf(depth == CV_32F ? std::optional(1.0) : std::nullopt);
  if (channels != 1) return RgbProfile(kSrgbPrimaries, curve.get());
  const cmsCIExyY white = WhiteOf(kSrgbPrimaries);
  return Profile(cmsCreateGrayProfile(&white, curve.get()));
}

cmsUInt32Number FormatOf(int depth, int channels) {
  if (channels == 1) return depth == CV_8U ? TYPE_GRAY_8 : depth == CV_16U ? TYPE_GRAY_16 : TYPE_GRAY_FLT;
  return depth == CV_8U ? TYPE_BGR_8 : depth == CV_16U ? TYPE_BGR_16 : TYPE_BGR_FLT;
}

Transform MakeTransform(const Profile& from, cmsUInt32Number from_format, const Profile& to,
                        cmsUInt32Number to_format) {
  constexpr cmsUInt32Number flags =
      cmsFLAGS_BLACKPOINTCOMPENSATION | cmsFLAGS_NOCACHE | cmsFLAGS_HIGHRESPRECALC;
  return Transform(from && to ? cmsCreateTransform(from.get(), from_format, to.get(), to_format,
                                                   INTENT_RELATIVE_COLORIMETRIC, flags)
                              : nullptr);
}

void Apply(const Transform& transform, const cv::Mat& from, cv::Mat& to) {
  cmsDoTransformLineStride(transform.get(), from.data, to.data, static_cast<cmsUInt32Number>(from.cols),
                           static_cast<cmsUInt32Number>(from.rows), static_cast<cmsUInt32Number>(from.step),
                           static_cast<cmsUInt32Number>(to.step), 0, 0);
}

// Marks channels that are not finite by 255; empty if there are none.
cv::Mat WithoutLight(const cv::Mat& pixels) {
  cv::Mat unlit(pixels.size(), CV_8UC1, cv::Scalar(0));
  bool any = false;
  for (int y = 0; y < pixels.rows; ++y)
    for (int i = 0; i < pixels.cols * pixels.channels(); ++i)
      if (!std::isfinite(pixels.ptr<float>(y)[i])) {
        unlit.at<std::uint8_t>(y, i / pixels.channels()) = 255;
        any = true;
      }
  return any ? unlit : cv::Mat();
}

// Converts to linear sRGB in float, computed for each pixel; for integers the library would interpolate
// between colours of a table, which is wrong by up to twenty levels of 255 near the border of the gamut.
// Returns an empty image if the profile cannot be used.
cv::Mat LinearBy(const Profile& profile, const cv::Mat& pixels) {
  const int channels = pixels.channels();
  const cmsUInt32Number format = FormatOf(CV_32F, channels);
  const Profile target = Target(CV_32F, channels);
  const Transform transform = MakeTransform(profile, format, target, format);
  if (!transform) return {};
  cv::Mat from, linear(pixels.size(), CV_MAKETYPE(CV_32F, channels));
  pixels.convertTo(from, CV_32F, 1 / FullScale(pixels.depth()));
  const cv::Mat unlit = pixels.depth() == CV_32F ? WithoutLight(from) : cv::Mat();
  if (!unlit.empty()) from.setTo(0, unlit);  // the library's curves are tables
  cv::parallel_for_({0, from.rows}, [&](const cv::Range& rows) {
    cv::Mat to = linear.rowRange(rows);
    Apply(transform, from.rowRange(rows), to);
  });
  if (!unlit.empty()) linear.setTo(cv::Scalar::all(std::numeric_limits<double>::quiet_NaN()), unlit);
  return linear;
}

cv::Mat EncodedAs(int depth, const cv::Mat& linear) {
  const auto full = static_cast<float>(FullScale(depth));
  cv::Mat encoded(linear.size(), CV_MAKETYPE(depth, linear.channels()));
  cv::parallel_for_({0, linear.rows}, [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y)
      for (int i = 0; i < linear.cols * linear.channels(); ++i) {
        const float level = full * SrgbFromLinear(std::clamp(linear.ptr<float>(y)[i], 0.0F, 1.0F));
        if (depth == CV_8U)
          encoded.ptr<std::uint8_t>(y)[i] = cv::saturate_cast<std::uint8_t>(level);
        else
          encoded.ptr<std::uint16_t>(y)[i] = cv::saturate_cast<std::uint16_t>(level);
      }
  });
  return encoded;
}

// Returns an empty image if the profile cannot be used. 8-bit colour is exact and fast in the library.
cv::Mat Converted(const Profile& profile, const cv::Mat& pixels) {
  const int depth = pixels.depth();
  if (depth == CV_32F) return LinearBy(profile, pixels);
  if (depth == CV_16U || pixels.channels() == 1) {
    const cv::Mat linear = LinearBy(profile, pixels);
    return linear.empty() ? cv::Mat() : EncodedAs(depth, linear);
  }
  const Profile target = Target(depth, 3);
  const cmsUInt32Number format = FormatOf(depth, 3);
  const Transform transform = MakeTransform(profile, format, target, format);
  if (!transform) return {};
  cv::Mat converted(pixels.size(), pixels.type());
  Apply(transform, pixels, converted);
  return converted;
}

// Returns whether no colour changes by more than rounding does.
bool IsIdentity(const Profile& profile, int channels) {
  constexpr int kStep = 32;
  std::vector<cv::Vec3b> grid;
  for (int b = 0; b <= 256; b += kStep)
    for (int g = 0; g <= 256; g += kStep)
      for (int r = 0; r <= 256; r += kStep)
        grid.emplace_back(cv::saturate_cast<std::uint8_t>(b), cv::saturate_cast<std::uint8_t>(g),
                          cv::saturate_cast<std::uint8_t>(r));
  cv::Mat before(1, static_cast<int>(grid.size()), CV_8UC3, grid.data()), after;
  if (channels == 1) cv::extractChannel(before.clone(), before, 0);
  after.create(before.size(), before.type());
  const Profile target = Target(CV_8U, channels);
  const cmsUInt32Number format = FormatOf(CV_8U, channels);
  const Transform transform = MakeTransform(profile, format, target, format);
  if (!transform) return false;
  Apply(transform, before, after);
  return cv::norm(before, after, cv::NORM_INF) <= 1;
}

std::string NameOf(const Profile& profile) {
  std::string text(256, '\0');
  const cmsUInt32Number size = cmsGetProfileInfoASCII(profile.get(), cmsInfoDescription, "en", "US",
                                                      text.data(), static_cast<cmsUInt32Number>(text.size()));
  text.resize(std::min<std::size_t>(size, text.size()));
  const std::string name = ExifText(text);
  return name.empty() ? "without a name" : fmt::format("'{}'", name);
}

std::string SpaceName(cmsColorSpaceSignature space) {
  static const std::map<cmsColorSpaceSignature, std::string> kNames = {{cmsSigCmykData, "CMYK"},
                                                                       {cmsSigLabData, "Lab"},
                                                                       {cmsSigXYZData, "XYZ"},
                                                                       {cmsSigRgbData, "RGB"},
                                                                       {cmsSigGrayData, "grey"}};
  const auto name = kNames.find(space);
  return name == kNames.end() ? "another space" : name->second;
}

Profile OpenProfile(const std::string& icc) {
  return Profile(icc.empty() ? nullptr
                             : cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
}

// Returns null if the pixels stay: they are as promised, or a warning says why not.
Profile ProfileOfIcc(const std::string& icc, StoredPicture& picture) {
  Profile profile = OpenProfile(icc);
  if (!profile) {
    picture.warnings.push_back("its colour profile (ICC) is damaged: its colours are taken for sRGB");
    return nullptr;
  }
  const cmsColorSpaceSignature space = cmsGetColorSpace(profile.get());
  if (space == cmsSigRgbData && picture.pixels.channels() == 1)
    cv::cvtColor(picture.pixels, picture.pixels, cv::COLOR_GRAY2BGR);
  const int channels = picture.pixels.channels();
  if (space != (channels == 1 ? cmsSigGrayData : cmsSigRgbData)) {
    picture.warnings.push_back(
        fmt::format("its colour profile {} is for {}, and its pixels are {}: they are taken for sRGB",
                    NameOf(profile), SpaceName(space), channels == 1 ? "grey" : "RGB"));
    return nullptr;
  }
  return profile;
}

std::string NameOf(const ColorTags& claim) {
  if (!claim.name.empty()) return claim.name;
  std::string text;
  if (claim.primaries) {
    const Primaries& xy = *claim.primaries;
    text = fmt::format("primaries ({:g}, {:g}), ({:g}, {:g}), ({:g}, {:g}), white ({:g}, {:g})", xy[0], xy[1],
                       xy[2], xy[3], xy[4], xy[5], xy[6], xy[7]);
  }
  if (claim.exponent) text += fmt::format("{}exponent {:g}", text.empty() ? "" : ", ", *claim.exponent);
  return text;
}

bool IsPossible(const Primaries& xy) {
  for (const double value : xy)
    if (!std::isfinite(value) || std::abs(value) > 2) return false;
  const double area = (xy[2] - xy[0]) * (xy[5] - xy[1]) - (xy[4] - xy[0]) * (xy[3] - xy[1]);
  return std::abs(area) > 1e-4 && xy[1] > -1 && xy[7] > 1e-3;
}

}  // namespace

void ConvertToSrgb(const ColorTags& claim, StoredPicture& picture) {
  const bool is_float = picture.pixels.depth() == CV_32F;
  Profile profile;
  std::string name;
  if (!claim.icc.empty()) {
    profile = ProfileOfIcc(claim.icc, picture);
    if (!profile) return;
    if (!is_float && IsIdentity(profile, picture.pixels.channels())) return;
    name = fmt::format("the profile {}", NameOf(profile));
  } else if (claim.primaries || claim.exponent) {
    const Primaries xy = claim.primaries.value_or(kSrgbPrimaries);
    if (!IsPossible(xy) || (claim.exponent && !(*claim.exponent > 0.05 && *claim.exponent < 20))) {
      picture.warnings.push_back(
          fmt::format("its colours claim {}, which cannot be: they are taken for sRGB", NameOf(claim)));
      return;
    }
    const auto exponent = is_float && !claim.exponent ? std::optional(1.0) : claim.exponent;
    const Curve curve = CurveOf(exponent);
    if (picture.pixels.channels() == 1) {
      const cmsCIExyY white = WhiteOf(xy);
      profile.reset(cmsCreateGrayProfile(&white, curve.get()));
    } else {
      profile = RgbProfile(xy, curve.get());
    }
    constexpr double kSame = 0.002;
    bool is_same = is_float && exponent == 1.0;
    for (std::size_t i = 0; i < xy.size(); ++i)
      is_same = is_same && std::abs(xy[i] - kSrgbPrimaries[i]) < kSame;
    if (is_same || (!is_float && profile && IsIdentity(profile, picture.pixels.channels()))) return;
    name = NameOf(claim);
  } else {
    return;
  }
  const cv::Mat converted = Converted(profile, picture.pixels);
  if (converted.empty()) {
    picture.warnings.push_back(
        fmt::format("its colours are of {}, which cannot be converted: they are taken for sRGB", name));
    return;
  }
  picture.pixels = converted;
  picture.notes.push_back({"its colours are of " + name,
                           is_float ? " and converted to linear sRGB" : " and converted to sRGB",
                           claim.icc.empty() ? PictureNote::Kind::kOther : PictureNote::Kind::kTagged});
}

cv::Mat SrgbOfInks(const cv::Mat& inks, bool is_inverted, const std::string& icc, StoredPicture& picture) {
  const int depth = inks.depth();
  cv::Mat bgr(inks.size(), CV_MAKETYPE(depth, 3));
  const Profile profile = OpenProfile(icc);
  if (profile && cmsGetColorSpace(profile.get()) == cmsSigCmykData) {
    const cmsUInt32Number direct = depth == CV_8U ? TYPE_CMYK_8 : TYPE_CMYK_16,
                          inverted = depth == CV_8U ? TYPE_CMYK_8_REV : TYPE_CMYK_16_REV;
    const Profile target = Target(depth, 3);
    if (const Transform transform =
            MakeTransform(profile, is_inverted ? inverted : direct, target, FormatOf(depth, 3))) {
      Apply(transform, inks, bgr);
      picture.notes.push_back({fmt::format("its inks (CMYK) are of the profile {}", NameOf(profile)),
                               " and converted to sRGB", PictureNote::Kind::kTagged});
      return bgr;
    }
  }
  picture.warnings.push_back(
      "it is made of inks (CMYK) without a usable profile: they are taken to be ideal, its colours are a "
      "guess");
  cv::Mat light;
  inks.convertTo(light, CV_32F, 1 / FullScale(depth));
  if (!is_inverted) light = cv::Scalar::all(1) - light;
  std::vector<cv::Mat> planes;
  cv::split(light, planes);
  cv::Mat colors;
  cv::merge(
      std::vector<cv::Mat>{planes[2].mul(planes[3]), planes[1].mul(planes[3]), planes[0].mul(planes[3])},
      colors);
  colors.convertTo(bgr, depth, FullScale(depth));
  return bgr;
}

cv::Mat SrgbOfLab(const cv::Mat& lab, bool is_signed, const std::optional<std::array<double, 2>>& white_xy) {
  const auto xyz_of = [](const cmsCIExyY& xy) {
    cmsCIEXYZ xyz;
    cmsxyY2XYZ(&xyz, &xy);
    return xyz;
  };
  const cmsCIEXYZ white = white_xy ? xyz_of({(*white_xy)[0], (*white_xy)[1], 1}) : *cmsD50_XYZ(),
                  d65 = xyz_of(WhiteOf(kSrgbPrimaries));
  const cv::Matx33d rgb_from_xyz(3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560,
                                 0.0556434, -0.2040259, 1.0572252);
  const bool is_8_bits = lab.depth() == CV_8U;
  const double full = FullScale(lab.depth()), unit = is_8_bits ? 1 : 256, zero = 128 * unit;
  // TIFF has a* and b* signed, L* = 100 at full scale; ICC has both from -128, L* = 100 at 0xFF00 of 16 bits.
  const double most_light = is_signed || is_8_bits ? full : 65280;
  cv::Mat bgr(lab.size(), CV_MAKETYPE(lab.depth(), 3));
  const auto convert = [&]<typename Number>(Number) {
    for (int y = 0; y < lab.rows; ++y)
      for (int x = 0; x < lab.cols; ++x) {
        const auto& in = lab.at<cv::Vec<Number, 3>>(y, x);
        const auto chroma = [&](int c) {
          const double value = in[c];
          return (is_signed ? (value >= zero ? value - full - 1 : value) : value - zero) / unit;
        };
        const cmsCIELab color{100 * in[0] / most_light, chroma(1), chroma(2)};
        cmsCIEXYZ xyz, adapted;
        cmsLab2XYZ(&white, &xyz, &color);
        cmsAdaptToIlluminant(&adapted, &white, &d65, &xyz);
        const cv::Vec3d rgb = rgb_from_xyz * cv::Vec3d(adapted.X, adapted.Y, adapted.Z);
        for (int c = 0; c < 3; ++c)
          bgr.at<cv::Vec<Number, 3>>(y, x)[2 - c] = cv::saturate_cast<Number>(
              full * SrgbFromLinear(static_cast<float>(std::clamp(rgb[c], 0.0, 1.0))));
      }
  };
  if (is_8_bits)
    convert(std::uint8_t());
  else
    convert(std::uint16_t());
  return bgr;
}

}  // namespace ulf
