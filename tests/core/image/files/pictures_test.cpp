// Tests: core/image/files/picture_file, core/image/files/tiff_picture, core/image/files/png_picture,
// core/image/files/webp_picture, core/image/files/rare_pictures, core/image/files/picture_colors,
// core/image/files/picture_end, core/image/files/stored_picture, core/image/files/jpeg_codec,
// core/image/files/picture_codecs.
//
// Valid pictures of many layouts, each with six patches of known colours: they are read right, or what is not
// understood is named.
#include "core/image/files/picture_file.h"

#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/image_header.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/picture_codecs.h"
#include "core/image/files/picture_end.h"
#include "core/image/files/png_picture.h"
#include "tests/support/pictures/sample_exr.h"
#include "tests/support/pictures/sample_pictures.h"
#include "tests/support/test_paths.h"

namespace ulf::test::pictures_test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

auto NoteSays(const char* words) { return testing::Property(&PictureNote::Words, HasSubstr(words)); }

constexpr double kLevels = 2;  // of 255, rounding in the file and in the conversion

class PictureFiles : public testing::Test {
 protected:
  std::string In(const std::string& name) const { return (folder_ / name).string(); }
  void Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(In(name), std::ios::binary) << bytes;
  }
  std::string Encoded(const char* ending, const cv::Mat& pixels, const std::vector<int>& options = {}) const {
    std::vector<unsigned char> bytes;
    cv::imencode(ending, pixels, bytes, options);
    return {bytes.begin(), bytes.end()};
  }
  void ExpectRefused(const std::string& name, const std::string& words) const {
    EXPECT_THAT([&] { ReadPicture(In(name)); },
                testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr(In(name)), HasSubstr(words))))
        << name;
  }

 private:
  const ScratchFolder folder_;
};

TEST_F(PictureFiles, TiffsOfEveryLayoutShowTheirColours) {
  const std::map<std::string, TiffLayout> layouts = {
      {"8 bits", {}},
      {"16 bits", {.bits = 16}},
      {"16 bits in planes", {.bits = 16, .planes = true}},
      {"8 bits in planes and tiles", {.planes = true, .tiles = true}},
      {"16 bits, planes, tiles, deflated, differences",
       {.bits = 16, .planes = true, .tiles = true, .predictor = 2, .compression = 8}},
      {"16 bits big-endian", {.bits = 16, .mode = "wb"}},
      {"BigTIFF", {.bits = 16, .mode = "w8"}},
      {"LZW with differences", {.predictor = 2, .compression = 5}},
      {"grey", {.photometric = 1}},
      {"grey 16", {.bits = 16, .photometric = 1}},
      {"grey 12", {.bits = 12, .photometric = 1}},
      {"white is zero", {.photometric = 0}},
      {"white is zero 16", {.bits = 16, .photometric = 0}},
      {"white is zero 16 in tiles, big-endian", {.bits = 16, .photometric = 0, .tiles = true, .mode = "wb"}},
      {"32 bits", {.bits = 32}},
      {"12 bits", {.bits = 12}},
      {"half", {.bits = 16, .format = 3}},
      {"24 bits of floating point", {.bits = 24, .format = 3}},
      {"single", {.bits = 32, .format = 3}},
      {"double", {.bits = 64, .format = 3}},
      {"double, big-endian, planes", {.bits = 64, .format = 3, .planes = true, .mode = "wb"}},
      {"single, differences of floating point", {.bits = 32, .format = 3, .predictor = 3, .compression = 8}},
      {"half, grey", {.bits = 16, .format = 3, .photometric = 1}},
      {"palette", {.photometric = 3}},
      {"palette of 4 bits", {.bits = 4, .photometric = 3}},
      {"inks", {.photometric = 5}},
      {"inks in planes, 16 bits", {.bits = 16, .photometric = 5, .planes = true}},
      {"turned", {.orientation = 6}},
      {"turned by half", {.bits = 16, .orientation = 3}},
      {"alpha", {.alpha = 2}},
      {"alpha in planes, 16 bits", {.bits = 16, .planes = true, .alpha = 2}},
      {"multiplied by alpha", {.alpha = 1}},
      {"multiplied by alpha, 16 bits", {.bits = 16, .alpha = 1}},
      {"a thumbnail first", {.bits = 16, .thumbnail_first = 2}},
      {"inside a thumbnail's directory", {.bits = 16, .is_inside_thumbnail = true}},
      {"in sRGB", {.icc = IccProfile("sRGB")}},
  };
  for (const auto& [name, layout] : layouts) {
    WriteTiffSample(In("a.tif"), layout);
    const StoredPicture picture = ReadPicture(In("a.tif"));
    EXPECT_LE(LargestPatchError(picture.pixels), kLevels) << name;
    EXPECT_EQ(picture.pixels.depth(), layout.format == 3 ? CV_32F : layout.bits > 8 ? CV_16U : CV_8U) << name;
    EXPECT_EQ(TransferOfFile(In("a.tif")), layout.format == 3 ? Transfer::kLinear : Transfer::kSrgb) << name;
    EXPECT_EQ(ReadImageSize(In("a.tif")), cv::Size(60, 40)) << name;
    EXPECT_EQ(picture.alpha.empty(), layout.alpha < 0) << name;
    EXPECT_EQ(picture.notes.empty(), layout.orientation == 1 && layout.alpha != 1) << name;
    EXPECT_EQ(picture.warnings.empty(), layout.photometric != 5) << name;
    if (layout.alpha >= 0) {
      EXPECT_NEAR(cv::mean(picture.alpha)[0] * (layout.bits == 16 ? 255 / 65535.0 : 1), 128, 0.6) << name;
    }
  }
  WriteTiffSample(In("bilevel.tif"), {.bits = 1, .photometric = 0});
  const cv::Mat bilevel = ReadPicture(In("bilevel.tif")).pixels;
  EXPECT_EQ(bilevel.at<std::uint8_t>(5, 5), 0) << "green 50";
  EXPECT_EQ(bilevel.at<std::uint8_t>(5, 25), 255) << "green 200";
}

