#include "acquisition/pixel_format.h"

#include <gmock/gmock.h>

#include <random>

#include "acquisition/error.h"

namespace ulf {
namespace {

using ::testing::HasSubstr;

// Every format of the table, by name: the list that error messages show.
std::vector<PixelFormat> AllFormats() {
  std::vector<PixelFormat> formats;
  std::string list = SupportedPixelFormats() + ", ";
  for (std::size_t start = 0, comma; (comma = list.find(", ", start)) != std::string::npos; start = comma + 2)
    formats.push_back(PixelFormatByName(list.substr(start, comma - start)).value());
  return formats;
}

// Packs as the standards draw it, value by value and bit by bit: slow, and unlike the unpacking.
std::vector<std::uint8_t> Pack(const PixelFormat& format, const std::vector<std::uint32_t>& values) {
  std::vector<std::uint8_t> bytes(ImageBytes(format, static_cast<int>(values.size()), 1), 0);
  const auto set_bit = [&](std::size_t bit) { bytes[bit / 8] |= static_cast<std::uint8_t>(1u << (bit % 8)); };
  for (std::size_t i = 0; i < values.size(); ++i)
    for (int b = 0; b < format.bits; ++b) {
      if (!(values[i] >> b & 1)) continue;
      const int low_bits = format.bits - 8;
      const auto bit = static_cast<std::size_t>(b);
      if (format.packing == PixelPacking::kLsbPacked)
        set_bit(i * static_cast<std::size_t>(format.bits) + bit);
      else if (format.packing == PixelPacking::kWholeBytes)
        set_bit(i * (format.bits > 8 ? 16 : 8) + bit);
      else if (b < low_bits)
        set_bit(24 * (i / 2) + 8 + (i % 2) * 4 + bit);
      else
        set_bit(24 * (i / 2) + (i % 2) * 16 + bit - static_cast<std::size_t>(low_bits));
    }
  return bytes;
}

TEST(PixelFormat, NumbersAndNamesAreOfOnePiece) {
  for (const PixelFormat& format : AllFormats()) {
    EXPECT_EQ(PixelFormatByCode(format.code)->name, format.name);
    // PFNC: the top byte says mono or colour, the next the bits that a pixel takes.
    EXPECT_EQ(format.code >> 24, format.channels == 1 ? 1u : 2u) << format.name;
    const int taken = format.packing == PixelPacking::kLsbPacked ? format.bits
                      : format.packing == PixelPacking::kGvspPacked
                          ? 12
                          : (format.bits > 8 ? 16 : 8) * format.channels;
    EXPECT_EQ(static_cast<int>(format.code >> 16 & 0xFF), taken) << format.name;
    EXPECT_EQ(format.name.starts_with("Bayer"), format.mosaic != Mosaic::kNone) << format.name;
  }
  EXPECT_FALSE(PixelFormatByName("YUV422_8"));
  EXPECT_FALSE(PixelFormatByCode(0x02100032));
}

TEST(PixelFormat, UnpacksEverySingleChannelFormat) {
  std::mt19937 random(3);
  for (const PixelFormat& format : AllFormats()) {
    if (format.channels != 1) continue;
    for (const int width : {2, 5, 8, 31}) {
      const std::uint32_t full = (1u << format.bits) - 1;
      std::vector<std::uint32_t> values(static_cast<std::size_t>(width));
      for (auto& value : values) value = static_cast<std::uint32_t>(random()) & full;
      values.front() = 0;
      values.back() = full;
      const auto bytes = Pack(format, values);
      const Image image = ImageFromBytes(format, width, 1, bytes.data(), bytes.size());
      ASSERT_EQ(image.width(), width);
      EXPECT_EQ(image.mosaic, format.mosaic);
      EXPECT_EQ(image.transfer, Transfer::kLinear);
      for (int x = 0; x < width; ++x) {
        const std::uint32_t value = values[static_cast<std::size_t>(x)];
        if (format.bits == 8) {
          ASSERT_EQ(image.pixels.at<std::uint8_t>(0, x), value) << format.name << " pixel " << x;
          continue;
        }
        const std::uint32_t got = image.pixels.at<std::uint16_t>(0, x);
        ASSERT_EQ(got >> (16 - format.bits), value) << format.name << " pixel " << x << ": not reversible";
        ASSERT_NEAR(got, 65535.0 * value / full, 1.0) << format.name << " pixel " << x << ": not full scale";
      }
    }
  }
}

TEST(PixelFormat, ColorIsBlueGreenRedInMemory) {
  const std::uint8_t bytes[6] = {1, 2, 3, 4, 5, 6};
  const Image rgb = ImageFromBytes(*PixelFormatByName("RGB8"), 2, 1, bytes, 6);
  EXPECT_EQ(rgb.pixels.at<cv::Vec3b>(0, 1), cv::Vec3b(6, 5, 4));
  const Image bgr = ImageFromBytes(*PixelFormatByName("BGR8"), 2, 1, bytes, 6);
  EXPECT_EQ(bgr.pixels.at<cv::Vec3b>(0, 1), cv::Vec3b(4, 5, 6));
}

// A red patch in every Bayer order comes out red: names, patterns and demosaicing agree.
TEST(PixelFormat, EveryBayerOrderGivesTheSameColor) {
  for (const char* name : {"BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8"}) {
    constexpr int kSize = 16;
    std::vector<std::uint8_t> bytes(kSize * kSize);
    // The name gives the first two pixels of the first row; the second row has what is left, in the same
    // order.
    const std::string_view order(name + 5, 2);
    const std::string second_row = order == "RG" ? "GB" : order == "GR" ? "BG" : order == "GB" ? "RG" : "GR";
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const char color =
            y % 2 == 0 ? order[static_cast<std::size_t>(x % 2)] : second_row[static_cast<std::size_t>(x % 2)];
        bytes[static_cast<std::size_t>(y * kSize + x)] = color == 'R' ? 200 : color == 'G' ? 120 : 40;
      }
    const Image image = ImageFromBytes(*PixelFormatByName(name), kSize, kSize, bytes.data(), bytes.size());
    const cv::Vec3f center = LinearFloat(image).at<cv::Vec3f>(kSize / 2, kSize / 2);
    EXPECT_NEAR(center[0], 40 / 255.0, 1e-3) << name;
    EXPECT_NEAR(center[1], 120 / 255.0, 1e-3) << name;
    EXPECT_NEAR(center[2], 200 / 255.0, 1e-3) << name;
  }
}

TEST(PixelFormat, TooFewBytesAreAnError) {
  const std::uint8_t bytes[4] = {};
  try {
    ImageFromBytes(*PixelFormatByName("Mono16"), 2, 2, bytes, 4);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("Mono16"));
    EXPECT_THAT(error.what(), HasSubstr("8 bytes"));
  }
}

TEST(PixelFormat, PrefersRawColorAtEightBits) {
  const auto choose = [](std::vector<std::string> offered) {
    const auto format = PreferredPixelFormat(offered);
    return format ? std::string(format->name) : "none";
  };
  EXPECT_EQ(choose({"Mono8", "RGB8", "BayerRG8", "BayerRG12"}), "BayerRG8");
  EXPECT_EQ(choose({"Mono8", "Mono16", "RGB8Packed"}), "RGB8");
  EXPECT_EQ(choose({"Mono16", "Mono8"}), "Mono8");
  EXPECT_EQ(choose({"Mono12p", "Mono12", "Mono10"}), "Mono12");
  EXPECT_EQ(choose({"YUV422_8"}), "none");
}

}  // namespace
}  // namespace ulf
