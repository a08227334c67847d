// Tests: core/frames/pixel_format, core/image/files/jpeg_codec.
#include "core/frames/pixel_format.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <set>

#include "core/base/error.h"

namespace ulf::pixel_format_test {
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

// GenICam's name of a mosaic holds its first row's colours.
Mosaic MosaicByName(std::string_view name) {
  for (const auto& [start, mosaic] : std::map<std::string_view, Mosaic>{{"BayerGR", Mosaic::kGrbg},
                                                                        {"BayerRG", Mosaic::kRggb},
                                                                        {"BayerGB", Mosaic::kGbrg},
                                                                        {"BayerBG", Mosaic::kBggr}})
    if (name.starts_with(start)) return mosaic;
  return Mosaic::kNone;
}

TEST(PixelFormat, NumbersAndNamesAreOfOnePiece) {
  std::set<std::uint32_t> codes;
  for (const PixelFormat& format : AllFormats()) {
    if (format.code == 0) continue;
    EXPECT_TRUE(codes.insert(format.code).second) << format.name;
    EXPECT_EQ(PixelFormatByCode(format.code)->name, format.name);
    // PFNC: the top byte says mono or colour, the next the bits that a pixel takes.
    EXPECT_EQ(format.code >> 24, format.channels == 1 ? 1u : 2u) << format.name;
    int taken = (format.bits > 8 ? 16 : 8) * format.channels;
    if (format.packing == PixelPacking::kLsbPacked) taken = format.bits;
    if (format.packing == PixelPacking::kGvspPacked) taken = 12;
    if (format.packing == PixelPacking::kYuyv || format.packing == PixelPacking::kUyvy) taken = 16;
    EXPECT_EQ(static_cast<int>(format.code >> 16 & 0xFF), taken) << format.name;
    EXPECT_EQ(MosaicByName(format.name), format.mosaic) << format.name;
    EXPECT_EQ(format.name.ends_with("p"), format.packing == PixelPacking::kLsbPacked) << format.name;
  }
  EXPECT_FALSE(PixelFormatByName("RGB10p32"));
  EXPECT_FALSE(PixelFormatByCode(0x0220001D));
  EXPECT_FALSE(PixelFormatByCode(0)) << "what has no number is not found by it";
}

// The numbers as the convention lists them.
TEST(PixelFormat, NumbersAreThoseOfTheConvention) {
  const std::map<std::string, std::uint32_t> listed = {{"Mono8", 0x01080001},
                                                       {"Mono10", 0x01100003},
                                                       {"Mono10p", 0x010A0046},
                                                       {"Mono12", 0x01100005},
                                                       {"Mono12p", 0x010C0047},
                                                       {"Mono14", 0x01100025},
                                                       {"Mono16", 0x01100007},
                                                       {"Mono10Packed", 0x010C0004},
                                                       {"Mono12Packed", 0x010C0006},
                                                       {"BayerGR8", 0x01080008},
                                                       {"BayerRG8", 0x01080009},
                                                       {"BayerGB8", 0x0108000A},
                                                       {"BayerBG8", 0x0108000B},
                                                       {"BayerGR10", 0x0110000C},
                                                       {"BayerRG10", 0x0110000D},
                                                       {"BayerGB10", 0x0110000E},
                                                       {"BayerBG10", 0x0110000F},
                                                       {"BayerGR12", 0x01100010},
                                                       {"BayerRG12", 0x01100011},
                                                       {"BayerGB12", 0x01100012},
                                                       {"BayerBG12", 0x01100013},
                                                       {"BayerGR14", 0x01100109},
                                                       {"BayerRG14", 0x0110010A},
                                                       {"BayerGB14", 0x0110010B},
                                                       {"BayerBG14", 0x0110010C},
                                                       {"BayerGR16", 0x0110002E},
                                                       {"BayerRG16", 0x0110002F},
                                                       {"BayerGB16", 0x01100030},
                                                       {"BayerBG16", 0x01100031},
                                                       {"BayerBG10p", 0x010A0052},
                                                       {"BayerGB10p", 0x010A0054},
                                                       {"BayerGR10p", 0x010A0056},
                                                       {"BayerRG10p", 0x010A0058},
                                                       {"BayerBG12p", 0x010C0053},
                                                       {"BayerGB12p", 0x010C0055},
                                                       {"BayerGR12p", 0x010C0057},
                                                       {"BayerRG12p", 0x010C0059},
                                                       {"BayerGR10Packed", 0x010C0026},
                                                       {"BayerRG10Packed", 0x010C0027},
                                                       {"BayerGB10Packed", 0x010C0028},
                                                       {"BayerBG10Packed", 0x010C0029},
                                                       {"BayerGR12Packed", 0x010C002A},
                                                       {"BayerRG12Packed", 0x010C002B},
                                                       {"BayerGB12Packed", 0x010C002C},
                                                       {"BayerBG12Packed", 0x010C002D},
                                                       {"RGB8", 0x02180014},
                                                       {"BGR8", 0x02180015},
                                                       {"YUV422_8", 0x02100032},
                                                       {"YUV422_8_UYVY", 0x0210001F},
                                                       {"YCbCr422_8", 0x0210003B},
                                                       {"YCbCr601_422_8", 0x0210003E},
                                                       {"YCbCr709_422_8", 0x02100041}};
  for (const auto& [name, code] : listed) {
    ASSERT_TRUE(PixelFormatByName(name)) << name;
    EXPECT_EQ(PixelFormatByName(name)->code, code) << name;
  }
}

TEST(PixelFormat, UnpacksEverySingleChannelFormat) {
  std::mt19937 random(3);
  for (const PixelFormat& format : AllFormats()) {
    if (format.channels != 1) continue;
    for (const int width : {2, 4, 5, 8, 31, 96, 257}) {
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

// Bytes worked out by hand from the drawings of the standards: three pixels 0x123, 0x456, 0x789 (0x2BC,
// 0x155, 0x0F3 in 10 bits) in each packing.
TEST(PixelFormat, PackingsAgreeWithBytesWorkedOutByHand) {
  const auto values_of = [](const char* name, std::vector<std::uint8_t> bytes, int shift) {
    const Image image = ImageFromBytes(*PixelFormatByName(name), 3, 1, bytes.data(), bytes.size());
    std::vector<int> values;
    for (int x = 0; x < 3; ++x) values.push_back(image.pixels.at<std::uint16_t>(0, x) >> shift);
    return values;
  };
  const std::vector<int> twelve{0x123, 0x456, 0x789}, ten{0x2BC, 0x155, 0x0F3};
  EXPECT_EQ(values_of("Mono12p", {0x23, 0x61, 0x45, 0x89, 0x07}, 4), twelve);
  EXPECT_EQ(values_of("Mono12Packed", {0x12, 0x63, 0x45, 0x78, 0x09}, 4), twelve);
  EXPECT_EQ(values_of("Mono12", {0x23, 0x01, 0x56, 0x04, 0x89, 0x07}, 4), twelve);
  EXPECT_EQ(values_of("Mono10p", {0xBC, 0x56, 0x35, 0x0F}, 6), ten);
  EXPECT_EQ(values_of("Mono10Packed", {0xAF, 0x10, 0x55, 0x3C, 0x03}, 6), ten);
  EXPECT_EQ(values_of("Mono10", {0xBC, 0x02, 0x55, 0x01, 0xF3, 0x00}, 6), ten);
}

TEST(PixelFormat, RowsMayBePadded) {
  std::vector<std::uint8_t> bytes(64, 0xEE);
  constexpr int kWidth = 5, kHeight = 3;
  for (const char* name : {"Mono8", "Mono12p", "Mono12Packed", "Mono16"}) {
    const PixelFormat format = *PixelFormatByName(name);
    std::vector<std::uint32_t> values;
    for (std::uint32_t x = 0; x < kWidth; ++x) values.push_back(x * 40 + 7);
    const auto row = Pack(format, values);
    const std::size_t stride = row.size() + 3;
    for (std::size_t y = 0; y < kHeight; ++y)
      std::copy(row.begin(), row.end(), bytes.begin() + static_cast<std::ptrdiff_t>(y * stride));
    const Image image = ImageFromBytes(format, kWidth, kHeight, bytes.data(),
                                       stride * (kHeight - 1) + row.size(), {.row_bytes = stride});
    const Image one = ImageFromBytes(format, kWidth, 1, row.data(), row.size());
    for (int y = 0; y < kHeight; ++y)
      EXPECT_EQ(cv::norm(image.pixels.row(y), one.pixels, cv::NORM_INF), 0) << name << " row " << y;
    EXPECT_THROW(ImageFromBytes(format, kWidth, kHeight, bytes.data(),
                                stride * (kHeight - 1) + row.size() - 1, {.row_bytes = stride}),
                 Error)
        << name;
  }
}

// What a colour is in luma and chroma, by the definition: Y = kr R + (1 - kr - kb) G + kb B,
// U = (B - Y) / (2 (1 - kb)), V = (R - Y) / (2 (1 - kr)), quantised.
std::array<std::uint8_t, 3> YuvOf(cv::Vec3b bgr, double kr, double kb, bool full) {
  const double b = bgr[0] / 255.0, g = bgr[1] / 255.0, r = bgr[2] / 255.0;
  const double y = kr * r + (1 - kr - kb) * g + kb * b;
  const double u = (b - y) / (2 * (1 - kb)), v = (r - y) / (2 * (1 - kr));
  const auto level = [](double value) { return static_cast<std::uint8_t>(std::lround(value)); };
  if (full)
    return {level(255 * y), level(std::min(255.0, 128 + 255 * u)), level(std::min(255.0, 128 + 255 * v))};
  return {level(16 + 219 * y), level(128 + 224 * u), level(128 + 224 * v)};
}

TEST(PixelFormat, LumaAndChromaGiveTheColorsBack) {
  struct Case {
    const char* name;
    double kr, kb;
    YuvEncoding encoding;
  };
  std::vector<Case> cases;
  for (const char* name : {"YUYV", "UYVY", "NV12"})
    for (const bool full : {false, true}) {
      cases.push_back({name, 0.299, 0.114, {YuvMatrix::kBt601, full}});
      cases.push_back({name, 0.2126, 0.0722, {YuvMatrix::kBt709, full}});
      cases.push_back({name, 0.2627, 0.0593, {YuvMatrix::kBt2020, full}});
    }
  const std::array<cv::Vec3b, 8> colors{cv::Vec3b{0, 0, 0}, {255, 255, 255}, {20, 30, 200}, {200, 120, 10},
                                        {90, 90, 90},       {10, 220, 60},   {255, 0, 0},   {0, 0, 255}};
  constexpr int kWidth = 16, kHeight = 2, kStride = 20;
  for (const Case& one : cases) {
    const PixelFormat format = *PixelFormatByName(one.name);
    std::vector<std::uint8_t> bytes(kStride * 2 * kHeight * 2, 0);
    const bool is_nv12 = format.packing == PixelPacking::kNv12;
    const int stride = is_nv12 ? kStride : 2 * kStride;
    for (int y = 0; y < kHeight; ++y)
      for (int pair = 0; pair < kWidth / 2; ++pair) {
        const auto yuv =
            YuvOf(colors[static_cast<std::size_t>(pair)], one.kr, one.kb, one.encoding.full_range);
        std::uint8_t* at = &bytes[static_cast<std::size_t>(y * stride + pair * (is_nv12 ? 2 : 4))];
        if (is_nv12) {
          at[0] = at[1] = yuv[0];
          std::uint8_t* uv = &bytes[static_cast<std::size_t>((kHeight + y / 2) * stride + 2 * pair)];
          uv[0] = yuv[1], uv[1] = yuv[2];
        } else {
          const int luma = std::string(one.name) == "YUYV" ? 0 : 1;
          at[luma] = at[luma + 2] = yuv[0];
          at[1 - luma] = yuv[1], at[3 - luma] = yuv[2];
        }
      }
    const Image image = ImageFromBytes(format, kWidth, kHeight, bytes.data(), bytes.size(),
                                       {.row_bytes = static_cast<std::size_t>(stride), .yuv = one.encoding});
    EXPECT_EQ(image.transfer, Transfer::kSrgb);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(image.pixels.at<cv::Vec3b>(y, x)[c], colors[static_cast<std::size_t>(x / 2)][c], 3)
              << one.name << (one.encoding.full_range ? " full" : " limited") << " kr " << one.kr << " at "
              << x << "," << y << " channel " << c;
  }
}

// The convention's 4:2:2 formats carry their own meaning: 128 grey is grey in all, white is 255 where all
// levels are used and 235 where they are not.
TEST(PixelFormat, ConventionsYuvKnowsItsRange) {
  const std::array<std::uint8_t, 4> yuyv{235, 128, 255, 128};
  const auto first = [&](const char* name) {
    const auto format = *PixelFormatByName(name);
    std::array<std::uint8_t, 4> bytes = yuyv;
    if (format.packing == PixelPacking::kUyvy) bytes = {yuyv[1], yuyv[0], yuyv[3], yuyv[2]};
    const Image image = ImageFromBytes(format, 2, 1, bytes.data(), 4);
    return std::pair<int, int>(image.pixels.at<cv::Vec3b>(0, 0)[1], image.pixels.at<cv::Vec3b>(0, 1)[1]);
  };
  for (const char* name : {"YUV422_8", "YUV422_8_UYVY", "YCbCr422_8", "YCbCr422_8_CbYCrY"})
    EXPECT_EQ(first(name), std::make_pair(235, 255)) << name;
  for (const char* name :
       {"YCbCr601_422_8", "YCbCr601_422_8_CbYCrY", "YCbCr709_422_8", "YCbCr709_422_8_CbYCrY", "YUYV", "UYVY"})
    EXPECT_EQ(first(name), std::make_pair(255, 255)) << name;
}

// What a lost USB packet leaves: nothing marks it but that the data end before the picture does. Bytes that
// fill up before the end marker, as many webcams leave them, are no damage.
TEST(PixelFormat, AHoleInAJpegIsDamageAndFillingIsNot) {
  cv::Mat picture(240, 320, CV_8UC3);
  cv::RNG random(1);
  for (int i = 0; i < 300; ++i)
    picture(cv::Rect(random.uniform(0, 280), random.uniform(0, 210), 40, 30))
        .setTo(cv::Scalar(random.uniform(0, 256), random.uniform(0, 256), random.uniform(0, 256)));
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg);
  const PixelFormat format = *PixelFormatByName("MJPEG");
  const Image whole = ImageFromBytes(format, 320, 240, jpeg.data(), jpeg.size());
  EXPECT_EQ(cv::norm(whole.pixels, cv::imdecode(jpeg, cv::IMREAD_COLOR), cv::NORM_INF), 0);
  for (int at = 700; at + 600 < static_cast<int>(jpeg.size()); at += 997) {
    std::vector<std::uint8_t> holed = jpeg;
    holed.erase(holed.begin() + at, holed.begin() + at + 500);
    EXPECT_THROW(ImageFromBytes(format, 320, 240, holed.data(), holed.size()), Error) << "from byte " << at;
  }
  for (const std::size_t count : {1u, 9u}) {
    std::vector<std::uint8_t> filled = jpeg;
    filled.insert(filled.end() - 2, count, 0x55);
    const Image image = ImageFromBytes(format, 320, 240, filled.data(), filled.size());
    EXPECT_EQ(cv::norm(image.pixels, whole.pixels, cv::NORM_INF), 0) << count;
  }
}

TEST(PixelFormat, MotionJpegIsDecodedAndChecked) {
  cv::Mat picture(48, 64, CV_8UC3, cv::Scalar(40, 90, 200));
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});
  const PixelFormat format = *PixelFormatByName("MJPEG");
  const Image image = ImageFromBytes(format, 64, 48, jpeg.data(), jpeg.size());
  EXPECT_EQ(image.transfer, Transfer::kSrgb);
  EXPECT_LE(cv::norm(image.pixels, picture, cv::NORM_INF), 4);
  EXPECT_THROW(ImageFromBytes(format, 64, 64, jpeg.data(), jpeg.size()), Error) << "another size";
  const std::vector<std::uint8_t> noise(500, 0x5A);
  EXPECT_THROW(ImageFromBytes(format, 64, 48, noise.data(), noise.size()), Error) << "no JPEG";
}

TEST(PixelFormat, OddSizesOfSharedColorsAreRefused) {
  const std::vector<std::uint8_t> bytes(100, 0);
  EXPECT_THROW(ImageFromBytes(*PixelFormatByName("YUYV"), 5, 2, bytes.data(), 100), Error);
  EXPECT_THROW(ImageFromBytes(*PixelFormatByName("NV12"), 4, 3, bytes.data(), 100), Error);
}

TEST(PixelFormat, TooFewBytesAreAnError) {
  const std::uint8_t bytes[4] = {};
  EXPECT_THAT([&] { ImageFromBytes(*PixelFormatByName("Mono16"), 2, 2, bytes, 4); },
              testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr("Mono16"), HasSubstr("8 bytes"))))
      << "no error";
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
  EXPECT_EQ(choose({"Mono8", "YUV422_8", "MJPEG", "NV12"}), "YUV422_8");
  EXPECT_EQ(choose({"Mono8", "MJPEG", "NV12"}), "NV12");
  EXPECT_EQ(choose({"Coord3D_ABC32f"}), "none");
}

}  // namespace
}  // namespace ulf::pixel_format_test