TEST_F(PictureFiles, TiffsOfOtherSpacesShowTheirColours) {
  for (const int bits : {8, 16}) {
    WriteTiffSample(In("lab.tif"), {.bits = bits, .photometric = 8});
    const StoredPicture picture = ReadPicture(In("lab.tif"));
    EXPECT_LE(LargestPatchError(picture.pixels), bits == 8 ? 4 : kLevels) << bits;
    EXPECT_THAT(picture.notes, Contains(NoteSays("L*a*b*")));
  }
}

TEST_F(PictureFiles, RefuseTiffPagesThatAreNoPicture) {
  WriteTiffSample(In("signed.tif"), {.bits = 16, .format = 2, .photometric = 1});
  ExpectRefused("signed.tif", "signed numbers");
  WriteTiffSample(In("complex.tif"), {.bits = 64, .format = 6, .photometric = 1});
  ExpectRefused("complex.tif", "complex numbers");
  WriteTiffSample(In("mosaic.tif"), {.bits = 16, .photometric = 32803});
  ExpectRefused("mosaic.tif", "a sensor's mosaic");
  WriteTiffSample(In("pages.tif"), {.further_pages = 2});
  EXPECT_THAT(ReadPicture(In("pages.tif")).warnings,
              Contains(HasSubstr("it holds 3 pages: the first is taken")));
}

// Floating point has no claim of memory: what the file says is checked before anything is read.
TEST_F(PictureFiles, OverclaimingTiffIsRefusedUndecoded) {
  WriteTiffSample(In("a.tif"), {.photometric = 1});
  std::string bytes = ReadWholeFile(In("a.tif"));
  // The directory's entries of ImageWidth (256) and ImageLength (257): their value is the last four
  // of twelve bytes.
  for (const char low : {'\x00', '\x01'}) {
    const std::size_t at =
        bytes.find(std::string{low, '\x01', '\x03', '\x00', '\x01', '\x00', '\x00', '\x00'});
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, 12,
                  std::string{low, '\x01', '\x04', '\x00', '\x01', '\x00', '\x00', '\x00', '\x00', '\x00',
                              '\x01', '\x00'});
  }
  Write("large.tif", bytes);
  ExpectRefused("large.tif", "million pixels");
}

