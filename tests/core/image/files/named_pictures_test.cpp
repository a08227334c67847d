// Tests: core/image/files/float_numbers, core/image/files/picture_projection, core/image/files/picture_folder, core/image/files/picture_kind, core/image/files/tiff_numbers.
//
// Pictures that are valid and do not mean what their pixels seem to: what is doubtful is named, what no lens made is refused.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tuple>

#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/webp_picture.h"
#include "tests/support/pictures/sample_exr.h"
#include "tests/support/pictures/sample_pictures.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class NamedPictures : public testing::Test {
 protected:
  std::string In(const std::string& name) const { return (folder_ / name).string(); }
  std::filesystem::path Folder() const { return folder_.path(); }
  void Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(In(name), std::ios::binary) << bytes;
  }
  // One channel or three of CV_32F, by the ending of the name.
  void WriteFloats(const std::string& name, const cv::Mat& pixels, const ExrColors& colors = {}) const {
    if (name.ends_with(".exr"))
      return Write(name, ExrBytes({{"B", pixels, 0}, {"G", pixels, 1}, {"R", pixels, 2}},
                                  ExrCompression::kZip, colors));
    std::vector<unsigned char> bytes;
    constexpr int kLzw = 5;  // without it the library writes LogLuv
    cv::imencode(
        std::filesystem::path(name).extension().string(), pixels, bytes,
        name.ends_with(".tif") ? std::vector<int>{cv::IMWRITE_TIFF_COMPRESSION, kLzw} : std::vector<int>{});
    Write(name, {bytes.begin(), bytes.end()});
  }
  void ExpectRefused(const std::string& name, const std::string& words) const {
    EXPECT_THAT([&] { ReadPicture(In(name)); },
                testing::ThrowsMessage<Error>(AllOf(HasSubstr(In(name)), HasSubstr(words))))
        << name;
  }

 private:
  const ScratchFolder folder_;
};

cv::Mat Levels(double most) {
  cv::Mat levels(30, 40, CV_32FC3);
  cv::theRNG().state = 5;
  cv::randu(levels, 0, most);
  for (float& number : cv::Mat_<float>(levels.reshape(1))) number = std::floor(number);
  levels.at<cv::Vec3f>(3, 4)[1] = static_cast<float>(most);
  return levels;
}

TEST_F(NamedPictures, FloatsThatAreLevelsAreNamedWithTheLargest) {
  for (const char* name : {"a.tif", "a.exr", "a.pfm", "a.hdr"}) {
    WriteFloats(name, Levels(255));
    EXPECT_THAT(ReadPicture(In(name)).warnings,
                Contains(AllOf(HasSubstr("up to 255"), HasSubstr("8 bits"), HasSubstr("by 255"))))
        << name;
    cv::Mat light = Levels(255) / 255;
    WriteFloats(name, light);
    EXPECT_THAT(ReadPicture(In(name)).warnings, IsEmpty()) << name;
    light *= 40;
    light.rowRange(0, 20).setTo(0);
    WriteFloats(name, light);
    EXPECT_THAT(ReadPicture(In(name)).warnings, IsEmpty()) << "light above full scale in the dark, " << name;
    cv::Mat mask(30, 40, CV_32FC3, cv::Scalar::all(0));
    mask.rowRange(0, 9).setTo(cv::Scalar::all(1));
    WriteFloats(name, mask);
    EXPECT_THAT(ReadPicture(In(name)).warnings, IsEmpty()) << "a mask, " << name;
  }
  for (const char* name : {"a.tif", "a.exr", "a.pfm"}) {
    WriteFloats(name, Levels(65535));
    EXPECT_THAT(ReadPicture(In(name)).warnings,
                Contains(AllOf(HasSubstr("up to 65535"), HasSubstr("16 bits"))))
        << name;
  }
}

