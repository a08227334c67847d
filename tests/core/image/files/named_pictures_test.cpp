// Tests: core/image/files/stored_picture, core/image/files/picture_projection,
// core/image/files/picture_folder, core/image/files/picture_kind, core/image/files/tiff_numbers.
//
// Pictures that are valid and do not mean what their pixels seem to: what is doubtful is named, what no lens
// made is refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <tuple>

#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/picture_codecs.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/tiff_numbers.h"
#include "tests/support/pictures/sample_exr.h"
#include "tests/support/pictures/sample_pictures.h"
#include "tests/support/test_paths.h"

namespace ulf::test::named_pictures_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

auto NoteSays(const char* words) { return testing::Property(&PictureNote::Words, HasSubstr(words)); }

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

TEST_F(NamedPictures, NameFloatsAboveWhite) {
  for (const char* name : {"a.tif", "a.exr", "a.pfm", "a.hdr"}) {
    const auto expect_nothing = [&](const cv::Mat& light, const char* what) {
      WriteFloats(name, light);
      EXPECT_THAT(ReadPicture(In(name)).warnings, IsEmpty()) << what << ", " << name;
    };
    WriteFloats(name, Levels(255));
    EXPECT_THAT(ReadPicture(In(name)).warnings,
                ElementsAre(AllOf(HasSubstr("largest 255)"), HasSubstr("levels of 8 bits by 255"),
                                  HasSubstr("absolute light"))))
        << name;
    WriteFloats(name, Levels(255) * 0.5 + cv::Scalar::all(0.25));
    EXPECT_THAT(ReadPicture(In(name)).warnings, ElementsAre(HasSubstr("by 255"))) << "averages, " << name;
    expect_nothing(Levels(255) / 255, "light");
    cv::Mat mask(30, 40, CV_32FC3, cv::Scalar::all(0));
    mask.rowRange(0, 9).setTo(cv::Scalar::all(1));
    expect_nothing(mask, "a mask");
    cv::Mat lamp(30, 40, CV_32FC3, cv::Scalar::all(0));
    lamp.at<cv::Vec3f>(3, 4) = {5, 5, 5};
    expect_nothing(lamp, "a lamp in the dark");
    cv::Mat highlights = Levels(255) / 255;
    highlights.rowRange(0, 9).setTo(cv::Scalar::all(300));
    expect_nothing(highlights, "whole numbers in the sky");
  }
  for (const auto& [most, way_out] : {std::pair{1023, "levels of 10 bits by 1023"},
                                      {4095, "levels of 12 bits by 4095"},
                                      {16383, "levels of 14 bits by 16383"},
                                      {65535, "levels of 16 bits by 65535"}}) {
    WriteFloats("a.pfm", Levels(most));
    EXPECT_THAT(ReadPicture(In("a.pfm")).warnings, ElementsAre(HasSubstr(way_out)));
  }
  WriteFloats("a.pfm", Levels(80000));
  EXPECT_THAT(ReadPicture(In("a.pfm")).warnings,
              ElementsAre(AllOf(HasSubstr("largest 80000"), testing::Not(HasSubstr("levels of")))));
}

// Every channel counts, also where not every pixel is looked at.
TEST_F(NamedPictures, BrightChannelIsJudgedAlone) {
  for (int bright = 0; bright < 3; ++bright) {
    cv::Scalar light = cv::Scalar::all(0.2);
    light[bright] = 100;
    WriteFloats("a.pfm", cv::Mat(1000, 1000, CV_32FC3, light));
    EXPECT_THAT(ReadPicture(In("a.pfm")).warnings, IsEmpty()) << bright;
    light = cv::Scalar::all(100);
    light[bright] = 0.2;
    WriteFloats("a.pfm", cv::Mat(1000, 1000, CV_32FC3, light));
    EXPECT_THAT(ReadPicture(In("a.pfm")).warnings, ElementsAre(HasSubstr("median 100"))) << bright;
  }
}

