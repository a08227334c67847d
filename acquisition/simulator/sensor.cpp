#include "acquisition/simulator/sensor.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "acquisition/simulator/scene/lanes.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"

namespace ulf::acquisition {
namespace {

// The order is that of the enumeration.
const std::vector<PixelFormat>& Formats() {
  static const std::vector<PixelFormat> formats = [] {
    std::vector<PixelFormat> list;
    for (const char* name :
         {"Mono8",      "Mono10",     "Mono10p",    "Mono12",     "Mono12p",   "Mono16",    "BayerGR8",
          "BayerRG8",   "BayerGB8",   "BayerBG8",   "BayerGR12",  "BayerRG12", "BayerGB12", "BayerBG12",
          "BayerGR12p", "BayerRG12p", "BayerGB12p", "BayerBG12p", "RGB8",      "BGR8"})
      list.push_back(PixelFormatByName(name).value());
    return list;
  }();
  return formats;
}

template <typename Predicate>
std::optional<SensorFormat> FormatWhere(Predicate&& fits) {
  for (std::size_t i = 0; i < Formats().size(); ++i)
    if (fits(Formats()[i])) return static_cast<SensorFormat>(i);
  return std::nullopt;
}

// Returns the standard normal quantiles at the middles of 4096 equal shares, scaled to variance 1: noise by a
// table look-up, with tails to 3.7 sigma.
const std::array<float, 4096>& NormalTable() {
  static const std::array<float, 4096> table = [] {
    std::array<float, 4096> values{};
    double sum2 = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(values.size());
      double low = -5, high = 5;
      for (int k = 0; k < 50; ++k) {
        const double x = 0.5 * (low + high);
        (0.5 * std::erfc(-x * M_SQRT1_2) < p ? low : high) = x;
      }
      values[i] = static_cast<float>(low);
      sum2 += low * low;
    }
    const auto scale = static_cast<float>(std::sqrt(static_cast<double>(values.size()) / sum2));
    for (float& value : values) value *= scale;
    return values;
  }();
  return table;
}

// splitmix64 (Steele, Lea, Flood 2014): five draws of 12 bits from each step.
class NormalSource {
 public:
  explicit NormalSource(std::uint64_t seed) : state_(seed * 0xD1342543DE82EF95u + 0x9E3779B97F4A7C15u) {}
  float Next() {
    if (left_ == 0) {
      state_ += 0x9E3779B97F4A7C15u;
      std::uint64_t z = state_;
      z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
      z = (z ^ z >> 27) * 0x94D049BB133111EBu;
      bits_ = z ^ z >> 31;
      left_ = 5;
    }
    --left_;
    const float value = table_[bits_ & 4095];
    bits_ >>= 12;
    return value;
  }

 private:
  const std::array<float, 4096>& table_ = NormalTable();
  std::uint64_t state_, bits_ = 0;
  int left_ = 0;
};

struct Electrons {
  float per_radiance, variance_scale, read_variance, number_per_share;
  bool noise;
};

// Scales a number to 16 bits as pixel_format.h does: its high bits fill the low ones.
template <int kBits>
struct Spread {
  static_assert(kBits > 8 && kBits <= 16);
  static std::uint16_t To(std::uint32_t value) {
    return static_cast<std::uint16_t>(value << (16 - kBits) | value >> (2 * kBits - 16));
  }
};
template <>
struct Spread<8> {
  static std::uint8_t To(std::uint32_t value) { return static_cast<std::uint8_t>(value); }
};

// Light and noise are shares of the full well.
template <int kBits, typename Number>
void Convert(const std::vector<float>& radiance, const Electrons& e, NormalSource& source,
             std::vector<float>& noise, Number* out) {
  constexpr float kMost = (1 << kBits) - 1;
  const std::size_t count = radiance.size();
  if (e.noise) {
    noise.resize(count);
    for (float& value : noise) value = source.Next();
  } else {
    noise.assign(count, 0.0f);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float share = radiance[i] * e.per_radiance;
    const float sigma = std::sqrt(share * e.variance_scale + e.read_variance);
    const float number = (share + sigma * noise[i]) * e.number_per_share + 0.5f;
    out[i] = Spread<kBits>::To(
        static_cast<std::uint32_t>(static_cast<std::int32_t>(std::min(kMost, std::max(0.0f, number)))));
  }
}

void GatherRow(const F4* light, int y, int width, const PixelFormat& format, std::vector<float>& row) {
  row.resize(static_cast<std::size_t>(format.channels) * static_cast<std::size_t>(width));
  if (format.mosaic != Mosaic::kNone) {
    // All four orders are R G / G B, starting at different corners.
    const int from_x = format.mosaic == Mosaic::kGrbg || format.mosaic == Mosaic::kBggr ? 1 : 0;
    const int from_y = format.mosaic == Mosaic::kGbrg || format.mosaic == Mosaic::kBggr ? 1 : 0;
    for (int x = 0; x < width; ++x)
      row[static_cast<std::size_t>(x)] = light[x][2 - ((y + from_y) & 1) - ((x + from_x) & 1)];
  } else if (format.channels == 1) {
    for (int x = 0; x < width; ++x)
      row[static_cast<std::size_t>(x)] = 0.114f * light[x][0] + 0.587f * light[x][1] + 0.299f * light[x][2];
  } else {
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        row[3 * static_cast<std::size_t>(x) + static_cast<std::size_t>(c)] = light[x][c];
  }
}

constexpr double kDaylightK = 6504;

double Planck(double nanometres, double kelvin) {
  constexpr double kSecondRadiationConstant = 1.438777e7;  // nm K
  return 1 / std::expm1(kSecondRadiationConstant / (nanometres * kelvin));
}

// Returns "Mono8, Mono10, ...".
std::string SensorFormatNames() {
  std::string list;
  for (const PixelFormat& format : Formats()) list += (list.empty() ? "" : ", ") + std::string(format.name);
  return list;
}

}  // namespace