// They get no weight where photographs are blended, so they stay what they are, also behind a conversion of colours.
TEST_F(NamedPictures, NumbersThatAreNotFiniteAreCountedAndStay) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInfinity = std::numeric_limits<float>::infinity();
  constexpr std::array<float, 8> kBt2020{0.708F, 0.292F, 0.170F, 0.797F, 0.131F, 0.046F, 0.3127F, 0.3290F};
  cv::Mat light(30, 40, CV_32FC3, cv::Scalar(0.1, 0.2, 0.3));
  light.at<cv::Vec3f>(2, 3) = {kNan, 0.2F, kNan};
  light.at<cv::Vec3f>(5, 7)[1] = -kInfinity;
  WriteFloats("a.tif", light);
  WriteFloats("a.exr", light);
  WriteFloats("a.pfm", light);
  WriteFloats("converted.exr", light, kBt2020);
  for (const char* name : {"a.tif", "a.exr", "a.pfm", "converted.exr"}) {
    const StoredPicture picture = ReadPicture(In(name));
    EXPECT_THAT(picture.warnings, ElementsAre(AllOf(HasSubstr("3 numbers"), HasSubstr("2 NaN, 1 infinite"))))
        << name;
    EXPECT_FALSE(std::isfinite(picture.pixels.at<cv::Vec3f>(2, 3)[0])) << name;
    EXPECT_FALSE(std::isfinite(picture.pixels.at<cv::Vec3f>(5, 7)[1])) << name;
    EXPECT_TRUE(cv::checkRange(picture.pixels.rowRange(8, 30))) << name;
  }
}

std::string Segment(char marker, const std::string& content) {
  const std::size_t size = content.size() + 2;
  return std::string{'\xFF', marker, static_cast<char>(size >> 8), static_cast<char>(size)} + content;
}

std::string XmpSegment(const std::string& properties) {
  return Segment('\xE1', std::string("http://ns.adobe.com/xap/1.0/\0", 29) + properties);
}

const std::string kSphere = "<rdf:Description GPano:ProjectionType=\"equirectangular\"/>",
                  kSphereAsElement = "<a:ProjectionType >\n equirectangular</a:ProjectionType>",
                  kViewer = "<rdf:Description GPano:UsePanoramaViewer='True'/>",
                  kStereo = "<rdf:Description V:StereoMode=\"left-right\"/>",
                  kOrdinary =
                      "<rdf:Description GPano:UsePanoramaViewer=\"False\" V:StereoMode=\"mono\" "
                      "GPano:ProjectionTypes=\"none\" V:ProjectionType=\"perspective\"/>";

TEST_F(NamedPictures, PanoramasAreRefusedByName) {
  const std::string jpeg = JpegBytes(PatchPicture()), png = PngBytes(PatchPicture());
  for (const std::string& xmp : {kSphere, kSphereAsElement, kViewer}) {
    Write("a.jpg", WithSegment(jpeg, XmpSegment(xmp)));
    ExpectRefused("a.jpg", "is a panorama");
    ExpectRefused("a.jpg", "v360");
    Write("a.png", WithPngChunk(png, "iTXt", std::string("XML:com.adobe.xmp\0\0\0\0\0", 22) + xmp));
    ExpectRefused("a.png", "is a panorama");
    WriteTiffSample(In("a.tif"), {.xmp = xmp});
    ExpectRefused("a.tif", "is a panorama");
    Write("a.webp", WithWebpChunk(WebpBytes(PatchPicture(), 100), 4, "XMP ", xmp));
    ExpectRefused("a.webp", "is a panorama");
  }
  WriteExrSample(In("a.exr"), {{.is_panorama = true}});
  ExpectRefused("a.exr", "envmap");
  Write("a.jpg", WithSegment(jpeg, XmpSegment(kOrdinary)));
  EXPECT_LE(LargestPatchError(ReadPicture(In("a.jpg")).pixels), 4);
}

// An index of CIPA DC-007 of two pictures, of which the second is of this kind.
std::string PictureIndex(std::uint32_t kind, bool is_little) {
  const auto number = [&](std::uint32_t value, int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * (is_little ? i : count - 1 - i));
    return bytes;
  };
  const std::string directory = number(2, 2) + number(0xB001, 2) + number(4, 2) + number(1, 4) +
                                number(2, 4) + number(0xB002, 2) + number(7, 2) + number(32, 4) +
                                number(38, 4) + number(0, 4);
  const std::string pictures =
      number(0x030000, 4) + std::string(12, '\0') + number(kind, 4) + std::string(12, '\0');
  return Segment('\xE2', std::string("MPF\0", 4) + (is_little ? "II" : "MM") + number(42, 2) + number(8, 4) +
                             directory + pictures);
}