TEST_F(NamedPictures, FaultOfManyPicturesIsSaidOnce) {
  EXPECT_EQ(WithoutNumbers("it holds 2 NaN (1.5e+06 of 3), P3, 16-bit"), "it holds  NaN ( of ), P3, ");
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  cv::Mat light(30, 40, CV_32FC3, cv::Scalar::all(0.1));
  for (int i = 0; i < 6; ++i) {
    light.at<cv::Vec3f>(i, 3)[0] = std::numeric_limits<float>::quiet_NaN();
    WriteFloats("a.pfm", light);
    ReadImageFile(In("a.pfm"));
  }
  spdlog::set_default_logger(logger);
  const std::string words = said.str();
  EXPECT_EQ(std::ranges::count(words, '\n'), 1) << words;
  EXPECT_THAT(words, HasSubstr("1 NaN, 0 infinite"));
}

// They get no weight where photographs are blended, so they stay what they are, also behind a
// conversion of colours.
TEST_F(NamedPictures, NonFiniteNumbersAreCountedAndStay) {
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
    EXPECT_THAT(picture.warnings, ElementsAre(HasSubstr("2 NaN, 1 infinite"))) << name;
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
                  kPart =
                      "<rdf:Description GPano:ProjectionType='equirectangular' "
                      "GPano:CroppedAreaImageWidthPixels='4000' GPano:FullPanoWidthPixels='8000' "
                      "GPano:CroppedAreaImageHeightPixels='4000' GPano:FullPanoHeightPixels='4000'/>",
                  kCylinder = "<rdf:Description GPano:ProjectionType=\"cylindrical\"/>";

// As ImageMagick writes it.
std::string RawProfile(const std::string& kind, const std::string& bytes) {
  std::string text = fmt::format("Raw profile type {}{}\n{}\n{:8}\n", kind, '\0', kind, bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i)
    text += fmt::format("{:02x}{}", static_cast<std::uint8_t>(bytes[i]), i % 36 == 35 ? "\n" : "");
  return text;
}

TEST_F(NamedPictures, PanoramasAreRefusedByName) {
  const std::string jpeg = JpegBytes(PatchPicture()), png = PngBytes(PatchPicture());
  for (const std::string& xmp : {kSphere, kSphereAsElement, kViewer, kPart, kCylinder}) {
    Write("a.jpg", WithSegment(jpeg, XmpSegment(xmp)));
    ExpectRefused("a.jpg", "is a panorama");
    ExpectRefused("a.jpg", xmp == kSphere || xmp == kSphereAsElement ? "v360=e" : "Hugin");
    const std::string text = std::string("XML:com.adobe.xmp\0\0\0\0\0", 22) + xmp;
    for (const bool at_end : {false, true}) {
      Write("a.png", WithPngChunk(png, "iTXt", text, at_end));
      ExpectRefused("a.png", "is a panorama");
      Write("a.png", WithPngChunk(png, "tEXt", RawProfile("xmp", xmp), at_end));
      ExpectRefused("a.png", "is a panorama");
    }
    WriteTiffSample(In("a.tif"), {.xmp = xmp});
    ExpectRefused("a.tif", "is a panorama");
    Write("a.webp", WithWebpChunk(WebpBytes(PatchPicture(), 100), 4, "XMP ", xmp));
    ExpectRefused("a.webp", "is a panorama");
  }
  WriteExrSample(In("a.exr"), {{.panorama = 0}});
  ExpectRefused("a.exr", "v360=e");
  WriteExrSample(In("a.exr"), {{.panorama = 1}});
  ExpectRefused("a.exr", "Hugin");
}

TEST_F(NamedPictures, PicturesMentioningPanoramasAreRead) {
  for (const std::string xmp :
       {"<rdf:Description GPano:UsePanoramaViewer=\"False\" V:StereoMode=\"mono\" "
        "GPano:ProjectionTypes=\"none\" V:ProjectionType=\"perspective\"/>",
        "<rdf:Description GPano:ProjectionType=\"planar\"/>",
        "<!-- <rdf:Description GPano:ProjectionType=\"equirectangular\"/> -->",
        "<dc:description>say GPano:ProjectionType=\"equirectangular\" for spheres</dc:description>",
        "<dc:description><![CDATA[<a:ProjectionType>equirectangular</a:ProjectionType>]]></dc:description>",
        "<rdf:Description dc:title='GPano:ProjectionType=\"equirectangular\"'/>",
        "<rdf:Description GPano:ProjectionType= dc:title=\"equirectangular\"/>", "<", "<a b", "<a b=\"c",
        "<!--"}) {
    Write("a.jpg", WithSegment(JpegBytes(PatchPicture()), XmpSegment(xmp)));
    EXPECT_NO_THROW(EXPECT_LE(LargestPatchError(ReadPicture(In("a.jpg")).pixels), 4)) << xmp;
  }
}

TEST_F(NamedPictures, AMarkBehindThePixelsOfAPngIsHeard) {
  const std::string exif = ExifSegment("2026:11:29 10:11:12", 6).substr(4), png = PngBytes(PatchPicture());
  for (const std::string& with : {WithPngChunk(png, "eXIf", exif.substr(6), true),
                                  WithPngChunk(png, "tEXt", RawProfile("exif", exif), true)}) {
    Write("a.png", with);
    EXPECT_THAT(ReadPicture(In("a.png")).notes, ElementsAre(NoteSays("turned by 90 degrees clockwise")));
  }
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

TEST_F(NamedPictures, StereoPairsAreRefused) {
  const std::string jpeg = JpegBytes(PatchPicture());
  Write("xmp.jpg", WithSegment(jpeg, XmpSegment(kStereo)));
  ExpectRefused("xmp.jpg", "crop=iw/2:ih");
  Write("above.jpg", WithSegment(jpeg, XmpSegment("<a V:StereoMode='top-bottom'/>")));
  ExpectRefused("above.jpg", "crop=iw:ih/2");
  const std::string side_by_side("\0\x04\0\x04\x02\x01", 6), one_eye("\0\x04\0\0\0\0", 6);
  Write("jps.jpg", WithSegment(jpeg, Segment('\xE3', "_JPSJPS_" + side_by_side)));
  ExpectRefused("jps.jpg", "crop=iw/2:ih");
  for (const auto& [layout, way_out] : {std::pair{'\x03', "crop=iw:ih/2"}, {'\x04', "of one eye"}}) {
    std::string other = side_by_side;
    other[4] = layout;
    Write("jps.jpg", WithSegment(jpeg, Segment('\xE3', "_JPSJPS_" + other)));
    ExpectRefused("jps.jpg", way_out);
  }
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
    EXPECT_THAT(two.notes, IsEmpty());
    EXPECT_THAT(two.remarks, ElementsAre(HasSubstr("it holds 2 pictures, of which the first is taken")));
    EXPECT_LE(LargestPatchError(two.pixels), 4);
    Write("preview.jpg", WithSegment(jpeg, PictureIndex(0x010001, is_little)) + jpeg);
    EXPECT_THAT(ReadPicture(In("preview.jpg")).remarks, IsEmpty());
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
  for (const std::string& size : {std::string("\0\0\x3C\0\x28", 5), std::string("\0\0\x03\0\x02", 5)}) {
    jpeg.replace(unit, 5, size);
    Write("a.jpg", jpeg);
    EXPECT_THAT(ReadPicture(In("a.jpg")).warnings, IsEmpty()) << "its 60x40 once more";
  }
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

TEST_F(NamedPictures, UnusedBitsOfATiffAreNamed) {
  constexpr int kRgb = 2;
  const auto warnings = [&](double sample, int most) {
    WriteTiffNumbers(In("a.tif"), cv::Mat(30, 40, CV_16UC3, cv::Scalar::all(sample)), kRgb, {}, most);
    return ReadPicture(In("a.tif")).warnings;
  };
  EXPECT_THAT(warnings(4095, 4095), ElementsAre(AllOf(HasSubstr("12 bits"), HasSubstr("by 16"))));
  for (const int most : {65535, 40000, 1, 0}) EXPECT_THAT(warnings(1, most), IsEmpty()) << most;
  EXPECT_THAT(warnings(4096, 4095), IsEmpty()) << "a tag that is not true";
  StoredPicture picture;
  constexpr int kBits = 12;
  WarnOfUnusedBits(1023, kBits, cv::Mat(2, 2, CV_16U, cv::Scalar::all(65535 * 1023.0 / 4095)), picture);
  EXPECT_THAT(picture.warnings, ElementsAre(HasSubstr("by 4"))) << "samples are spread to 16 bits";
  WarnOfUnusedBits(1023, kBits, cv::Mat(2, 2, CV_16U, cv::Scalar::all(65535 * 1024.0 / 4095)), picture);
  EXPECT_EQ(picture.warnings.size(), 1u);
}

TEST_F(NamedPictures, TheViewsOfAnExrAreSaid) {
  WriteExrSample(In("a.exr"), {{.channels = {"R", "G", "B", "right.R", "right.G", "right.B"},
                                .views = {"left", "right"}}});
  EXPECT_THAT(ReadPicture(In("a.exr")).notes, IsEmpty());
  EXPECT_THAT(ReadPicture(In("a.exr")).remarks, Contains(HasSubstr("2 views (left, right)")));
}

std::string LittleEndian(std::size_t value, int count = 4) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i);
  return bytes;
}

// With a header of version 5: `space` says what the 48 bytes `calibration` hold, the profile stands
// behind the pixels.
std::string BmpBytes(const cv::Mat& bgr, const std::string& space, const std::string& calibration,
                     const std::string& icc = {}) {
  std::string rows;
  for (int y = bgr.rows - 1; y >= 0; --y) rows.append(bgr.ptr<char>(y), 3 * 60);
  constexpr std::size_t kHead = 14, kHeader = 124;
  const std::string header =
      LittleEndian(kHeader) + LittleEndian(60) + LittleEndian(40) + LittleEndian(1, 2) + LittleEndian(24, 2) +
      LittleEndian(0) + LittleEndian(rows.size()) + std::string(32, '\0') + space + calibration +
      LittleEndian(4) + LittleEndian(kHeader + rows.size()) + LittleEndian(icc.size()) + LittleEndian(0);
  EXPECT_EQ(header.size(), kHeader);
  return "BM" + LittleEndian(kHead + kHeader + rows.size() + icc.size()) + LittleEndian(0) +
         LittleEndian(kHead + kHeader) + header + rows + icc;
}

TEST_F(NamedPictures, TheProfileOfABmpCounts) {
  Write("a.bmp", BmpBytes(EncodedIn("P3", PatchPicture()), "DEBM", std::string(48, '\0'), IccProfile("P3")));
  const StoredPicture picture = ReadPicture(In("a.bmp"));
  EXPECT_LE(LargestPatchError(picture.pixels), 3);
  EXPECT_THAT(picture.notes, ElementsAre(NoteSays("converted to sRGB")));
}

TEST_F(NamedPictures, ABmpOfOtherColoursThanSrgbIsNamed) {
  // x, y, z of red, green and blue, then an exponent of each.
  const auto warnings = [&](const std::array<double, 9>& xyz, double exponent) {
    std::string calibration;
    for (const double number : xyz)
      calibration += LittleEndian(static_cast<std::size_t>(std::ldexp(number, 30)));
    for (int c = 0; c < 3; ++c)
      calibration += LittleEndian(static_cast<std::size_t>(std::ldexp(exponent, 16)));
    Write("a.bmp", BmpBytes(PatchPicture(), std::string(4, '\0'), calibration));
    return ReadPicture(In("a.bmp")).warnings;
  };
  const std::array<double, 9> srgb{0.64, 0.33, 0.03, 0.30, 0.60, 0.10, 0.15, 0.06, 0.79},
      p3{0.68, 0.32, 0, 0.265, 0.69, 0.045, 0.15, 0.06, 0.79};
  EXPECT_THAT(warnings({}, 0), IsEmpty());
  EXPECT_THAT(warnings(srgb, 2.2), IsEmpty());
  EXPECT_THAT(warnings(srgb, 1 / 2.2), IsEmpty());
  EXPECT_THAT(warnings(srgb, 1), ElementsAre(HasSubstr("taken for sRGB")));
  EXPECT_THAT(warnings(p3, 0), ElementsAre(HasSubstr("taken for sRGB")));
}

TEST_F(NamedPictures, AnimatedPngIsItsFirstPicture) {
  Write("a.png", WithPngChunk(PngBytes(PatchPicture()), "acTL", std::string("\0\0\0\x02\0\0\0\0", 8)));
  const StoredPicture picture = ReadPicture(In("a.png"));
  EXPECT_THAT(picture.warnings, ElementsAre(HasSubstr("animated")));
  EXPECT_LE(LargestPatchError(picture.pixels), 0.01);
}

TEST_F(NamedPictures, OtherFilesInAFolderAreCounted) {
  const std::string jpeg = JpegBytes(PatchPicture());
  for (const char* name : {"b10.jpg", "b9.MPO", "a.PNG"}) Write(name, jpeg);
  for (const char* name : {"notes.txt", "b9.XMP", "Thumbs.db", ".hidden", "._a.jpg"}) Write(name, "words");
  EXPECT_THAT(PicturesIn(Folder()).left_out, IsEmpty());
  Write("telephone", std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(20, '\0'));
  Write("c.HEIC", "heic");
  Write("c", jpeg);
  Write("a.jpg_original", jpeg);
  Write("BMW", "BMW 3 notes: the car stood before the house\n");
  Write("P3", "P3 is the third point\n");
  Write("small", std::string("P6 2 1 255\n") + "ulf1ab");
  Write("film.mp4", std::string("\0\0\0\x18", 4) + "ftypmp42" + std::string(20, '\0'));
  std::filesystem::create_directories(Folder() / "more");
  std::filesystem::create_directories(Folder() / "empty");
  Write("more/d.jpg", jpeg);
  const PictureFolder found = PicturesIn(Folder());
  std::vector<std::string> names;
  for (const auto& file : found.pictures) names.push_back(file.filename().string());
  EXPECT_THAT(names, ElementsAre("a.PNG", "b9.MPO", "b10.jpg"));
  EXPECT_THAT(found.left_out,
              testing::UnorderedElementsAre(
                  AllOf(HasSubstr("2 files are HEIC"), HasSubstr("heif-convert")),
                  AllOf(HasSubstr("3 files are pictures by the first bytes"),
                        HasSubstr("(a.jpg_original, c, small)")),
                  AllOf(HasSubstr("3 files are no pictures"), HasSubstr("(BMW, P3, film.mp4)")),
                  AllOf(HasSubstr("1 folder inside"), HasSubstr("(more)"))));
  EXPECT_THAT(found.LeftOut(), AllOf(HasSubstr("heif-convert"), HasSubstr("film.mp4")));
  EXPECT_EQ(AbbreviatedList({"a", "b", "c", "d"}), "a, b, c, ...");
}

TEST_F(NamedPictures, MinorityIsNamedAsTheOddOne) {
  using Words = std::vector<std::string>;
  EXPECT_FALSE(FirstMismatch(Words{"a", "a"}));
  for (const auto& [words, odd, usual, count] : {std::tuple{Words{"a", "b", "b"}, 0, 1, 2},
                                                 {Words{"b", "b", "a"}, 2, 0, 2},
                                                 {Words{"a", "b"}, 1, 0, 1}}) {
    const auto found = FirstMismatch(words);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->odd, static_cast<std::size_t>(odd));
    EXPECT_EQ(found->usual, static_cast<std::size_t>(usual));
    EXPECT_EQ(found->usual_count, static_cast<std::size_t>(count));
  }
}

// Numbers as published for D50 (Bradford), and for the white D65 of sRGB itself.
TEST_F(NamedPictures, LabIsConvertedByItsOwnWhite) {
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
}  // namespace ulf::test::named_pictures_test
