#include "tests/support/dng_file.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace ulf::test {
namespace {

enum DngType : std::uint16_t { kByte = 1, kAscii = 2, kShort = 3, kLong = 4, kRational = 5, kSrational = 10 };

std::string Little(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}

struct Entry {
  DngType type;
  std::uint32_t count;
  std::string bytes;
};

// A directory of TIFF tags, in their order.
class Directory {
 public:
  void Whole(std::uint16_t tag, DngType type, const std::vector<std::uint32_t>& values) {
    std::string bytes;
    for (const std::uint32_t value : values)
      bytes += Little(value, type == kByte ? 1 : type == kShort ? 2 : 4);
    entries_[tag] = {type, static_cast<std::uint32_t>(values.size()), bytes};
  }
  void Text(std::uint16_t tag, std::string text) {
    text += '\0';
    entries_[tag] = {kAscii, static_cast<std::uint32_t>(text.size()), text};
  }
  void Ratios(std::uint16_t tag, DngType type, const std::vector<double>& values) {
    constexpr double kDenominator = 1e6;
    std::string bytes;
    for (const double value : values)
      bytes +=
          Little(static_cast<std::uint32_t>(static_cast<std::int64_t>(std::lround(value * kDenominator))),
                 4) +
          Little(static_cast<std::uint32_t>(kDenominator), 4);
    entries_[tag] = {type, static_cast<std::uint32_t>(values.size()), bytes};
  }
  std::uint32_t Size() const {
    auto size = static_cast<std::uint32_t>(2 + 12 * entries_.size() + 4);
    for (const auto& [tag, entry] : entries_)
      if (entry.bytes.size() > 4)
        size += static_cast<std::uint32_t>(entry.bytes.size() + entry.bytes.size() % 2);
    return size;
  }
  std::string BytesAt(std::uint32_t offset) const {
    std::string directory = Little(static_cast<std::uint32_t>(entries_.size()), 2), values;
    const auto behind = static_cast<std::uint32_t>(offset + 2 + 12 * entries_.size() + 4);
    for (const auto& [tag, entry] : entries_) {
      directory += Little(tag, 2) + Little(entry.type, 2) + Little(entry.count, 4);
      if (entry.bytes.size() <= 4) {
        directory += (entry.bytes + std::string(4, '\0')).substr(0, 4);
        continue;
      }
      directory += Little(behind + static_cast<std::uint32_t>(values.size()), 4);
      values += entry.bytes;
      if (values.size() % 2) values += '\0';
    }
    return directory + Little(0, 4) + values;
  }

 private:
  std::map<std::uint16_t, Entry> entries_;
};

// Most significant bit first, rows begin with a byte; 16 bits are little-endian.
std::string Packed(const std::vector<std::uint32_t>& row, int bits) {
  std::string bytes;
  if (bits == 16) {
    for (const std::uint32_t value : row) bytes += Little(value, 2);
    return bytes;
  }
  std::uint64_t held = 0;
  int held_bits = 0;
  for (const std::uint32_t value : row) {
    held = held << bits | value;
    held_bits += bits;
    for (; held_bits >= 8; held_bits -= 8) bytes += static_cast<char>(held >> (held_bits - 8) & 0xFF);
  }
  if (held_bits > 0) bytes += static_cast<char>(held << (8 - held_bits) & 0xFF);
  return bytes;
}

int Modulo(int a, int b) { return (a % b + b) % b; }

// White is (1, 1, 1) in either: what the colour matrix of DNG comes to when the white balance is divided out.
Eigen::Matrix3d BalancedFromSrgb(const std::array<double, 9>& matrix) {
  if (std::ranges::all_of(matrix, [](double each) { return each == 0; })) return Eigen::Matrix3d::Identity();
  Eigen::Matrix3d xyz_from_srgb;
  xyz_from_srgb << 0.412453, 0.357580, 0.180423, 0.212671, 0.715160, 0.072169, 0.019334, 0.119193, 0.950227;
  Eigen::Matrix3d camera_from_srgb =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.data()) * xyz_from_srgb;
  for (int i = 0; i < 3; ++i) camera_from_srgb.row(i) /= camera_from_srgb.row(i).sum();
  return camera_from_srgb;
}

}  // namespace