TEST_F(PictureFiles, PngsOfEveryLayoutShowTheirColours) {
  const std::vector<double> p3_xy{0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060},
      srgb_xy{0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06};
  const std::map<std::string, PngLayout> as_they_are = {
      {"8 bits", {}},
      {"16 bits", {.bits = 16}},
      {"grey", {.grey = true}},
      {"grey of 16 bits", {.bits = 16, .grey = true}},
      {"palette", {.palette = true}},
      {"palette of 4 bits", {.bits = 4, .palette = true}},
      {"interlaced", {.interlaced = true}},
      {"interlaced palette", {.palette = true, .interlaced = true}},
      {"primaries of sRGB", {.primaries = srgb_xy}},
      {"profile of sRGB", {.icc = IccProfile("sRGB")}},
      {"code of sRGB", {.code = std::string("\x01\x0D\0\x01", 4)}},
  };
  for (const auto& [name, layout] : as_they_are) {
    WritePngSample(In("a.png"), layout);
    const StoredPicture picture = ReadPicture(In("a.png"));
    EXPECT_LE(LargestPatchError(picture.pixels), 0.01) << name;
    EXPECT_THAT(picture.notes, IsEmpty()) << name;
    EXPECT_THAT(picture.warnings, IsEmpty()) << name;
  }
  const std::map<std::string, PngLayout> converted = {
      {"linear", {.bits = 16, .gamma = 1.0}},
      {"linear of 8 bits", {.gamma = 1.0}},
      {"Macintosh", {.gamma = 1 / 1.8}},
      {"grey, linear", {.bits = 16, .grey = true, .gamma = 1.0}},
  };
  for (const auto& [name, layout] : converted) {
    WritePngSample(In("a.png"), layout);
    const StoredPicture picture = ReadPicture(In("a.png"));
    EXPECT_LE(LargestPatchError(picture.pixels), layout.bits == 8 && layout.gamma == 1 ? 3 : kLevels) << name;
    EXPECT_THAT(picture.notes, Contains(NoteSays("converted to sRGB"))) << name;
  }
  // What a file that says 1/2.2 means is sRGB, by the standard's own advice.
  WritePngSample(In("a.png"), {.primaries = srgb_xy});
  EXPECT_LE(LargestPatchError(ReadPicture(In("a.png")).pixels), 0.01);
  // Wider primaries: by cHRM, by cICP and by a profile alike.
  const cv::Mat in_p3 = EncodedIn("P3", PatchPicture());
  ASSERT_GT(cv::norm(in_p3, PatchPicture(), cv::NORM_INF), 20);
  Write("p3.png", PngBytes(in_p3));
  ASSERT_GT(LargestPatchError(ReadPicture(In("p3.png")).pixels), 20) << "without a claim the numbers stay";
}

TEST_F(PictureFiles, WiderPrimariesAreConverted) {
  const cv::Mat in_p3 = EncodedIn("P3", PatchPicture());
  const std::string png = PngBytes(in_p3), jpeg = JpegBytes(in_p3, 100), icc = IccProfile("P3");
  const auto number = [](double xy) {
    const auto n = static_cast<std::uint32_t>(std::lround(xy * 100000));
    return std::string{static_cast<char>(n >> 24), static_cast<char>(n >> 16), static_cast<char>(n >> 8),
                       static_cast<char>(n)};
  };
  std::string primaries;
  for (const double xy : {0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060}) primaries += number(xy);
  Write("cHRM.png", WithPngChunk(png, "cHRM", primaries));
  Write("cICP.png", WithPngChunk(png, "cICP", std::string("\x0C\x0D\0\x01", 4)));
  const std::string profile_segment = std::string("\xFF\xE2") + static_cast<char>((icc.size() + 16) >> 8) +
                                      static_cast<char>(icc.size() + 16) +
                                      std::string("ICC_PROFILE\0\x01\x01", 14) + icc;
  Write("icc.jpg", WithSegment(jpeg, profile_segment));
  Write("icc.webp", WithWebpChunk(WebpBytes(in_p3, 100), 0x20, "ICCP", icc));
  for (const char* name : {"cHRM.png", "cICP.png", "icc.jpg", "icc.webp"}) {
    const StoredPicture picture = ReadPicture(In(name));
    EXPECT_LE(LargestPatchError(picture.pixels), std::string(name).starts_with("icc") ? 5 : 3) << name;
    EXPECT_THAT(picture.notes, Contains(NoteSays("converted to sRGB"))) << name;
    EXPECT_THAT(picture.warnings, IsEmpty()) << name;
  }
  WriteTiffSample(In("linear.tif"), {.bits = 16, .icc = IccProfile("linear")});
  EXPECT_THAT(ReadPicture(In("linear.tif")).notes, Contains(NoteSays("converted to sRGB")));
}