TEST_F(NamedPictures, StereoPairsAreRefusedAndFurtherPicturesSaid) {
  const std::string jpeg = JpegBytes(PatchPicture());
  Write("xmp.jpg", WithSegment(jpeg, XmpSegment(kStereo)));
  ExpectRefused("xmp.jpg", "stereo pair");
  const std::string side_by_side("\0\x04\0\x04\x02\x01", 6), one_eye("\0\x04\0\0\0\0", 6);
  Write("jps.jpg", WithSegment(jpeg, Segment('\xE3', "_JPSJPS_" + side_by_side)));
  ExpectRefused("jps.jpg", "crop=iw/2");
  Write("mono.jpg", WithSegment(jpeg, Segment('\xE3', "_JPSJPS_" + one_eye)));
  EXPECT_NO_THROW(ReadPicture(In("mono.jpg")));
  Write("plain.JPS", jpeg);
  ExpectRefused("plain.JPS", "stereo pair");
  EXPECT_THAT(UnreadPicture("a.jps").value_or(""), HasSubstr("stereo pair"));
  Write("plain.insp", jpeg);
  ExpectRefused("plain.insp", "two fisheye pictures");
  EXPECT_TRUE(HasImageEnding("a.MPO"));
  for (const bool is_little : {true, false}) {
    Write("two.MPO", WithSegment(jpeg, PictureIndex(0x020003, is_little)) + jpeg);
    const StoredPicture two = ReadPicture(In("two.MPO"));
    EXPECT_THAT(two.notes, Contains(HasSubstr("it holds 2 pictures, of which the first is taken")));
    EXPECT_LE(LargestPatchError(two.pixels), 4);
    Write("preview.jpg", WithSegment(jpeg, PictureIndex(0x010001, is_little)) + jpeg);
    EXPECT_THAT(ReadPicture(In("preview.jpg")).notes, IsEmpty());
    Write("eyes.mpo", WithSegment(jpeg, PictureIndex(0x020002, is_little)) + jpeg);
    ExpectRefused("eyes.mpo", "each picture is for one eye");
  }
}

TEST_F(NamedPictures, PixelsThatAreNotSquareAreNamed) {
  const auto expect = [&](const std::string& name, const std::string& numbers) {
    EXPECT_THAT(ReadPicture(In(name)).warnings,
                ElementsAre(AllOf(HasSubstr("not square"), HasSubstr(numbers))))
        << name;
  };
  std::string jpeg = JpegBytes(PatchPicture());
  const std::size_t unit = jpeg.find(std::string("JFIF\0", 5)) + 7;
  jpeg.replace(unit, 5, std::string("\x01\0\x48\0\x90", 5));
  Write("a.jpg", jpeg);
  expect("a.jpg", "(72 to 144)");
  const std::string png = PngBytes(PatchPicture());
  Write("a.png", WithPngChunk(png, "pHYs", std::string("\0\0\0\x04\0\0\0\x03\0", 9)));
  expect("a.png", "(4 to 3)");
  WriteTiffSample(In("a.tif"), {.across = 204, .down = 98});
  expect("a.tif", "(204 to 98)");
  WriteExrSample(In("a.exr"), {{.pixel_aspect = 2}});
  expect("a.exr", "(1 to 2)");
  Write("square.png", WithPngChunk(png, "pHYs", std::string("\0\0\x0B\x13\0\0\x0B\x12\x01", 9)));
  EXPECT_THAT(ReadPicture(In("square.png")).warnings, IsEmpty()) << "but for rounding";
}

TEST_F(NamedPictures, BitsThatATiffDoesNotUseAreNamedByItsOwnWord) {
  WriteTiffSample(In("a.tif"), {.bits = 16, .most = 4095});
  EXPECT_THAT(ReadPicture(In("a.tif")).warnings,
              ElementsAre(AllOf(HasSubstr("12 bits"), HasSubstr("by 16"))));
  for (const int most : {65535, 40000, 1}) {
    WriteTiffSample(In("a.tif"), {.bits = 16, .most = most});
    EXPECT_THAT(ReadPicture(In("a.tif")).warnings, IsEmpty()) << most;
  }
}

