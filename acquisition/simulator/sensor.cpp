#include "acquisition/simulator/sensor.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <vector>

#include "acquisition/simulator/lanes.h"

namespace ulf {
namespace {

constexpr std::pair<const char*, SensorFormat> kFormats[] = {
    {"Mono8", SensorFormat::kMono8}, {"BayerRG8", SensorFormat::kBayerRg8}, {"RGB8", SensorFormat::kRgb8}};

// The standard normal quantiles at the middles of 4096 equal shares, scaled to variance 1 again: noise by one
// look-up, with tails to 3.7 sigma.
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

// A row of radiances to a row of 8-bit numbers. Light and noise are shares of the full well.
void Convert(const std::vector<float>& radiance, const Electrons& e, NormalSource& source,
             std::vector<float>& noise, std::uint8_t* out) {
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
    out[i] = static_cast<std::uint8_t>(std::min(255.0f, std::max(0.0f, number)));
  }
}

void GatherRow(const F4* light, int y, int width, SensorFormat format, std::vector<float>& row) {
  switch (format) {
    case SensorFormat::kMono8:
      row.resize(static_cast<std::size_t>(width));
      for (int x = 0; x < width; ++x)
        row[static_cast<std::size_t>(x)] = 0.114f * light[x][0] + 0.587f * light[x][1] + 0.299f * light[x][2];
      break;
    case SensorFormat::kBayerRg8:  // R G / G B
      row.resize(static_cast<std::size_t>(width));
      for (int x = 0; x < width; ++x) row[static_cast<std::size_t>(x)] = light[x][2 - (y & 1) - (x & 1)];
      break;
    case SensorFormat::kRgb8:
      row.resize(3 * static_cast<std::size_t>(width));
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c)
          row[3 * static_cast<std::size_t>(x) + static_cast<std::size_t>(c)] = light[x][c];
      break;
  }
}

}  // namespace

std::optional<SensorFormat> SensorFormatByName(const std::string& name) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  for (const auto& [known, format] : kFormats) {
    const std::string text = known;
    if (std::equal(text.begin(), text.end(), name.begin(), name.end(), same)) return format;
  }
  return std::nullopt;
}

const char* NameOf(SensorFormat format) {
  for (const auto& [name, known] : kFormats)
    if (known == format) return name;
  return "";
}

Image Expose(const cv::Mat& radiance, const SensorOptions& options, const SensorShot& shot) {
  CV_Assert(radiance.type() == CV_32FC4);
  const double read_share = options.read_noise_electrons / options.full_well_electrons;
  const Electrons electrons{static_cast<float>(shot.exposure_s / options.reference_exposure_s),
                            static_cast<float>(1 / options.full_well_electrons),
                            static_cast<float>(read_share * read_share), static_cast<float>(255 * shot.gain),
                            options.noise};
  Image image;
  image.transfer = Transfer::kLinear;
  image.mosaic = shot.format == SensorFormat::kBayerRg8 ? Mosaic::kRggb : Mosaic::kNone;
  image.pixels.create(radiance.size(), shot.format == SensorFormat::kRgb8 ? CV_8UC3 : CV_8UC1);
  NormalSource source(shot.noise_seed);
  std::vector<float> row, noise;
  for (int y = 0; y < radiance.rows; ++y) {
    GatherRow(radiance.ptr<F4>(y), y, radiance.cols, shot.format, row);
    Convert(row, electrons, source, noise, image.pixels.ptr<std::uint8_t>(y));
  }
  return image;
}

}  // namespace ulf