// Every grey there is, and colours up to the border of the gamut.
TEST_F(PictureFiles, ConversionsOfSixteenBitsAreExact) {
  cv::Mat ramp(256, 256, CV_16UC1);
  for (int i = 0; i < 65536; ++i) ramp.ptr<std::uint16_t>(i / 256)[i % 256] = static_cast<std::uint16_t>(i);
  Write("ramp.png", WithPngChunk(PngBytes(ramp), "gAMA", std::string("\0\x01\x86\xA0", 4)));
  const cv::Mat read = ReadPicture(In("ramp.png")).pixels;
  ASSERT_EQ(read.type(), CV_16UC1);
  double worst = 0;
  for (int i = 0; i < 65536; ++i)
    worst = std::max(worst, std::abs(read.ptr<std::uint16_t>(i / 256)[i % 256] -
                                     65535.0 * SrgbFromLinear(static_cast<float>(i) / 65535.0F)));
  EXPECT_LE(worst, 16);
  cv::Mat ramp8(1, 256, CV_8UC1);
  for (int i = 0; i < 256; ++i) ramp8.at<std::uint8_t>(i) = static_cast<std::uint8_t>(i);
  Write("ramp8.png", WithPngChunk(PngBytes(ramp8), "gAMA", std::string("\0\x01\x86\xA0", 4)));
  const cv::Mat read8 = ReadPicture(In("ramp8.png")).pixels;
  for (int i = 0; i < 256; ++i)
    EXPECT_NEAR(read8.at<std::uint8_t>(i), 255 * SrgbFromLinear(static_cast<float>(i) / 255), 0.51) << i;

  // Display P3 from BT.709's primaries, both with the white D65.
  const cv::Matx33d p3_from_srgb(0.8224620, 0.1775380, 0, 0.0331942, 0.9668058, 0, 0.0170826, 0.0723974,
                                 0.9105199);
  cv::Mat truth(64, 64, CV_16UC3), in_p3(64, 64, CV_16UC3);
  cv::theRNG().state = 7;
  cv::randu(truth, 0, 65536);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto& bgr = truth.at<cv::Vec3w>(y, x);
      const auto light = [&](int c) {
        return static_cast<double>(LinearFromSrgb(static_cast<float>(bgr[c]) / 65535.0F));
      };
      const cv::Vec3d p3 = p3_from_srgb * cv::Vec3d(light(2), light(1), light(0));
      for (int c = 0; c < 3; ++c)
        in_p3.at<cv::Vec3w>(y, x)[2 - c] =
            cv::saturate_cast<std::uint16_t>(65535 * SrgbFromLinear(static_cast<float>(p3[c])));
    }
  Write("deep.png", WithPngChunk(PngBytes(in_p3), "cICP", std::string("\x0C\x0D\0\x01", 4)));
  EXPECT_LE(cv::norm(ReadPicture(In("deep.png")).pixels, truth, cv::NORM_INF), 257) << "one level of 255";
}

TEST_F(PictureFiles, MarksOfExifAreHeardInEveryKind) {
  const std::string segment = ExifSegment("2026:11:29 10:11:12", 6), tiff = segment.substr(10);
  Write("a.png", WithPngChunk(PngBytes(PatchPicture()), "eXIf", tiff));
  EXPECT_THAT(ReadPicture(In("a.png")).notes, Contains(NoteSays("turned by 90 degrees")));
  // A camera set to Adobe RGB says so in its Exif data alone.
  Write("adobe.jpg",
        WithSegment(JpegBytes(PatchPicture(), 100), ExifSegment("2026:11:29 10:11:12", 1, {}, true)));
  const StoredPicture adobe = ReadPicture(In("adobe.jpg"));
  EXPECT_THAT(adobe.notes, Contains(NoteSays("Adobe RGB")));
  // The most saturated green of the patches: (50, 200, 50) of Adobe RGB lies beyond sRGB, its red is none.
  EXPECT_LE(adobe.pixels.at<cv::Vec3b>(kPatchPx / 2, kPatchPx * 3 / 2)[2], 5);
  EXPECT_NEAR(adobe.pixels.at<cv::Vec3b>(kPatchPx * 3 / 2, kPatchPx * 3 / 2)[1], 128, 2) << "grey stays";
}

// Radiance says by how much light was multiplied, and its primaries.
TEST_F(PictureFiles, TheHeaderOfRadianceCounts) {
  const cv::Mat light(8, 16, CV_32FC3, cv::Scalar(0.25, 0.25, 0.25));
  std::string hdr = Encoded(".hdr", light);
  const std::size_t at = hdr.find('\n') + 1;
  Write("a.hdr", hdr.substr(0, at) + "EXPOSURE= 2\nEXPOSURE=0.25\n" + hdr.substr(at));
  const StoredPicture picture = ReadPicture(In("a.hdr"));
  EXPECT_NEAR(picture.pixels.at<cv::Vec3f>(4, 4)[1], 0.5, 0.01);
  EXPECT_THAT(picture.notes, Contains(NoteSays("multiplied by 0.5")));
}

