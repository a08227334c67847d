// Tests: core/ffmpeg/ffmpeg_calls, core/video/video_reader, core/video/video_light, core/video/container_end.
//
// The expected colours are computed from the recommendations' own numbers, and not by FFmpeg.
#include "core/video/video_reader.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/support/test_paths.h"
#include "tests/support/video/sample_video.h"

namespace ulf::video_reader_test {
namespace {

namespace fs = std::filesystem;
using test::ScratchFolder;
using test::VideoSample;
using test::WriteVideo;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

// Weights of red and blue in luma.
struct Weights {
  double red, blue;
};
constexpr Weights kBt601{0.299, 0.114}, kBt709{0.2126, 0.0722}, kBt2020{0.2627, 0.0593};

constexpr std::array<std::array<int, 3>, 6> kPatches{
    {{200, 50, 50}, {50, 200, 50}, {50, 50, 200}, {200, 200, 50}, {128, 128, 128}, {235, 160, 120}}};

// Y'CbCr of a colour of 0 to 1, as BT.709 (3.4, 3.5) and its sisters say.
std::array<int, 3> Coded(const std::array<double, 3>& rgb, const Weights& weights, bool is_full, int bits) {
  const double luma =
      weights.red * rgb[0] + (1 - weights.red - weights.blue) * rgb[1] + weights.blue * rgb[2];
  const double cb = (rgb[2] - luma) / (2 * (1 - weights.blue)),
               cr = (rgb[0] - luma) / (2 * (1 - weights.red));
  const double scale = std::pow(2, bits - 8), most = std::pow(2, bits) - 1;
  const auto code = [&](double value, double limited_zero, double limited_range, double full_zero) {
    return static_cast<int>(
        std::lround(is_full ? full_zero + most * value : scale * (limited_zero + limited_range * value)));
  };
  return {code(luma, 16, 219, 0), code(cb, 128, 224, 128 * scale), code(cr, 128, 224, 128 * scale)};
}

VideoSample Patches(const Weights& weights, bool is_full, AVPixelFormat format, int bits, int height = 48) {
  VideoSample sample;
  sample.format = format;
  sample.width = 96;
  sample.height = height;
  sample.range = is_full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  sample.value = [=](int /*number*/, int plane, int x, int /*y*/) {
    const bool is_half = plane > 0 && (format == AV_PIX_FMT_YUV420P || format == AV_PIX_FMT_YUVJ420P ||
                                       format == AV_PIX_FMT_YUV420P10LE);
    const std::array<int, 3>& patch = kPatches[static_cast<std::size_t>(x * (is_half ? 2 : 1) / 16)];
    return Coded({patch[0] / 255.0, patch[1] / 255.0, patch[2] / 255.0}, weights, is_full,
                 bits)[static_cast<std::size_t>(plane)];
  };
  return sample;
}

std::array<int, 3> PatchOf(const Image& image, std::size_t patch) {
  const cv::Vec3b bgr = Srgb8(image).at<cv::Vec3b>(image.height() / 2, static_cast<int>(16 * patch + 8));
  return {bgr[2], bgr[1], bgr[0]};
}

void ExpectPatches(const fs::path& file, const std::string& what) {
  VideoReader reader(file);
  const auto picture = reader.Next();
  ASSERT_TRUE(picture) << what;
  EXPECT_EQ(picture->image.pixels.type(), CV_8UC3) << what;
  for (std::size_t patch = 0; patch < kPatches.size(); ++patch)
    for (std::size_t channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(PatchOf(picture->image, patch)[channel], kPatches[patch][channel], 2)
          << what << ", patch " << patch << ", channel " << channel;
}

TEST(VideoReader, ColoursAreAsTheStreamNamesThem) {
  const ScratchFolder scratch;
  const fs::path file = scratch / "video.mkv";
  for (const auto& [weights, matrix, name] :
       {std::tuple(kBt601, AVCOL_SPC_SMPTE170M, "BT.601"),
        std::tuple(kBt601, AVCOL_SPC_BT470BG, "BT.601 of 625 lines"),
        std::tuple(kBt709, AVCOL_SPC_BT709, "BT.709"), std::tuple(kBt2020, AVCOL_SPC_BT2020_NCL, "BT.2020")})
    for (const bool is_full : {false, true})
      for (const auto& [format, bits] :
           {std::pair(AV_PIX_FMT_YUV420P, 8), std::pair(AV_PIX_FMT_YUV444P, 8),
            std::pair(AV_PIX_FMT_YUV420P10LE, 10), std::pair(AV_PIX_FMT_YUV444P12LE, 12)}) {
        VideoSample sample = Patches(weights, is_full, format, bits);
        sample.matrix = matrix;
        WriteVideo(file, sample);
        ExpectPatches(file, fmt::format("{}, {}, {} bits", name, is_full ? "full" : "limited", bits));
      }
}

TEST(VideoReader, UnnamedColoursAreTakenAsPlayersDo) {
  const ScratchFolder scratch;
  const fs::path file = scratch / "video.mkv";
  for (const auto& [weights, height, name] :
       {std::tuple(kBt601, 576, "BT.601"), std::tuple(kBt709, 720, "BT.709")}) {
    VideoSample sample = Patches(weights, false, AV_PIX_FMT_YUV420P, 8, height);
    sample.range = AVCOL_RANGE_UNSPECIFIED;
    WriteVideo(file, sample);
    ExpectPatches(file, name);
    EXPECT_THAT(VideoReader(file).Facts().notes, Contains(AllOf(HasSubstr("does not say"), HasSubstr(name))));
  }
}

TEST(VideoReader, FullRangeByItsLayoutAndRgb) {
  const ScratchFolder scratch;
  VideoSample jpeg = Patches(kBt601, true, AV_PIX_FMT_YUVJ420P, 8);
  jpeg.encoder = "mjpeg";
  WriteVideo(scratch / "jpeg.avi", jpeg);
  ExpectPatches(scratch / "jpeg.avi", "Motion JPEG");
  for (const auto& [format, most] :
       {std::pair(AV_PIX_FMT_GBRP9LE, 511), std::pair(AV_PIX_FMT_GBRP10LE, 1023),
        std::pair(AV_PIX_FMT_GBRP12LE, 4095), std::pair(AV_PIX_FMT_GBRP16LE, 65535),
        std::pair(AV_PIX_FMT_GBRAP12LE, 4095)})
    for (const AVColorSpace matrix : {AVCOL_SPC_UNSPECIFIED, AVCOL_SPC_RGB, AVCOL_SPC_BT709}) {
      VideoSample rgb;
      rgb.format = format;
      rgb.matrix = matrix;
      rgb.width = 96;
      rgb.value = [most = most](int /*number*/, int plane, int x, int /*y*/) {
        constexpr std::array<std::size_t, 3> kChannel{1, 2, 0};
        if (plane == 3) return most / 2;
        const int value =
            kPatches[static_cast<std::size_t>(x / 16)][kChannel[static_cast<std::size_t>(plane)]];
        return static_cast<int>(std::lround(value * most / 255.0));
      };
      WriteVideo(scratch / "rgb.mkv", rgb);
      ExpectPatches(scratch / "rgb.mkv",
                    fmt::format("RGB up to {}, matrix {}", most, static_cast<int>(matrix)));
      EXPECT_THAT(VideoReader(scratch / "rgb.mkv").Facts().notes,
                  format == AV_PIX_FMT_GBRAP12LE ? Contains(HasSubstr("alpha")).Times(1)
                                                 : Contains(HasSubstr("alpha")).Times(0));
    }
}

// A grey value is stored in limited range where the stream says so, and from black to white otherwise.
TEST(VideoReader, GreyHasTheRangeThatTheStreamNames) {
  const ScratchFolder scratch;
  for (const auto& [format, bits] :
       {std::pair(AV_PIX_FMT_GRAY8, 8), std::pair(AV_PIX_FMT_GRAY9LE, 9), std::pair(AV_PIX_FMT_GRAY10LE, 10),
        std::pair(AV_PIX_FMT_GRAY12LE, 12), std::pair(AV_PIX_FMT_GRAY16LE, 16)})
    for (const AVColorRange range : {AVCOL_RANGE_UNSPECIFIED, AVCOL_RANGE_JPEG, AVCOL_RANGE_MPEG}) {
      VideoSample sample;
      sample.format = format;
      sample.range = range;
      sample.width = 96;
      const double most = std::pow(2, bits) - 1, step = std::pow(2, bits - 8);
      sample.value = [=](int /*number*/, int /*plane*/, int x, int /*y*/) {
        const int level = kPatches[static_cast<std::size_t>(x / 16)][0];
        return static_cast<int>(
            std::lround(range == AVCOL_RANGE_MPEG ? step * (16 + level * 219 / 255.0) : level * most / 255));
      };
      WriteVideo(scratch / "grey.mkv", sample);
      VideoReader reader(scratch / "grey.mkv");
      const auto picture = reader.Next();
      ASSERT_TRUE(picture);
      for (std::size_t patch = 0; patch < kPatches.size(); ++patch)
        for (const int channel : PatchOf(picture->image, patch))
          EXPECT_NEAR(channel, kPatches[patch][0], 1)
              << bits << " bits, range " << range << ", patch " << patch;
      EXPECT_THAT(reader.Facts().notes, range == AVCOL_RANGE_UNSPECIFIED
                                            ? Contains(HasSubstr("range")).Times(1)
                                            : Contains(HasSubstr("range")).Times(0));
    }
}

TEST(VideoReader, RefusesOtherColourCodingsByName) {
  const ScratchFolder scratch;
  for (const auto& [matrix, name] :
       {std::pair(AVCOL_SPC_YCGCO, "ycgco"), std::pair(AVCOL_SPC_ICTCP, "ictcp")}) {
    VideoSample sample = Patches(kBt709, false, AV_PIX_FMT_YUV444P, 8);
    sample.matrix = matrix;
    WriteVideo(scratch / "video.mkv", sample);
    EXPECT_THAT(
        [&] { VideoReader(scratch / "video.mkv"); },
        ThrowsMessage<Error>(AllOf(HasSubstr("video.mkv: its colours are coded as"), HasSubstr(name))));
  }
  VideoSample dolby = Patches(kBt709, false, AV_PIX_FMT_YUV444P, 8);
  dolby.matrix = AVCOL_SPC_BT709;
  dolby.dolby_vision_profile = 5;
  WriteVideo(scratch / "video.mkv", dolby);
  EXPECT_THAT(
      [&] { VideoReader(scratch / "video.mkv"); },
      ThrowsMessage<Error>(AllOf(HasSubstr("Dolby Vision (profile 5)"), HasSubstr("export it again"))));
  for (const int profile : {4, 7, 8}) {  // 4 says of no other standard that it is one, and has its tags
    dolby.dolby_vision_profile = profile;
    WriteVideo(scratch / "video.mkv", dolby);
    ExpectPatches(scratch / "video.mkv", "a base layer that others read");
  }
  VideoSample sample = Patches(kBt2020, false, AV_PIX_FMT_YUV444P, 8);
  sample.matrix = AVCOL_SPC_BT2020_CL;
  WriteVideo(scratch / "video.mkv", sample);
  ExpectPatches(scratch / "video.mkv", "constant luminance");
  EXPECT_THAT(VideoReader(scratch / "video.mkv").Facts().warnings, Contains(HasSubstr("constant luminance")));
}

// A gray of linear light L has the signal that BT.2100 gives it; a colour of BT.2020's primaries becomes
// one of sRGB's.
TEST(VideoReader, HighDynamicRangeIsLinearLight) {
  const ScratchFolder scratch;
  const fs::path file = scratch / "video.mkv";
  const auto pq = [](double nits) {
    const double power = std::pow(nits / 10000, 0.1593017578125);
    return std::pow((0.8359375 + 18.8515625 * power) / (1 + 18.6875 * power), 78.84375);
  };
  const auto hlg = [](double scene) {
    return scene <= 1.0 / 12 ? std::sqrt(3 * scene)
                             : 0.17883277 * std::log(12 * scene - 0.28466892) + 0.55991073;
  };
  const std::array<double, 4> lights{0.05, 0.18, 1, 2.5};
  for (const bool is_pq : {true, false}) {
    VideoSample sample;
    sample.format = AV_PIX_FMT_YUV420P10LE;
    sample.matrix = AVCOL_SPC_BT2020_NCL;
    sample.primaries = AVCOL_PRI_BT2020;
    sample.range = AVCOL_RANGE_MPEG;
    sample.curve = is_pq ? AVCOL_TRC_SMPTE2084 : AVCOL_TRC_ARIB_STD_B67;
    sample.value = [&](int /*number*/, int plane, int x, int /*y*/) {
      const double light = lights[static_cast<std::size_t>(x / (plane > 0 ? 8 : 16))];
      constexpr double kPaperScene = 0.26496;  // the scene's light of 75 % of the signal
      const double signal = is_pq ? pq(203 * light) : hlg(kPaperScene * light);
      return Coded({signal, signal, signal}, kBt2020, false, 10)[static_cast<std::size_t>(plane)];
    };
    WriteVideo(file, sample);
    VideoReader reader(file);
    EXPECT_THAT(reader.Facts().notes, Contains(HasSubstr(is_pq ? "(PQ)" : "(HLG)")));
    const auto picture = reader.Next();
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->image.transfer, Transfer::kLinear);
    ASSERT_EQ(picture->image.pixels.type(), CV_32FC3);
    for (std::size_t i = 0; i < lights.size(); ++i)
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(
            picture->image.pixels.at<cv::Vec3f>(24, static_cast<int>(16 * i + 8))[channel] / lights[i], 1,
            0.03)
            << (is_pq ? "PQ " : "HLG ") << lights[i];
  }
}

// sRGB's green (0, 1, 0) at half light, in BT.2020's primaries (BT.2087, inverted).
TEST(VideoReader, WiderPrimariesBecomeThoseOfSrgb) {
  const ScratchFolder scratch;
  const std::array<double, 3> linear{0.329283 * 0.5, 0.919540 * 0.5, 0.088013 * 0.5};
  std::array<double, 3> signal{};
  for (std::size_t i = 0; i < 3; ++i) signal[i] = SrgbFromLinear(static_cast<float>(linear[i]));
  VideoSample sample;
  sample.format = AV_PIX_FMT_YUV444P10LE;
  sample.matrix = AVCOL_SPC_BT2020_NCL;
  sample.primaries = AVCOL_PRI_BT2020;
  sample.range = AVCOL_RANGE_MPEG;
  sample.curve = AVCOL_TRC_BT2020_10;
  sample.value = [&](int /*number*/, int plane, int /*x*/, int /*y*/) {
    return Coded(signal, kBt2020, false, 10)[static_cast<std::size_t>(plane)];
  };
  WriteVideo(scratch / "video.mkv", sample);
  const auto picture = VideoReader(scratch / "video.mkv").Next();
  ASSERT_TRUE(picture);
  const cv::Vec3b bgr = picture->image.pixels.at<cv::Vec3b>(20, 20);
  EXPECT_LE(bgr[0], 12);
  EXPECT_NEAR(bgr[1], std::lround(255 * SrgbFromLinear(0.5F)), 2);
  EXPECT_LE(bgr[2], 12);
}

// A bright corner at the stored top left, a gray one at the top right.
VideoSample Corners() {
  VideoSample sample;
  sample.encoder = "mpeg4";
  sample.width = 64;
  sample.height = 32;
  sample.value = [](int /*number*/, int plane, int x, int y) {
    if (plane > 0) return 128;
    return y >= 16 ? 16 : x < 16 ? 235 : x >= 48 ? 126 : 16;
  };
  return sample;
}

TEST(VideoReader, PicturesAreTurnedOnceAsTheFileAsks) {
  const ScratchFolder scratch;
  const fs::path file = scratch / "video.mp4";
  // Where the corners are then: left or right, top or bottom.
  struct Case {
    std::array<int, 4> matrix;
    bool is_upright_size, bright_right, bright_bottom, gray_right, gray_bottom;
    const char* said;
  };
  for (const Case& each :
       {Case{{1, 0, 0, 1}, true, false, false, true, false, ""},
        Case{{0, 1, -1, 0}, false, true, false, true, true, "90 degrees clockwise as"},
        Case{{-1, 0, 0, -1}, true, true, true, false, true, "180 degrees clockwise as"},
        Case{{0, -1, 1, 0}, false, false, true, false, false, "270 degrees clockwise as"},
        Case{{-1, 0, 0, 1}, true, true, false, false, false, "mirrored"},
        Case{{1, 0, 0, -1}, true, false, true, true, true, "180 degrees clockwise and mirrored"},
        Case{{0, 1, 1, 0}, false, false, false, false, true, "mirrored"},
        Case{{0, -1, -1, 0}, false, true, true, true, false, "mirrored"}}) {
    VideoSample sample = Corners();
    sample.display_matrix = each.matrix;
    WriteVideo(file, sample);
    VideoReader reader(file);
    EXPECT_EQ(reader.Facts().width, each.is_upright_size ? 64 : 32);
    const auto picture = reader.Next();
    ASSERT_TRUE(picture);
    const cv::Mat& pixels = picture->image.pixels;
    EXPECT_EQ(pixels.cols, reader.Facts().width);
    EXPECT_EQ(pixels.rows, reader.Facts().height);
    const auto corner = [&](bool right, bool bottom) {
      return pixels.at<cv::Vec3b>(bottom ? pixels.rows - 4 : 3, right ? pixels.cols - 4 : 3)[1];
    };
    const std::string which = each.said;
    EXPECT_GT(corner(each.bright_right, each.bright_bottom), 240) << which;
    EXPECT_NEAR(corner(each.gray_right, each.gray_bottom), 128, 12) << which;
    if (!which.empty()) {
      EXPECT_THAT(reader.Facts().notes, Contains(AllOf(HasSubstr(which), HasSubstr("calibration")))) << which;
    }
  }
}

TEST(VideoReader, RefusesPanoramasAndStereoPairs) {
  constexpr int kFlat = 0, kSideBySide = 1, kTopBottom = 2;  // AVStereo3DType
  constexpr int kEquirectangular = 0, kCube = 1;             // AVSphericalProjection
  const ScratchFolder scratch;
  const fs::path file = scratch / "a.mkv";
  VideoSample sample = Patches(kBt709, false, AV_PIX_FMT_YUV420P, 8);
  const auto expect_refused = [&](const std::string& words, const std::string& way_out) {
    WriteVideo(file, sample);
    EXPECT_THAT([&] { VideoReader reader(file); },
                ThrowsMessage<Error>(AllOf(HasSubstr(file.string()), HasSubstr(words), HasSubstr(way_out))));
  };
  sample.stereo = kFlat;
  WriteVideo(file, sample);
  EXPECT_EQ(VideoReader(file).Facts().width, 96);
  sample.stereo = kSideBySide;
  expect_refused("stereo pairs, side by side", "crop=iw/2:ih");
  sample.stereo = kTopBottom;
  expect_refused("stereo pairs, one above the other", "crop=iw:ih/2");
  sample.stereo = -1;
  sample.spherical = kEquirectangular;
  expect_refused("is a panorama", "v360=e:flat:h_fov=90:v_fov=90:w=1500:h=1500:yaw=0 OUT%05d.png");
  sample.spherical = kCube;
  expect_refused("is a panorama", "Hugin");
}

TEST(VideoReader, TheAspectOfAPixelTurnsWithThePicture) {
  const ScratchFolder scratch;
  VideoSample sample = Corners();
  sample.aspect_num = 4;
  sample.aspect_den = 3;
  WriteVideo(scratch / "video.mp4", sample);
  EXPECT_NEAR(VideoReader(scratch / "video.mp4").Facts().pixel_aspect, 4.0 / 3, 1e-3);
  sample.display_matrix = {0, 1, -1, 0};
  WriteVideo(scratch / "turned.mp4", sample);
  EXPECT_NEAR(VideoReader(scratch / "turned.mp4").Facts().pixel_aspect, 3.0 / 4, 1e-3);
}

// The later lines are bright: none of them is left.
TEST(VideoReader, InterlacedPicturesShowEarlierLines) {
  const ScratchFolder scratch;
  VideoSample sample = Corners();
  sample.encoder = "mpeg2video";
  sample.is_interlaced = true;
  sample.value = [](int /*number*/, int plane, int /*x*/, int y) {
    return plane > 0 ? 128 : y % 2 ? 200 : 60;
  };
  WriteVideo(scratch / "video.mkv", sample);
  VideoReader reader(scratch / "video.mkv");
  EXPECT_THAT(reader.Facts().warnings, Contains(HasSubstr("interlaced")));
  const auto picture = reader.Next();
  ASSERT_TRUE(picture);
  double least = 0, most = 0;
  cv::minMaxLoc(picture->image.pixels.reshape(1), &least, &most);
  EXPECT_NEAR(least, 51, 8);
  EXPECT_NEAR(most, 51, 8);
}

std::size_t Count(VideoReader& reader) {
  std::size_t count = 0;
  while (reader.Next()) ++count;
  return count;
}

TEST(VideoReader, TimesAreTheContainers) {
  const ScratchFolder scratch;
  VideoSample sample = Corners();
  sample.times = {3, 4, 8, 9, 20};
  WriteVideo(scratch / "video.mkv", sample);
  VideoReader reader(scratch / "video.mkv");
  for (const int time : sample.times) {
    const auto picture = reader.Next();
    ASSERT_TRUE(picture);
    EXPECT_NEAR(picture->time_s, (time - 3) / 25.0, 0.002);
  }
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.Problem(), "") << "fewer pictures than duration times rate";
}

TEST(VideoReader, AFileThatIsCutIsNamedAndAWholeOneIsNot) {
  const ScratchFolder scratch;
  VideoSample sample = Corners();
  sample.pictures = 40;
  sample.value = [](int number, int plane, int x, int y) {
    return plane > 0 ? 128 : (x * 7 + y * 13 * number) % 200 + 20;
  };
  for (const char* name : {"video.mp4", "video.mkv", "video.avi"}) {
    const fs::path file = scratch / name;
    WriteVideo(file, sample);
    VideoReader whole(file);
    EXPECT_EQ(Count(whole), 40u) << name;
    EXPECT_EQ(whole.Problem(), "") << name;
    fs::resize_file(file, fs::file_size(file) * 2 / 3);
    if (std::string(name) == "video.mp4") {  // its index stood at the end
      EXPECT_THAT([&] { VideoReader reader(file); },
                  ThrowsMessage<Error>(AllOf(HasSubstr("its end is missing"), HasSubstr("copy it again"))));
      continue;
    }
    VideoReader cut(file);
    EXPECT_LT(Count(cut), 40u) << name;
    EXPECT_THAT(cut.Problem(), HasSubstr("its end is missing")) << name;
  }
}

TEST(VideoReader, NamesPicturesOfAnotherSize) {
  const ScratchFolder scratch;
  std::string stream;
  for (const int width : {64, 96, 64}) {
    VideoSample sample = Corners();
    sample.encoder = "mpeg2video";
    sample.width = width;
    WriteVideo(scratch / "part.m2v", sample);
    stream += ReadWholeFile(scratch / "part.m2v");
  }
  WriteFileAtomically(scratch / "video.m2v", stream);
  VideoReader reader(scratch / "video.m2v");
  EXPECT_GE(Count(reader), 9u);
  EXPECT_THAT(reader.Problem(), AllOf(HasSubstr("some are 96x32"), HasSubstr("pictures left out")));
}

TEST(VideoReader, TagsThatChangeOnTheWayAreFollowed) {
  const ScratchFolder scratch;
  std::string joined;
  for (const auto& [weights, matrix] :
       {std::pair(kBt709, AVCOL_SPC_BT709), std::pair(kBt601, AVCOL_SPC_SMPTE170M)}) {
    VideoSample sample = Patches(weights, false, AV_PIX_FMT_YUV420P, 8);
    sample.encoder = "libx264";
    sample.matrix = matrix;
    WriteVideo(scratch / "part.ts", sample);
    joined += ReadWholeFile(scratch / "part.ts");
  }
  std::ofstream(scratch / "video.ts", std::ios::binary) << joined;
  VideoReader reader(scratch / "video.ts");
  int pictures = 0;
  for (auto picture = reader.Next(); picture; picture = reader.Next(), ++pictures)
    for (std::size_t patch = 0; patch < kPatches.size(); ++patch)
      for (std::size_t channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(PatchOf(picture->image, patch)[channel], kPatches[patch][channel], 2) << pictures;
  EXPECT_EQ(pictures, 10);
}

TEST(VideoReader, TagsThatContradictThePixelsAreNamed) {
  const ScratchFolder scratch;
  VideoSample sample = Patches(kBt601, false, AV_PIX_FMT_YUV420P, 8);
  sample.matrix = AVCOL_SPC_RGB;
  WriteVideo(scratch / "video.mkv", sample);
  ExpectPatches(scratch / "video.mkv", "as if nothing were said");
  EXPECT_THAT(VideoReader(scratch / "video.mkv").Facts().warnings,
              Contains(HasSubstr("colour matrix (gbr)")));
}

TEST(VideoReader, AVideoWithoutAKeyFrameIsNamed) {
  const ScratchFolder scratch;
  for (const char* name : {"video.mkv", "video.mp4"}) {
    VideoSample sample = Corners();
    sample.encoder = "libx264";
    sample.pictures = 20;
    sample.drops_key_frames = true;
    WriteVideo(scratch / name, sample);
    EXPECT_THAT(
        [&] {
          VideoReader reader(scratch / name);
          Count(reader);
        },
        ThrowsMessage<Error>(AllOf(HasSubstr(name), HasSubstr("no picture"))))
        << name;
  }
}

TEST(VideoReader, NamesFilesThatAreNoVideo) {
  const ScratchFolder scratch;
  std::ofstream(scratch / "text.mp4") << "no video at all";
  EXPECT_THAT([&] { VideoReader reader(scratch / "text.mp4"); },
              ThrowsMessage<Error>(HasSubstr("is no video")));
  cv::imwrite((scratch / "picture.png").string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_THAT(
      [&] { VideoReader reader(scratch / "picture.png"); },
      ThrowsMessage<Error>(AllOf(HasSubstr("is one picture and no video"), HasSubstr("name the folder"))));
  std::ofstream(scratch / "read_me.txt") << "FFmpeg draws a text as a terminal would have shown it.\n";
  EXPECT_THAT([&] { VideoReader reader(scratch / "read_me.txt"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("read_me.txt: is no video"), HasSubstr("name a video"))));
  std::ofstream(scratch / "list.m3u8") << "#EXTM3U\n#EXTINF:1,\nhttp://localhost:9/a.ts\n";
  EXPECT_THROW(VideoReader reader(scratch / "list.m3u8"), Error) << "no address is asked";
}

}  // namespace
}  // namespace ulf::video_reader_test
