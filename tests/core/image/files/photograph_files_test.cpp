// Tests: core/image/files/image_header, core/image/files/exr_file, core/image/files/exr_header,
// core/image/files/exif.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/base/error.h"
#include "core/image/files/exif.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/exr_header.h"
#include "core/image/files/image_header.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "tests/support/test_paths.h"

namespace ulf::test::photograph_files_test {
namespace {

void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string Encoded(const char* ending, const cv::Mat& pixels) {
  std::vector<unsigned char> bytes;
  cv::imencode(ending, pixels, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(ExrFile, KeepsLinearLightAndRefusesATruncatedFile) {
  const ScratchFolder folder;
  cv::Mat bgr(3, 5, CV_32FC3);
  cv::randu(bgr, 0, 30000);
  bgr.at<cv::Vec3f>(1, 1)[2] = std::numeric_limits<float>::infinity();
  const std::string bytes = ExrBytes({{"B", bgr, 0}, {"G", bgr, 1}, {"R", bgr, 2}}, ExrCompression::kZip);
  const auto path = folder / "light.exr";
  WriteBytes(path, bytes);
  const cv::Mat read = ReadExr(path.string());
  ASSERT_EQ(read.size(), bgr.size());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(read.at<cv::Vec3f>(2, 4)[i], bgr.at<cv::Vec3f>(2, 4)[i]);
  EXPECT_TRUE(std::isinf(read.at<cv::Vec3f>(1, 1)[2]));
  WriteBytes(path, bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(ReadExr(path.string()), Error);
}

TEST(ExrFile, HalfFloatsBeyondTheirRangeAreTheLargest) {
  const cv::Mat half = HalfFromFloat(cv::Mat(1, 1, CV_32FC1, cv::Scalar(1e6)));
  cv::Mat back;
  half.convertTo(back, CV_32F);
  EXPECT_EQ(back.at<float>(0), 65504);
}

TEST(ImageHeader, IsReadFromTheFirstBytes) {
  const ScratchFolder folder;
  const cv::Mat grey16(48, 64, CV_16UC1, cv::Scalar(7)), bgra(48, 64, CV_8UC4, cv::Scalar(1, 2, 3, 4));
  WriteBytes(folder / "grey.png", Encoded(".png", grey16));
  WriteBytes(folder / "alpha.png", Encoded(".png", bgra));
  WriteBytes(folder / "colour.jpg", Encoded(".jpg", cv::Mat(48, 64, CV_8UC3)));
  const auto grey = ReadImageHeader((folder / "grey.png").string());
  ASSERT_TRUE(grey);
  EXPECT_EQ(grey->bits, 16);
  EXPECT_EQ(grey->channels, 1);
  EXPECT_FALSE(grey->alpha);
  const auto alpha = ReadImageHeader((folder / "alpha.png").string());
  ASSERT_TRUE(alpha);
  EXPECT_TRUE(alpha->alpha);
  const auto colour = ReadImageHeader((folder / "colour.jpg").string());
  ASSERT_TRUE(colour);
  EXPECT_EQ(colour->Text(), "JPEG 64x48, 3 channels of 8 bits");
  WriteBytes(folder / "cut.png", Encoded(".png", grey16).substr(0, 20));
  EXPECT_FALSE(ReadImageHeader((folder / "cut.png").string()));
  EXPECT_FALSE(ReadImageHeader((folder / "missing.png").string()));
}

TEST(ImageHeader, IsReadFromTiffOfBothByteOrders) {
  const ScratchFolder folder;
  const auto little = folder / "little.tiff", big = folder / "big.tiff";
  WriteBytes(little, Encoded(".tiff", cv::Mat(48, 64, CV_16UC3, cv::Scalar::all(7))));
  const auto header = ReadImageHeader(little.string());
  ASSERT_TRUE(header);
  EXPECT_EQ(header->Text(), "TIFF 64x48, 3 channels of 16 bits");
  // One entry each of width and height, and no others: a big-endian file as short as can be.
  const std::string entries(
      "\0\2"
      "\1\0\0\3\0\0\0\1\0\5\0\0"
      "\1\1\0\4\0\0\0\1\0\0\0\4"
      "\0\0\0\0",
      30);
  WriteBytes(big, std::string("MM\0*\0\0\0\10", 8) + entries);
  const auto other = ReadImageHeader(big.string());
  ASSERT_TRUE(other);
  EXPECT_EQ(other->width, 5);
  EXPECT_EQ(other->height, 4);
  WriteBytes(big, std::string("MM\0*\0\0\0\10", 8) + entries.substr(0, 20));
  EXPECT_FALSE(ReadImageHeader(big.string()));
}

// The least side of a square picture whose pixels are more than small files may stand for
// (RequirePixelsOfFile).
int SideTooLarge(int bytes_of_pixel) {
  constexpr double kGranted = 256e6;
  return static_cast<int>(std::sqrt(kGranted / bytes_of_pixel)) + 1;
}

std::string Number(int value, int bytes, bool big_endian) {
  std::string text;
  for (int i = 0; i < bytes; ++i)
    text += static_cast<char>(value >> (8 * (big_endian ? bytes - 1 - i : i)) & 0xFF);
  return text;
}

// Files of a few bytes that say that they hold one row and column too many are refused by their headers.
class LyingSize : public testing::Test {
 protected:
  void ExpectRefused(const char* name, const std::string& bytes) const {
    const auto path = folder_ / name;
    WriteBytes(path, bytes);
    EXPECT_THAT([&] { ReadImageFile(path.string()); },
                testing::ThrowsMessage<Error>(testing::AllOf(testing::HasSubstr(path.string()),
                                                             testing::HasSubstr("do not fit into"))));
  }
  ScratchFolder folder_;
};

TEST_F(LyingSize, IsRefusedInPng) {
  std::string png = Encoded(".png", cv::Mat(48, 64, CV_16UC3));
  const std::string side = Number(SideTooLarge(6), 4, true);
  png.replace(16, 8, side + side);
  ExpectRefused("a.png", png);
}

TEST_F(LyingSize, IsRefusedInJpeg) {
  std::string jpeg = Encoded(".jpg", cv::Mat(48, 64, CV_8UC3));
  const std::size_t size = jpeg.find(std::string("\x08\0\x30\0\x40", 5));
  ASSERT_NE(size, std::string::npos);
  const std::string side = Number(SideTooLarge(3), 2, true);
  jpeg.replace(size + 1, 4, side + side);
  ExpectRefused("a.jpg", jpeg);
  EXPECT_TRUE(DecodeJpeg(jpeg).empty());
}

TEST_F(LyingSize, IsRefusedInTiff) {
  std::string tiff = Encoded(".tiff", cv::Mat(48, 64, CV_16UC3));
  for (const std::string& tag : {std::string("\0\1\4\0", 4), std::string("\1\1\4\0", 4),
                                 std::string("\0\1\3\0", 4), std::string("\1\1\3\0", 4)})
    if (const std::size_t at = tiff.rfind(tag); at != std::string::npos)
      tiff.replace(at + 8, 2, Number(SideTooLarge(6), 2, false));
  ExpectRefused("a.tiff", tiff);
}

TEST(TiffPhotograph, SizesOfAnyWholeNumberAreRead) {
  const ScratchFolder folder;
  const std::string path = (folder / "a.tiff").string(), tiff = Encoded(".tiff", cv::Mat(48, 64, CV_8UC3));
  for (const char type : {1, 3, 4, 6, 8, 9, 13}) {
    std::string other = tiff;
    for (const char tag : {0, 1})
      for (const char written : {3, 4})
        if (const std::size_t at = tiff.rfind(std::string({tag, 1, written, 0})); at != std::string::npos) {
          other[at + 2] = type;
          // What a shorter number leaves of the four bytes means nothing.
          if (type == 1 || type == 6) other.replace(at + 9, 3, "\7\7\7");
          if (type == 3 || type == 8) other.replace(at + 10, 2, "\7\7");
        }
    WriteBytes(path, other);
    EXPECT_EQ(ReadImageSize(path), cv::Size(64, 48)) << static_cast<int>(type);
  }
}

TEST_F(LyingSize, IsRefusedInExr) {
  cv::Mat bgr(3, 5, CV_32FC3, cv::Scalar::all(1));
  std::string exr = ExrBytes({{"B", bgr, 0}, {"G", bgr, 1}, {"R", bgr, 2}}, ExrCompression::kZip);
  for (const std::string window : {"dataWindow", "displayWindow"}) {
    const std::size_t at = exr.find(window) + window.size() + 1 + 6 + 4 + 8;  // type, size, the first corner
    const std::string last = Number(SideTooLarge(12) - 1, 4, false);
    exr.replace(at, 8, last + last);
  }
  exr +=
      std::string(8 * static_cast<std::size_t>(SideTooLarge(12)), '\0');  // room for the places of its lines
  ExpectRefused("a.exr", exr);
  EXPECT_THROW(ReadExrChannel((folder_ / "a.exr").string(), "R"), Error);
}

TEST_F(LyingSize, IsRefusedInRarerKinds) {
  const cv::Mat pixels(48, 64, CV_8UC3, cv::Scalar(10, 120, 200));
  const auto read = [&](const char* name, const std::string& bytes) {
    WriteBytes(folder_ / name, bytes);
    EXPECT_EQ(ReadImageFile((folder_ / name).string()).size(), pixels.size()) << name;
    std::istringstream stream(bytes);
    EXPECT_EQ(ClaimedSize(stream), cv::Size2d(64, 48)) << name;
  };
  const auto with = [](std::string bytes, std::size_t at, std::string_view lie) {
    return bytes.replace(at, lie.size(), lie);
  };
  const int side = SideTooLarge(6);
  const std::string wide = std::to_string(side), sides = Number(side, 4, false) + Number(side, 4, false),
                    from_the_top = Number(side, 4, false) + Number(-side, 4, false);
  const std::string bmp = Encoded(".bmp", pixels), ppm = Encoded(".ppm", pixels),
                    hdr = Encoded(".hdr", pixels);
  read("a.bmp", bmp);
  ExpectRefused("a.bmp", with(bmp, 18, sides));
  ExpectRefused("a.bmp", with(bmp, 18, from_the_top));
  read("a.ppm", ppm);
  const std::string behind_size = ppm.substr(ppm.find("255"));
  read("a.ppm", "P6\n# made by hand\n64 # wide\n48\n" + behind_size);
  read("a.ppm", "P6 64#wide\n48#high\r255#most\n" + ppm.substr(ppm.find("255") + 4));
  ExpectRefused("a.ppm", "P6\n# made by hand\n" + wide + " # wide\n" + wide + "\n" + behind_size);
  ExpectRefused("a.ppm",
                "P6\n#\r" + wide + " " + wide + " 255 \n1 1 255");  // a comment ends at either line end
  WriteBytes(folder_ / "a.ppm", "P6 64.48 1\n255\n");
  EXPECT_THROW(ReadImageFile((folder_ / "a.ppm").string()), Error);
  std::istringstream fraction("P6 64.48 1\n255\n"),
      long_line("#?RADIANCE\n#" + std::string(127, 'x') + "\n\n-Y 1 +X 1\n" + std::string(32, ' '));
  EXPECT_FALSE(ClaimedSize(fraction));
  std::istringstream size_on_two_lines("#?RADIANCE\n\n-Y 3 +X\n8\n");
  EXPECT_FALSE(ClaimedSize(size_on_two_lines));
  EXPECT_FALSE(ClaimedSize(long_line)) << "OpenCV reads another size behind it";
  read("a.hdr", hdr);
  const std::size_t size_line = hdr.find("-Y 48 +X 64");
  ASSERT_NE(size_line, std::string::npos);
  ExpectRefused("a.hdr",
                hdr.substr(0, size_line) + "-Y " + wide + " +X " + wide + hdr.substr(size_line + 11));
  for (const int quality : {90, 101}) {  // above 100: lossless
    std::vector<unsigned char> encoded;
    cv::imencode(".webp", pixels, encoded, {cv::IMWRITE_WEBP_QUALITY, quality});
    const std::string webp(encoded.begin(), encoded.end());
    read("a.webp", webp);
    const int least_one = side - 1;  // as the lossless kind counts, in 14 bits each
    ExpectRefused("a.webp", quality > 100 ? with(webp, 21, Number(least_one << 14 | least_one, 4, false))
                                          : with(webp, 26, Number(side << 16 | side, 4, false)));
  }
}

TEST(JpegFile, AllowsFillBytesBetweenSegments) {
  const ScratchFolder folder;
  std::string jpeg = Encoded(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 120, 200)));
  const std::size_t tables = jpeg.find("\xFF\xDB");
  ASSERT_NE(tables, std::string::npos);
  WriteBytes(folder / "a.jpg", jpeg.insert(tables, std::string(2, '\0')));
  EXPECT_EQ(ReadImageFile((folder / "a.jpg").string()).size(), cv::Size(64, 48));
}

TEST(ImageFile, RefusesKindsThatHoldNoPhotographs) {
  const ScratchFolder folder;
  const auto path = folder / "a.png";
  WriteBytes(path, Encoded(".ras", cv::Mat(48, 64, CV_8UC3)));
  EXPECT_THAT([&] { ReadImageFile(path.string()); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("cannot be decoded")));
}

// What the library would follow, whatever the length that stands beside it.
TEST(ExrHeader, RefusesAttributesOfAWrongLength) {
  const ScratchFolder folder;
  const cv::Mat bgr(3, 5, CV_32FC3, cv::Scalar::all(1));
  const std::string exr = ExrBytes({{"B", bgr, 0}, {"G", bgr, 1}, {"R", bgr, 2}}, ExrCompression::kZip);
  const auto path = folder / "a.exr";
  const auto number = [](std::uint32_t n) {
    return std::string(reinterpret_cast<const char*>(&n), sizeof n);
  };
  const auto with = [&](const std::string& type, const std::string& value, std::uint32_t length) {
    std::string bytes = exr;
    WriteBytes(path, bytes.insert(8, "more" + std::string(1, '\0') + type + std::string(1, '\0') +
                                         number(length) + value));
  };
  const auto with_value = [&](const std::string& type, const std::string& value) {
    with(type, value, static_cast<std::uint32_t>(value.size()));
  };
  const auto refused = testing::Throws<Error>(testing::Property(
      &Error::what,
      testing::AllOf(testing::HasSubstr(path.string()), testing::HasSubstr("attribute of its header"))));
  const std::string preview = number(2) + number(1) + std::string(8, 'p'), strings = number(3) + "abc";
  for (const auto& [type, value] : std::map<std::string, std::string>{{"preview", preview},
                                                                      {"stringvector", strings + strings},
                                                                      {"floatvector", number(0)},
                                                                      {"v2f", number(0) + number(0)},
                                                                      {"of others", "anything"}}) {
    with_value(type, value);
    EXPECT_NO_THROW(ExrAttribute(path.string(), "more")) << type;
    // One byte more than there is behind it.
    const std::size_t rest = value.size() + exr.size() - 8;
    with(type, value, static_cast<std::uint32_t>(rest + 1));
    EXPECT_THAT([&] { ReadExr(path.string()); }, refused) << type;
  }
  for (const auto& [type, value] :
       std::map<std::string, std::string>{{"preview", preview.substr(0, preview.size() - 4)},
                                          {"stringvector", number(4) + "abc"},
                                          {"floatvector", "abc"},
                                          {"chlist", std::string("B\0", 2) + std::string(16, '\0')},
                                          {"v2f", number(0)}}) {
    with_value(type, value);
    EXPECT_THAT([&] { ReadExr(path.string()); }, refused) << type;
    EXPECT_THAT([&] { ReadExrChannel(path.string(), "R"); }, refused) << type;
    EXPECT_THAT([&] { ExrColorsOf(path.string()); }, refused) << type;
    EXPECT_THAT([&] { ExrAttribute(path.string(), "more"); }, refused) << type;
  }
  with_value("tiledesc", number(4097) + number(4096) + std::string(1, '\0'));
  EXPECT_THAT([&] { RequireExrHeader(path.string()); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("million pixels in a picture of 5x3")));
  WriteBytes(path, exr.substr(0, 60));
  EXPECT_THROW(RequireExrHeader(path.string()), Error);
  WriteBytes(path, "another kind of file");
  EXPECT_NO_THROW(RequireExrHeader(path.string()));
}

TEST(JpegFile, IsDecodedWholeOrNotAtAll) {
  cv::Mat pixels(48, 64, CV_8UC3);
  cv::randu(pixels, 0, 255);
  const std::string bytes = Encoded(".jpg", pixels);
  EXPECT_EQ(DecodeJpeg(bytes).size(), pixels.size());
  EXPECT_TRUE(DecodeJpeg(bytes.substr(0, bytes.size() / 2)).empty());
  EXPECT_TRUE(DecodeJpeg("no picture").empty());
  EXPECT_FALSE(ReadExif(bytes).exposure_s) << "there is no Exif";
  EXPECT_EQ(ReadExif(bytes).orientation, 1);
}

}  // namespace
}  // namespace ulf::test::photograph_files_test