TEST_F(PictureFiles, ForeignProfilesAreNamedAndPixelsStay) {
  for (const char* kind : {"CMYK", "Lab", "grey"}) {
    WriteTiffSample(In("a.tif"), {.icc = IccProfile(kind)});
    const StoredPicture picture = ReadPicture(In("a.tif"));
    EXPECT_LE(LargestPatchError(picture.pixels), 0.01) << kind;
    EXPECT_THAT(picture.warnings, Contains(testing::AllOf(HasSubstr(std::string("is for ") + kind),
                                                          HasSubstr("taken for sRGB"))));
  }
  WritePngSample(In("a.png"), {.icc = IccProfile("P3")});
  EXPECT_THAT(ReadPicture(In("a.png")).notes, Contains(NoteSays("converted to sRGB")));
  const std::string png = ReadWholeFile(In("a.png")), plain = PngBytes(PatchPicture());
  Write("grey.png", WithPngChunk(plain, "iCCP", std::string("grey\0\0", 6) + "no compressed profile"));
  EXPECT_THAT(ReadPicture(In("grey.png")).warnings, Contains(HasSubstr("profile cannot be used")));
  WriteTiffSample(In("a.tif"), {.icc = std::string(200, 'x')});
  EXPECT_THAT(ReadPicture(In("a.tif")).warnings, Contains(HasSubstr("profile (ICC) is damaged")));
  WriteTiffSample(In("a.tif"), {.photometric = 1, .icc = IccProfile("grey")});
  EXPECT_THAT(ReadPicture(In("a.tif")).notes, Contains(NoteSays("converted to sRGB")));
}

TEST_F(PictureFiles, HdrAndUnknownPngCodesAreNamed) {
  const std::string png = PngBytes(PatchPicture());
  Write("pq.png", WithPngChunk(png, "cICP", std::string("\x09\x10\0\x01", 4)));
  ExpectRefused("pq.png", "high dynamic range (PQ");
  Write("hlg.png", WithPngChunk(png, "cICP", std::string("\x09\x12\0\x01", 4)));
  ExpectRefused("hlg.png", "high dynamic range (HLG");
  Write("limited.png", WithPngChunk(png, "cICP", std::string("\x01\x0D\0\0", 4)));
  EXPECT_THAT(ReadPicture(In("limited.png")).warnings, Contains(HasSubstr("not understood")));
}