TEST_F(NamedPictures, TheViewsOfAnExrAreSaid) {
  WriteExrSample(In("a.exr"), {{.channels = {"R", "G", "B", "right.R", "right.G", "right.B"},
                                .views = {"left", "right"}}});
  EXPECT_THAT(ReadPicture(In("a.exr")).notes, Contains(HasSubstr("2 views (left, right)")));
}

// A header of version 5, whose profile stands behind the pixels.
TEST_F(NamedPictures, TheProfileOfABmpCounts) {
  const std::string icc = IccProfile("P3");
  const cv::Mat in_p3 = EncodedIn("P3", PatchPicture());
  const auto number = [](std::size_t value, int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i);
    return bytes;
  };
  std::string rows;
  for (int y = in_p3.rows - 1; y >= 0; --y) rows.append(in_p3.ptr<char>(y), 3 * 60);
  constexpr std::size_t kHead = 14, kHeader = 124;
  const std::string header = number(kHeader, 4) + number(60, 4) + number(40, 4) + number(1, 2) +
                             number(24, 2) + number(0, 4) + number(rows.size(), 4) + std::string(32, '\0') +
                             "DEBM" + std::string(48, '\0') + number(4, 4) +
                             number(kHeader + rows.size(), 4) + number(icc.size(), 4) + number(0, 4);
  ASSERT_EQ(header.size(), kHeader);
  Write("a.bmp", "BM" + number(kHead + kHeader + rows.size() + icc.size(), 4) + number(0, 4) +
                     number(kHead + kHeader, 4) + header + rows + icc);
  const StoredPicture picture = ReadPicture(In("a.bmp"));
  EXPECT_LE(LargestPatchError(picture.pixels), 3);
  EXPECT_THAT(picture.notes, ElementsAre(HasSubstr("converted to sRGB")));
}

TEST_F(NamedPictures, AnAnimatedPngIsItsFirstPictureAndNamed) {
  Write("a.png", WithPngChunk(PngBytes(PatchPicture()), "acTL", std::string("\0\0\0\x02\0\0\0\0", 8)));
  const StoredPicture picture = ReadPicture(In("a.png"));
  EXPECT_THAT(picture.warnings, ElementsAre(HasSubstr("animated")));
  EXPECT_LE(LargestPatchError(picture.pixels), 0.01);
}

TEST_F(NamedPictures, WhatAFolderHoldsBesideItsPicturesIsCounted) {
  const std::string jpeg = JpegBytes(PatchPicture());
  for (const char* name : {"b10.jpg", "b9.MPO", "a.PNG"}) Write(name, jpeg);
  for (const char* name : {"notes.txt", "b9.XMP", "Thumbs.db", ".hidden", "._a.jpg"}) Write(name, "words");
  EXPECT_THAT(PicturesIn(Folder()).left_out, IsEmpty());
  Write("telephone", std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(20, '\0'));
  Write("c.HEIC", "heic");
  Write("c", jpeg);
  Write("a.jpg_original", jpeg);
  Write("film.mp4", std::string("\0\0\0\x18", 4) + "ftypmp42" + std::string(20, '\0'));
  std::filesystem::create_directories(Folder() / "more");
  std::filesystem::create_directories(Folder() / "empty");
  Write("more/d.jpg", jpeg);
  const PictureFolder found = PicturesIn(Folder());
  std::vector<std::string> names;
  for (const auto& file : found.pictures) names.push_back(file.filename().string());
  EXPECT_THAT(names, ElementsAre("a.PNG", "b9.MPO", "b10.jpg"));
  EXPECT_THAT(found.left_out,
              testing::UnorderedElementsAre(AllOf(HasSubstr("2 files are HEIC"), HasSubstr("heif-convert")),
                                            AllOf(HasSubstr("2 files are pictures by the first bytes"),
                                                  HasSubstr("(a.jpg_original, c)")),
                                            AllOf(HasSubstr("1 file is no picture"), HasSubstr("(film.mp4)")),
                                            AllOf(HasSubstr("1 folder inside"), HasSubstr("(more)"))));
  EXPECT_THAT(found.LeftOut(), AllOf(HasSubstr("heif-convert"), HasSubstr("film.mp4")));
  EXPECT_EQ(SomeNames({"a", "b", "c", "d"}), "a, b, c, ...");
}