std::string DngBytes(const DngCamera& camera, const DngLight& light) {
  const bool is_linear = camera.pattern.empty();
  const int side = is_linear ? 1 : static_cast<int>(std::lround(std::sqrt(camera.pattern.size())));
  const int samples = is_linear ? 3 : 1;
  const auto color = [&](int x, int y) {
    const char name = camera.pattern[static_cast<std::size_t>(Modulo(y, side) * side + Modulo(x, side))];
    return name == 'R' ? 0 : name == 'G' ? 1 : 2;
  };
  const bool says_neutral = camera.neutral[1] > 0;
  const Eigen::Matrix3d balanced_from_srgb = BalancedFromSrgb(camera.matrix);
  std::string pixels;
  const double most = std::ldexp(1, camera.bits) - 1;
  const auto put_pixel = [&](int x, int y, std::vector<std::uint32_t>& row) {
    const int u = x - camera.visible.x, v = y - camera.visible.y;
    for (int sample = 0; sample < samples; ++sample) {
      const int c = is_linear ? sample : color(u, v);
      const int black = camera.blacks ? (*camera.blacks)[static_cast<std::size_t>(c)] : camera.black;
      double level = black;
      if (camera.visible.contains({x, y})) {
        const cv::Vec3d rgb = light(u, v);
        const double balanced = balanced_from_srgb.row(c).dot(Eigen::Vector3d(rgb[0], rgb[1], rgb[2]));
        const double full = says_neutral ? camera.neutral[static_cast<std::size_t>(c)] : 1;
        level += (camera.white - black) * full * balanced;
      }
      // The sensor is full at its white level.
      row.push_back(static_cast<std::uint32_t>(
          std::lround(std::clamp(level, 0.0, std::min<double>(camera.white, most)))));
    }
  };
  const cv::Size block = camera.tile > 0 ? cv::Size(camera.tile, camera.tile) : camera.sensor;
  std::vector<std::uint32_t> places, sizes;
  for (int top = 0; top < camera.sensor.height; top += block.height)
    for (int left = 0; left < camera.sensor.width; left += block.width) {
      places.push_back(static_cast<std::uint32_t>(pixels.size()));
      for (int y = top; y < top + block.height; ++y) {
        std::vector<std::uint32_t> row;
        for (int x = left; x < left + block.width; ++x) put_pixel(x, y, row);
        pixels += Packed(row, camera.bits);
      }
      sizes.push_back(static_cast<std::uint32_t>(pixels.size()) - places.back());
    }

  const auto whole = [](int value) { return static_cast<std::uint32_t>(value); };
  Directory exif;
  exif.Ratios(0x829A, kRational, {camera.exposure_s});
  exif.Ratios(0x829D, kRational, {camera.f_number});
  exif.Whole(0x8827, kShort, {whole(camera.iso)});
  exif.Ratios(0x920A, kRational, {camera.focal_mm});
  exif.Whole(0xA405, kShort, {whole(camera.focal_35mm)});
  if (!camera.lens.empty()) exif.Text(0xA434, camera.lens);

  Directory main;
  main.Whole(254, kLong, {0});
  main.Whole(256, kLong, {whole(camera.sensor.width)});
  main.Whole(257, kLong, {whole(camera.sensor.height)});
  main.Whole(258, kShort, std::vector<std::uint32_t>(static_cast<std::size_t>(samples), whole(camera.bits)));
  main.Whole(259, kShort, {1});
  main.Whole(262, kShort, {is_linear ? 34892U : 32803U});
  main.Text(271, "Acme");
  main.Text(272, camera.model);
  main.Whole(274, kShort, {whole(camera.orientation)});
  main.Whole(277, kShort, {whole(samples)});
  const std::uint16_t places_tag = camera.tile > 0 ? 324 : 273;
  main.Whole(places_tag, kLong, places);
  if (camera.tile > 0) {
    main.Whole(322, kLong, {whole(camera.tile)});
    main.Whole(323, kLong, {whole(camera.tile)});
    main.Whole(325, kLong, sizes);
  } else {
    main.Whole(278, kLong, {whole(camera.sensor.height)});
    main.Whole(279, kLong, sizes);
  }
  main.Whole(284, kShort, {1});
  if (!is_linear) main.Whole(33421, kShort, {whole(side), whole(side)});
  std::vector<std::uint32_t> pattern;
  for (int y = 0; !is_linear && y < side; ++y)
    for (int x = 0; x < side; ++x) pattern.push_back(whole(color(x, y)));
  if (!is_linear) main.Whole(33422, kByte, pattern);
  main.Whole(34665, kLong, {0});
  main.Whole(50706, kByte, {1, 4, 0, 0});
  main.Whole(50707, kByte, {1, 1, 0, 0});
  main.Text(50708, camera.model);
  if (!is_linear) main.Whole(50711, kShort, {whole(camera.mosaic_layout)});
  if (camera.blacks)
    main.Whole(50714, kLong,
               {whole((*camera.blacks)[0]), whole((*camera.blacks)[1]), whole((*camera.blacks)[2])});
  else
    main.Whole(50714, kLong,
               std::vector<std::uint32_t>(static_cast<std::size_t>(samples), whole(camera.black)));
  main.Whole(50717, kLong, {whole(camera.white)});
  if (camera.crop) {
    main.Whole(50719, kLong, {whole(camera.crop->x), whole(camera.crop->y)});
    main.Whole(50720, kLong, {whole(camera.crop->width), whole(camera.crop->height)});
  }
  if (camera.matrix[0] != 0) {
    main.Ratios(50721, kSrational, {camera.matrix.begin(), camera.matrix.end()});
    main.Whole(50778, kShort, {21});
  }
  const std::array<double, 3> told = camera.told_neutral.value_or(camera.neutral);
  if (says_neutral) main.Ratios(50728, kRational, {told.begin(), told.end()});
  main.Whole(50829, kLong,
             {whole(camera.visible.y), whole(camera.visible.x), whole(camera.visible.br().y),
              whole(camera.visible.br().x)});

  constexpr std::uint32_t kHead = 8;
  const std::uint32_t exif_at = kHead + main.Size(), pixels_at = exif_at + exif.Size();
  main.Whole(34665, kLong, {exif_at});
  for (std::uint32_t& place : places) place += pixels_at;
  main.Whole(places_tag, kLong, places);
  return "II*" + std::string(1, '\0') + Little(kHead, 4) + main.BytesAt(kHead) + exif.BytesAt(exif_at) +
         pixels;
}

cv::Mat LightOf(const DngLight& light, const cv::Rect& crop) {
  cv::Mat all(crop.size(), CV_32FC3);
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x) {
      const cv::Vec3d rgb = light(crop.x + x, crop.y + y);
      all.at<cv::Vec3f>(y, x) = {static_cast<float>(rgb[2]), static_cast<float>(rgb[1]),
                                 static_cast<float>(rgb[0])};
    }
  return all;
}

}  // namespace ulf::test