TEST_F(PictureFiles, JpegsOfEveryKindShowTheirColours) {
  cv::Mat rgb;
  cv::cvtColor(PatchPicture(), rgb, cv::COLOR_BGR2RGB);
  Write("progressive.jpg",
        Encoded(".jpg", PatchPicture(), {cv::IMWRITE_JPEG_QUALITY, 100, cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  Write("grey.jpg", JpegBytes(PatchGrey(), 100));
  Write("restarts.jpg",
        Encoded(".jpg", PatchPicture(), {cv::IMWRITE_JPEG_QUALITY, 100, cv::IMWRITE_JPEG_RST_INTERVAL, 2}));
  Write("turned.jpg", WithSegment(JpegBytes(PatchPicture(), 100), ExifSegment("2026:11:29 10:11:12", 6)));
  for (const char* name : {"progressive.jpg", "grey.jpg", "restarts.jpg", "turned.jpg"})
    EXPECT_LE(LargestPatchError(ReadPicture(In(name)).pixels), 3) << name;
  EXPECT_THAT(ReadPicture(In("turned.jpg")).notes, Contains(NoteSays("turned by 90 degrees clockwise")));
}

TEST_F(PictureFiles, RarerKindsShowTheirColours) {
  cv::Mat linear;
  PatchPicture().convertTo(linear, CV_32F, 1 / 255.0);
  for (int y = 0; y < linear.rows; ++y)
    for (int i = 0; i < 3 * linear.cols; ++i)
      linear.ptr<float>(y)[i] = LinearFromSrgb(linear.ptr<float>(y)[i]);
  cv::Mat deep;
  PatchPicture().convertTo(deep, CV_16U, 257);
  Write("a.bmp", Encoded(".bmp", PatchPicture()));
  Write("grey.bmp", Encoded(".bmp", PatchGrey()));
  Write("a.ppm", Encoded(".ppm", PatchPicture()));
  Write("deep.ppm", Encoded(".ppm", deep));
  Write("a.pgm", Encoded(".pgm", PatchGrey()));
  Write("text.ppm", Encoded(".ppm", PatchPicture(), {cv::IMWRITE_PXM_BINARY, 0}));
  Write("a.hdr", Encoded(".hdr", linear));
  Write("a.pfm", Encoded(".pfm", linear));
  Write("a.webp", WebpBytes(PatchPicture(), 100));
  for (const char* name :
       {"a.bmp", "grey.bmp", "a.ppm", "deep.ppm", "a.pgm", "text.ppm", "a.hdr", "a.pfm", "a.webp"}) {
    const StoredPicture picture = ReadPicture(In(name));
    cv::Mat shown = picture.pixels;
    if (std::string(name) == "grey.bmp") cv::extractChannel(picture.pixels, shown, 1);  // a palette of greys
    EXPECT_LE(LargestPatchError(shown), std::string(name) == "a.webp" ? 4 : kLevels) << name;
    const bool is_linear = std::string(name) == "a.hdr" || std::string(name) == "a.pfm";
    EXPECT_EQ(picture.pixels.depth() == CV_32F, is_linear) << name;
    EXPECT_EQ(picture.pixels.depth() == CV_16U, std::string(name) == "deep.ppm") << name;
    EXPECT_EQ(TransferOfFile(In(name)) == Transfer::kLinear, is_linear) << name;
    EXPECT_EQ(ReadImageSize(In(name)), cv::Size(60, 40)) << name;
  }
  for (const char* name : {"a.bmp", "deep.ppm", "a.pgm", "a.hdr", "a.webp"}) {
    const std::string bytes = ReadWholeFile(In(name));
    Write(std::string("cut.") + name, bytes.substr(0, bytes.size() / 2));
    ExpectRefused(std::string("cut.") + name, "");
  }
}

TEST_F(PictureFiles, BytesTellTheKindInAnyEnding) {
  Write("really.png.jpg", PngBytes(PatchPicture()));
  EXPECT_LE(LargestPatchError(ReadImageFile(In("really.png.jpg"))), 0.01);
  const cv::Mat light(8, 9, CV_32FC3, cv::Scalar(0.1, 0.2, 0.3));
  const std::string exr = ExrBytes({{"B", light, 0}, {"G", light, 1}, {"R", light, 2}}, ExrCompression::kZip);
  for (const char* name : {"f0.EXR", "f0.Exr", "f0.exr"}) {
    Write(name, exr);
    EXPECT_TRUE(HasImageEnding(name));
    EXPECT_EQ(TransferOfFile(In(name)), Transfer::kLinear);
    EXPECT_NEAR(ReadImageFile(In(name)).at<cv::Vec3f>(4, 4)[1], 0.2, 1e-6);
  }
  for (const char* name : {"a.jfif", "a.JPE", "a.TIFF", "a.pbm", "a.DNG", "a.WebP"})
    EXPECT_TRUE(HasImageEnding(name)) << name;
  for (const char* name : {"a.heic", "a.AVIF", "a.gif", "a.txt", "heic"})
    EXPECT_FALSE(HasImageEnding(name)) << name;
  EXPECT_THAT(UnreadPicture("IMG_1.HEIC").value_or(""),
              testing::AllOf(HasSubstr("heif-convert"), HasSubstr("sips")));
  EXPECT_FALSE(UnreadPicture("a.jpg"));
  Write("telephone.jpg", std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(20, '\0'));
  ExpectRefused("telephone.jpg", "heif-convert");
  Write("a.gif.png", "GIF89a" + std::string(40, '\0'));
  ExpectRefused("a.gif.png", "GIF");
}

TEST_F(PictureFiles, ExrsOfOtherProgramsShowTheirColours) {
  constexpr std::array<float, 8> kBt2020{0.708F, 0.292F, 0.170F, 0.797F, 0.131F, 0.046F, 0.3127F, 0.3290F};
  const std::map<std::string, std::vector<ExrPartLayout>> layouts = {
      {"half", {{}}},
      {"float with alpha", {{.channels = {"A", "R", "G", "B"}, .type = "float"}}},
      {"tiles", {{.tiles = true}}},
      {"BT.2020", {{.type = "float", .primaries = kBt2020}}},
      {"in the second part", {{.name = "depth", .channels = {"Z"}, .type = "float"}, {.name = "beauty"}}},
      {"in the third part, tiled, BT.2020",
       {{.name = "depth", .channels = {"Z"}},
        {.name = "normals", .channels = {"N.X"}},
        {.name = "beauty", .type = "float", .primaries = kBt2020, .tiles = true}}},
      {"in a layer", {{.channels = {"beauty.R", "beauty.G", "beauty.B", "Z"}}}},
      {"data beyond the display", {{.margin = 3}}},
      {"far from 0", {{.channels = {"A", "R", "G", "B"}, .origin = 1 << 29}}},
      {"in floats, luminance alone", {{.channels = {"Y"}, .type = "float"}}},
  };
  for (const auto& [name, parts] : layouts) {
    WriteExrSample(In("a.exr"), parts);
    const StoredPicture picture = ReadPicture(In("a.exr"));
    cv::Mat shown = picture.pixels;
    if (name.ends_with("luminance alone")) cv::extractChannel(picture.pixels, shown, 1);
    EXPECT_LE(LargestPatchError(shown), 1) << name;
    const bool is_plain = parts.size() == 1 && !parts[0].primaries && parts[0].channels[0] != "beauty.R";
    EXPECT_EQ(picture.notes.empty() && picture.remarks.empty(), is_plain) << name;
    EXPECT_THAT(picture.warnings, IsEmpty()) << name;
  }
  WriteLuminanceChromaExr(In("a.exr"));
  cv::Mat shown;
  cv::resize(ReadPicture(In("a.exr")).pixels, shown, {3 * kPatchPx, 2 * kPatchPx}, 0, 0, cv::INTER_NEAREST);
  EXPECT_LE(LargestPatchError(shown), 3);
  WriteExrSample(In("a.exr"), {{.channels = {"one.R", "one.G", "one.B", "two.R", "two.G", "two.B"}}});
  EXPECT_THAT(ReadPicture(In("a.exr")).warnings,
              Contains(HasSubstr("layer 'one', the first of 2 that may be meant")));
}

TEST_F(PictureFiles, ExrShowsItsPictureLayer) {
  const std::map<std::string, std::vector<std::string>> layouts = {
      {"beauty", {"N.X", "N.Y", "N.Z", "beauty.R", "beauty.G", "beauty.B"}},
      {"ViewLayer.Combined",
       {"ViewLayer.AO.R", "ViewLayer.AO.G", "ViewLayer.AO.B", "ViewLayer.Combined.R", "ViewLayer.Combined.G",
        "ViewLayer.Combined.B", "ViewLayer.Depth.Z", "ViewLayer.Vector.X", "ViewLayer.Vector.Y"}},
      {"paint", {"mask.Y", "paint.R", "paint.G", "paint.B"}},
      {"fog", {"fog.Y", "motion.X", "motion.Y"}}};
  for (const auto& [layer, channels] : layouts) {
    WriteExrSample(In("a.exr"), {{.channels = channels}});
    const StoredPicture picture = ReadPicture(In("a.exr"));
    EXPECT_THAT(picture.remarks, Contains(HasSubstr("layer '" + layer + "'")));
    EXPECT_THAT(picture.warnings, IsEmpty()) << layer;
  }
  WriteExrSample(In("a.exr"), {{.name = "albedo"}, {.name = "rgba"}});
  EXPECT_THAT(ReadPicture(In("a.exr")).remarks, Contains(HasSubstr("part 2 of 2 (rgba)")));
  WriteExrSample(In("a.exr"), {{.name = "left"}, {.name = "right"}});
  EXPECT_THAT(ReadPicture(In("a.exr")).warnings, Contains(HasSubstr("part 1 of 2 (left), the first of 2")));
  WriteExrSample(In("a.exr"), {{.channels = {"Y", "Z"}}});
  EXPECT_NO_THROW(ReadPicture(In("a.exr"))) << "luminance and depth";
  for (const std::vector<std::string>& channels :
       {std::vector<std::string>{"N.X", "N.Y", "N.Z"}, {"Z", "motion.X", "motion.Y"}, {"X", "Y", "Z"}}) {
    WriteExrSample(In("a.exr"), {{.channels = channels}});
    ExpectRefused("a.exr", "holds no picture");
  }
}

TEST_F(PictureFiles, ColourlessExrNamesItsChannels) {
  WriteExrSample(In("depth.exr"),
                 {{.channels = {"Z", "N.X"}}, {.name = "ids", .channels = {"id"}, .type = "uint"}});
  ExpectRefused("depth.exr", "among its channels (N.X, Z, id)");
  WriteExrSample(In("ids.exr"), {{.type = "uint"}});
  ExpectRefused("ids.exr", "whole numbers (UINT)");
}

TEST_F(PictureFiles, AFileIsWholeWhereItsOwnEndIs) {
  const cv::Mat noise = [] {
    cv::Mat pixels(200, 300, CV_8UC3);
    cv::randu(pixels, 0, 255);
    return pixels;
  }();
  const std::string jpeg = JpegBytes(noise), png = PngBytes(noise), small = JpegBytes(PatchPicture());
  const std::string progressive = Encoded(".jpg", noise, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const std::string film = std::string("\0\0\0\x18", 4) + "ftypmp42" + std::string(70000, 'm'),
                    zeros(131072, '\0');
  const std::string thumbnailed = WithSegment(jpeg, ExifSegment("2026:11:29 10:11:12", 1, small));
  const std::map<std::string, std::string> whole = {{"plain.jpg", jpeg},
                                                    {"motion photo.jpg", jpeg + film},
                                                    {"a second picture behind it.jpg", jpeg + small},
                                                    {"zeros behind it.jpg", jpeg + zeros},
                                                    {"thumbnail.jpg", thumbnailed},
                                                    {"progressive.jpg", progressive + film},
                                                    {"plain.png", png},
                                                    {"trailer.png", png + film}};
  for (const auto& [name, bytes] : whole) {
    Write(name, bytes);
    EXPECT_TRUE(ImageFileIsWhole(In(name))) << name;
    EXPECT_EQ(ReadPicture(In(name)).pixels.size(), noise.size()) << name;
  }
  for (const double share : {0.1, 0.3, 0.55, 0.9, 0.999})
    for (const auto& [name, bytes] :
         std::map<std::string, std::string>{{"cut.jpg", jpeg},
                                            {"cut behind a thumbnail.jpg", thumbnailed},
                                            {"cut.png", png},
                                            {"cut progressive.jpg", progressive}}) {
      Write(name, bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
      EXPECT_FALSE(ImageFileIsWhole(In(name))) << name << " " << share;
      ExpectRefused(name, "truncated");
    }
  EXPECT_TRUE(JpegIsWhole(jpeg + film));
  EXPECT_FALSE(JpegIsWhole(thumbnailed.substr(0, thumbnailed.size() * 2 / 3)));
  EXPECT_FALSE(JpegIsWhole(small.substr(0, small.size() - 2)));
  EXPECT_FALSE(JpegIsWhole("no picture"));
}

TEST_F(PictureFiles, TransparentColoursBecomeAlpha) {
  cv::Mat bgra(40, 60, CV_8UC4, cv::Scalar(10, 20, 30, 255));
  bgra(cv::Rect(0, 0, 30, 40)).setTo(cv::Scalar(10, 20, 30, 100));
  Write("a.png", PngBytes(bgra));
  Write("a.webp", WebpBytes(bgra, 100));
  for (const char* name : {"a.png", "a.webp"}) {
    EXPECT_TRUE(HasAlphaChannel(In(name))) << name;
    const cv::Mat alpha = ReadAlpha(In(name));
    ASSERT_EQ(alpha.size(), bgra.size()) << name;
    EXPECT_EQ(cv::countNonZero(alpha), 30 * 40) << name;
    EXPECT_EQ(ReadImageFile(In(name)).channels(), 3) << name;
  }
  cv::Mat other(40, 60, CV_8UC3, cv::Scalar(1, 2, 3));
  other(cv::Rect(0, 0, 10, 40)).setTo(cv::Scalar(30, 20, 10));
  Write("key.png", WithPngChunk(PngBytes(other), "tRNS", std::string("\0\x0A\0\x14\0\x1E", 6)));
  EXPECT_EQ(cv::countNonZero(ReadAlpha(In("key.png")) == 0), 10 * 40);
}

// Blender's film that is transparent.
TEST_F(PictureFiles, ExrAlphaMasksWithoutPremultiplying) {
  WriteExrSample(In("a.exr"), {{.channels = {"A", "R", "G", "B"}, .type = "float", .alpha = 0.4F}});
  const StoredPicture picture = ReadPicture(In("a.exr"));
  EXPECT_LE(LargestPatchError(picture.pixels), 0.5);
  EXPECT_THAT(picture.notes, Contains(NoteSays("multiplied by its alpha")));
  EXPECT_TRUE(HasAlphaChannel(In("a.exr")));
  EXPECT_EQ(cv::countNonZero(ReadAlpha(In("a.exr"))), 0) << "less than half";
  WriteExrSample(In("a.exr"), {{.channels = {"A", "R", "G", "B"}}});
  EXPECT_TRUE(ReadAlpha(In("a.exr")).empty()) << "opaque";
  WriteExrSample(In("a.exr"), {{}});
  EXPECT_FALSE(HasAlphaChannel(In("a.exr")));
}

TEST_F(PictureFiles, AnotherLibraryReadsThemAlike) {
  cv::Mat deep;
  PatchPicture().convertTo(deep, CV_16U, 257);
  WritePictureFile(In("a.png"), PatchPicture());
  WritePictureFile(In("a.jpg"), PatchPicture());
  WritePictureFile(In("a.webp"), PatchPicture());
  EXPECT_EQ(cv::norm(cv::imread(In("a.png")), PatchPicture(), cv::NORM_INF), 0);
  EXPECT_LE(LargestPatchError(cv::imread(In("a.jpg"))), 4);
  EXPECT_LE(LargestPatchError(cv::imread(In("a.webp"))), 8);
  Write("deep.png", PngBytes(deep));
  EXPECT_EQ(cv::norm(cv::imread(In("deep.png"), cv::IMREAD_UNCHANGED), deep, cv::NORM_INF), 0);
  EXPECT_THROW(WritePictureFile(In("a.xyz"), PatchPicture()), Error);
  EXPECT_THROW(PngBytes(cv::Mat(2, 2, CV_32FC3)), Error);
}

}  // namespace
}  // namespace ulf::test::pictures_test