TEST_F(NamedPictures, TheOddOneIsOfTheFewer) {
  using Words = std::vector<std::string>;
  EXPECT_FALSE(OddOneOut(Words{"a", "a"}));
  for (const auto& [words, odd, usual, count] : {std::tuple{Words{"a", "b", "b"}, 0, 1, 2},
                                                 {Words{"b", "b", "a"}, 2, 0, 2},
                                                 {Words{"a", "b"}, 1, 0, 1}}) {
    const auto found = OddOneOut(words);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->odd, static_cast<std::size_t>(odd));
    EXPECT_EQ(found->usual, static_cast<std::size_t>(usual));
    EXPECT_EQ(found->usual_count, static_cast<std::size_t>(count));
  }
}

// Numbers as published for D50 (Bradford), and for the white D65 of sRGB itself.
TEST_F(NamedPictures, LabIsSeenUnderItsOwnWhite) {
  struct Patch {
    std::array<double, 3> lab;
    std::array<int, 3> rgb;
  };
  const std::vector<Patch> under_d50{{{100, 0, 0}, {255, 255, 255}},
                                     {{50, 0, 0}, {119, 119, 119}},
                                     {{54.29, 80.81, 69.89}, {255, 0, 0}},
                                     {{29.57, 68.30, -112.03}, {0, 0, 255}}},
      under_d65{{{100, 0, 0}, {255, 255, 255}},
                {{53.24, 80.09, 67.20}, {255, 0, 0}},
                {{32.30, 79.19, -107.86}, {0, 0, 255}}};
  const auto expect = [&](const std::vector<Patch>& patches, const std::optional<std::array<float, 2>>& white,
                          int bits, int photometric) {
    constexpr int kCie = 8;
    cv::Mat samples(8, 8 * static_cast<int>(patches.size()), bits == 8 ? CV_8UC3 : CV_16UC3);
    for (int x = 0; x < samples.cols; ++x)
      for (int y = 0; y < samples.rows; ++y) {
        const auto& lab = patches[static_cast<std::size_t>(x / 8)].lab;
        const double unit = bits == 8 ? 1 : 256, full = bits == 8 ? 255 : 65535;
        // Of 16 bits, ICC's L* of 100 is 0xFF00.
        const double most = photometric != kCie && bits == 16 ? 65280 : full;
        for (int c = 0; c < 3; ++c) {
          const double value = lab[static_cast<std::size_t>(c)];
          const double chroma = photometric == kCie ? (value < 0 ? value * unit + full + 1 : value * unit)
                                                    : (value + 128) * unit;
          const double number = c == 0 ? value / 100 * most : chroma;
          if (bits == 8)
            samples.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(number);
          else
            samples.at<cv::Vec3w>(y, x)[c] = cv::saturate_cast<std::uint16_t>(number);
        }
      }
    WriteTiffNumbers(In("lab.tif"), samples, photometric, white);
    cv::Mat read = ReadPicture(In("lab.tif")).pixels;
    ASSERT_EQ(read.channels(), 3);
    read.convertTo(read, CV_64F, bits == 8 ? 1 : 1 / 257.0);
    for (std::size_t i = 0; i < patches.size(); ++i)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(read.at<cv::Vec3d>(4, 8 * static_cast<int>(i) + 4)[2 - c],
                    patches[i].rgb[static_cast<std::size_t>(c)], bits == 8 ? 4 : 1)
            << "patch " << i << ", " << bits << " bits, photometric " << photometric;
  };
  for (const int bits : {8, 16})
    for (const int photometric : {8, 9}) {
      expect(under_d50, std::nullopt, bits, photometric);
      expect(under_d50, std::array{0.34567F, 0.35850F}, bits, photometric);
      expect(under_d65, std::array{0.3127F, 0.3290F}, bits, photometric);
    }
}

}  // namespace
}  // namespace ulf::test