std::optional<SensorFormat> SensorFormatByName(const std::string& name) {
  return FormatWhere(
      [&](const PixelFormat& format) { return Lowercase(std::string(format.name)) == Lowercase(name); });
}

std::optional<SensorFormat> SensorFormatByCode(std::uint32_t pfnc) {
  return FormatWhere([&](const PixelFormat& format) { return format.code == pfnc; });
}

const PixelFormat& PixelsOf(SensorFormat format) { return Formats()[static_cast<std::size_t>(format)]; }

std::optional<SensorFormat> SensorFormatOf(const DeviceUri& uri) {
  const auto name = uri.Option("format");
  if (!name) return std::nullopt;
  const auto known = SensorFormatByName(*name);
  if (!known)
    throw Refused(uri, fmt::format("there is no format '{}'", *name),
                  fmt::format("there are {}", SensorFormatNames()));
  return known;
}

Image Expose(const cv::Mat& radiance, const SensorShot& shot) {
  CV_Assert(radiance.type() == CV_32FC4);
  const PixelFormat& format = PixelsOf(shot.format);
  const double read_share = kReadNoiseElectrons / kFullWellElectrons;
  const Electrons electrons{static_cast<float>(shot.exposure_s / kReferenceExposure_s),
                            static_cast<float>(1 / kFullWellElectrons),
                            static_cast<float>(read_share * read_share),
                            static_cast<float>(((1 << format.bits) - 1) * shot.gain), shot.noise};
  Image image;
  image.transfer = Transfer::kLinear;
  image.mosaic = format.mosaic;
  image.pixels.create(radiance.size(), CV_MAKETYPE(format.bits == 8 ? CV_8U : CV_16U, format.channels));
  NormalSource source(shot.noise_seed);
  std::vector<float> row, noise;
  for (int y = 0; y < radiance.rows; ++y) {
    GatherRow(radiance.ptr<F4>(y), y, radiance.cols, format, row);
    auto* wide = image.pixels.ptr<std::uint16_t>(y);
    switch (format.bits) {
      case 8:
        Convert<8>(row, electrons, source, noise, image.pixels.ptr<std::uint8_t>(y));
        break;
      case 10:
        Convert<10>(row, electrons, source, noise, wide);
        break;
      case 12:
        Convert<12>(row, electrons, source, noise, wide);
        break;
      default:
        Convert<16>(row, electrons, source, noise, wide);
    }
  }
  return image;
}

SensorColors SensorColors::FromUri(const DeviceUri& uri) {
  SensorColors colors;
  colors.lamp_k = uri.Number("lamp_k", colors.lamp_k, 1500, 20000);
  colors.crosstalk = uri.Number("crosstalk", colors.crosstalk, 0, 0.4);
  return colors;
}

Eigen::Matrix3d SensorColors::CameraFromSrgb() const {
  const auto beside_daylight = [&](double nanometres) {
    return Planck(nanometres, lamp_k) / Planck(nanometres, kDaylightK);
  };
  const Eigen::Vector3d lamp(beside_daylight(600), beside_daylight(540), beside_daylight(450));
  Eigen::Matrix3d neighbours;
  neighbours << 0, 0.8, 0.2, 0.5, 0, 0.5, 0.1, 0.9, 0;
  const Eigen::Matrix3d filters = (1 - crosstalk) * Eigen::Matrix3d::Identity() + crosstalk * neighbours;
  return filters * (lamp / lamp[1]).asDiagonal();
}

Eigen::Vector3d SensorColors::WhiteBalance() const {
  const Eigen::Vector3d white = CameraFromSrgb() * Eigen::Vector3d::Ones();
  return white[1] * white.cwiseInverse();
}

Eigen::Matrix3d SensorColors::SrgbFromBalanced() const {
  const Eigen::Matrix3d balanced = WhiteBalance().asDiagonal() * CameraFromSrgb();
  return (balanced * Eigen::Vector3d::Ones())[1] * balanced.inverse();
}

}  // namespace ulf::acquisition
