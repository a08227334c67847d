// Tests: core/image/files/raw_file, core/image/files/dng_layout.
#include "core/image/files/raw_file.h"

#include <gmock/gmock.h>

#include <fstream>
#include <random>

#include "core/base/error.h"
#include "core/image/files/exif.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/image.h"
#include "tests/support/dng_file.h"
#include "tests/support/test_paths.h"

namespace ulf::test::raw_file_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

constexpr const char* kXtrans =
    "GBGGRG"
    "RGRBGB"
    "GBGGRG"
    "GRGGBG"
    "BGBRGR"
    "GRGGBG";

// A slope in each colour: a pixel of displacement is 0.004 of full scale.
cv::Vec3d Slopes(int x, int y) { return {0.1 + 0.004 * x, 0.5 - 0.004 * x + 0.002 * y, 0.15 + 0.005 * y}; }

// The largest difference from the truth, of full scale, away from the rim.
double WorstError(const cv::Mat& light, const cv::Mat& truth) {
  if (light.size() != truth.size() || light.type() != CV_16UC3) return 1e9;
  cv::Mat as_float;
  light.convertTo(as_float, CV_32F, 1 / 65535.0);
  const cv::Rect inside(4, 4, light.cols - 8, light.rows - 8);
  return cv::norm(as_float(inside), truth(inside), cv::NORM_INF);
}

RawPhotograph Decode(const std::string& bytes, std::optional<cv::Size> wanted = std::nullopt,
                     RawQuality quality = RawQuality::kBest) {
  return DecodeRaw(bytes, "scene.dng", quality, wanted);
}

TEST(RawFile, IsTheLightBehindTheMosaic) {
  struct Case {
    const char* pattern;
    int bits, black, white;
    // A step of the sensor, amplified by white balance and colour matrix, and the interpolation.
    double tolerance;
  };
  for (const Case& each : {Case{"RGGB", 12, 256, 4095, 0.0025}, Case{"BGGR", 12, 0, 4000, 0.0025},
                           Case{"GRBG", 14, 1024, 15871, 0.0015}, Case{"GBRG", 14, 600, 16383, 0.0015},
                           Case{"RGGB", 16, 2048, 60000, 0.0015}, Case{"BGGR", 16, 0, 65535, 0.0015}}) {
    DngCamera camera;
    camera.pattern = each.pattern;
    camera.bits = each.bits;
    camera.black = each.black;
    camera.white = each.white;
    const std::string bytes = DngBytes(camera, Slopes);
    const cv::Mat truth = LightOf(Slopes, *camera.crop);
    for (const RawQuality quality : {RawQuality::kBest, RawQuality::kQuick}) {
      const double error = WorstError(Decode(bytes, std::nullopt, quality).light, truth);
      EXPECT_LT(error, each.tolerance) << each.pattern << ", " << each.bits << " bits, black " << each.black;
    }
  }
}

// LibRaw 0.20 reads uncompressed tiles as if they were rows, and says nothing.
TEST(RawFile, ReadsUncompressedTiles) {
  for (const int bits : {12, 14, 16})
    for (const int tile : {16, 32, 48}) {
      DngCamera camera;
      camera.bits = bits;
      camera.black = 200;
      camera.white = 4000;
      camera.tile = tile;
      EXPECT_LT(WorstError(Decode(DngBytes(camera, Slopes)).light, LightOf(Slopes, *camera.crop)), 0.0025)
          << bits << " bits in tiles of " << tile;
    }
  DngCamera camera;
  camera.tile = 32;
  const std::string bytes = DngBytes(camera, Slopes);
  EXPECT_THAT([&] { Decode(bytes.substr(0, bytes.size() - 3000)); },
              ThrowsMessage<Error>(AllOf(StartsWith("scene.dng: "), HasSubstr("tiles reach beyond"))));
  const ScratchFolder folder;
  std::ofstream(folder / "a.dng", std::ios::binary) << bytes;
  EXPECT_LT(WorstError(ReadRawFile((folder / "a.dng").string()), LightOf(Slopes, *camera.crop)), 0.0015);
}

// Of a linear DNG LibRaw 0.20 subtracts the black level and scales as if there were none: 13 % too dark at a
// black level of 13 %.
TEST(RawFile, LinearFilesHaveTheirBlackLevelTakenOff) {
  struct Case {
    int bits, black, white;
    std::optional<std::array<int, 3>> blacks;
    int tile;
  };
  for (const Case& each :
       {Case{16, 0, 65535, {}, 0}, Case{16, 8000, 65535, {}, 0}, Case{16, 8000, 60000, {}, 32},
        Case{12, 256, 4095, {}, 0}, Case{16, 0, 65535, std::array{8000, 4000, 6000}, 0}}) {
    DngCamera camera;
    camera.pattern.clear();
    camera.bits = each.bits;
    camera.black = each.black;
    camera.white = each.white;
    camera.blacks = each.blacks;
    camera.tile = each.tile;
    EXPECT_LT(WorstError(Decode(DngBytes(camera, Slopes)).light, LightOf(Slopes, *camera.crop)), 0.0025)
        << each.bits << " bits, black " << each.black << ", tiles " << each.tile;
  }
}

TEST(RawFile, RefusesMosaicsThatLibRawMistakes) {
  for (const std::string pattern : {"RRGGRRGGGGBBGGBB", "RGRGGBGBRGRGGBGB"}) {
    DngCamera camera;
    camera.pattern = pattern;
    EXPECT_THAT([&] { Decode(DngBytes(camera, Slopes)); },
                ThrowsMessage<Error>(
                    AllOf(StartsWith("scene.dng: "), HasSubstr("a 4x4 mosaic"), HasSubstr("16-bit TIFF"))));
  }
  DngCamera camera;
  camera.pattern = std::string(64, 'G');
  camera.pattern[0] = 'R';
  camera.pattern[63] = 'B';
  EXPECT_THAT([&] { Decode(DngBytes(camera, Slopes)); }, ThrowsMessage<Error>(HasSubstr("8x8 mosaic")));
  for (const std::string pattern : {"RRGB", "RGBG"}) {
    camera = {};
    camera.pattern = pattern;
    EXPECT_THAT([&] { Decode(DngBytes(camera, Slopes)); },
                ThrowsMessage<Error>(HasSubstr("2x2 mosaic (" + pattern + ")")));
  }
  camera = {};
  camera.pattern = "RRRGGGRRRGGGRRRGGGGGGBBBGGGBBBGGGBBB";  // three by three alike
  EXPECT_THAT([&] { Decode(DngBytes(camera, Slopes)); }, ThrowsMessage<Error>(HasSubstr("a 6x6 mosaic")));
  camera = {};
  camera.mosaic_layout = 2;
  EXPECT_THAT([&] { Decode(DngBytes(camera, Slopes)); },
              ThrowsMessage<Error>(HasSubstr("a staggered mosaic")));
}

// LibRaw interpolates this mosaic in tiles, and refuses pictures smaller than one.
TEST(RawFile, ReadsXtrans) {
  DngCamera camera;
  camera.pattern = kXtrans;
  camera.sensor = {528, 520};
  camera.visible = {6, 0, 516, 516};
  camera.crop.reset();
  const DngLight slopes = [](int x, int y) {
    return cv::Vec3d(0.1 + 0.0008 * x, 0.6 - 0.0008 * x + 0.0004 * y, 0.15 + 0.001 * y);
  };
  const cv::Mat truth = LightOf(slopes, {0, 0, 516, 516});
  for (const RawQuality quality : {RawQuality::kBest, RawQuality::kQuick})
    EXPECT_LT(WorstError(Decode(DngBytes(camera, slopes), std::nullopt, quality).light, truth), 0.02);
}

TEST(RawFile, CamerasAndWhiteBalancesShowTheSameLight) {
  DngCamera camera;
  camera.neutral = {0.7, 1, 0.4};
  camera.matrix = {0.9, -0.3, -0.1, -0.5, 1.4, 0.1, -0.1, 0.25, 0.6};
  EXPECT_LT(WorstError(Decode(DngBytes(camera, Slopes)).light, LightOf(Slopes, *camera.crop)), 0.0015);
}

// LibRaw's better method for this mosaic refuses it.
TEST(RawFile, ReadsXtransThatIsSmallerThanATile) {
  DngCamera camera;
  camera.pattern = kXtrans;
  camera.visible = {6, 0, 96, 72};
  camera.crop.reset();
  for (const RawQuality quality : {RawQuality::kBest, RawQuality::kQuick})
    EXPECT_LT(WorstError(Decode(DngBytes(camera, Slopes), std::nullopt, quality).light,
                         LightOf(Slopes, {0, 0, 96, 72})),
              0.02);
}

// A camera whose automatic white balance changes its mind between two photographs of one thing in one light.
TEST(RawFile, LockedWhiteBalanceMakesColoursAgree) {
  DngCamera camera, other = camera;
  other.told_neutral = {0.6, 1, 0.5};
  const std::string bytes = DngBytes(camera, Slopes), other_bytes = DngBytes(other, Slopes);
  for (const RawQuality quality : {RawQuality::kBest, RawQuality::kQuick}) {
    LockedWhiteBalance locked;
    const RawPhotograph first = DecodeRaw(bytes, "a.dng", quality);
    EXPECT_FALSE(locked.WhiteBalanceFor(first.facts)) << "its own";
    const RawPhotograph as_shot = DecodeRaw(other_bytes, "b.dng", quality);
    EXPECT_GT(cv::norm(as_shot.light, first.light, cv::NORM_INF), 5000) << "the file's own is used";
    EXPECT_NEAR(as_shot.facts.white_balance[0], 1 / 0.6, 1e-3);
    const auto in_place = locked.WhiteBalanceFor(as_shot.facts);
    ASSERT_TRUE(in_place);
    EXPECT_EQ(*in_place, first.facts.white_balance);
    const cv::Mat light = DecodeRaw(other_bytes, "b.dng", quality, std::nullopt, in_place).light;
    EXPECT_LE(cv::norm(light, first.light, cv::NORM_INF), 1);
    EXPECT_LT(WorstError(light, LightOf(Slopes, *camera.crop)), 0.0015);
    EXPECT_FALSE(locked.WhiteBalanceFor(first.facts));
  }
  LockedWhiteBalance locked;
  RawFacts facts;
  facts.model = "one";
  locked.WhiteBalanceFor(facts);
  facts.white_balance = {2, 1, 1.5};
  EXPECT_TRUE(locked.WhiteBalanceFor(facts));
  facts.model = "another";
  EXPECT_FALSE(locked.WhiteBalanceFor(facts)) << "factors are those of a sensor";
}

TEST(RawFile, ALensIsTextThatCanBeWrittenDown) {
  EXPECT_EQ(ExifText(std::string_view(" AF-S 50mm f/1.8G\0junk", 22)), "AF-S 50mm f/1.8G");
  EXPECT_EQ(ExifText("---- "), "");
  EXPECT_EQ(ExifText("Objektiv \xC3\xA4 \x01"), "Objektiv ?? ?");
  DngCamera camera;
  camera.lens = "";
  EXPECT_EQ(Decode(DngBytes(camera, Slopes)).facts.exif.lens, "");
}

TEST(RawFile, TellsCameraLensAndExposure) {
  DngCamera camera;
  camera.orientation = 6;
  const ScratchFolder folder;
  const std::string path = (folder / "scene.DNG").string();
  std::ofstream(path, std::ios::binary) << DngBytes(camera, Slopes);
  EXPECT_TRUE(IsRawFile(path));
  EXPECT_TRUE(HasImageEnding(path));
  const RawFacts facts = ReadRawFacts(path);
  EXPECT_EQ(facts.size, cv::Size(96, 64));
  EXPECT_EQ(facts.visible, cv::Size(104, 80));
  EXPECT_NEAR(facts.exif.exposure_s.value_or(0), 1 / 60.0, 1e-5);
  EXPECT_NEAR(facts.exif.f_number.value_or(0), 5.6, 1e-3);
  EXPECT_NEAR(facts.exif.focal_mm.value_or(0), 35, 1e-3);
  EXPECT_EQ(facts.exif.focal_35mm, 52);
  EXPECT_EQ(facts.exif.lens, "Acme 35mm f/2");
  EXPECT_EQ(facts.exif.iso, 400);
  EXPECT_EQ(facts.exif.orientation, 6);
  EXPECT_EQ(facts.maker, "Acme");
  EXPECT_THAT(facts.model, HasSubstr("Studio 1"));
  EXPECT_TRUE(facts.has_color_matrix);
  ASSERT_TRUE(facts.has_white_balance);
  EXPECT_NEAR(facts.white_balance[0], 1 / camera.neutral[0], 1e-3);
  EXPECT_NEAR(facts.white_balance[2], 1 / camera.neutral[2], 1e-3);
  // As the sensor has it, and by every way into the file.
  EXPECT_EQ(ReadImageSize(path), cv::Size(96, 64));
  const cv::Mat light = ReadImageFile(path);
  EXPECT_LT(WorstError(light, LightOf(Slopes, *camera.crop)), 0.0015);
  EXPECT_EQ(cv::norm(light, Decode(DngBytes(camera, Slopes)).light, cv::NORM_INF), 0);
  EXPECT_EQ(TransferOfFile(path), Transfer::kLinear);
}

TEST(RawFile, IsCroppedAsByTheCameraOrCentred) {
  struct Case {
    std::optional<cv::Rect> crop;
    std::optional<cv::Size> wanted;
    cv::Rect expected;  // of the visible area
  };
  const cv::Rect of_camera(4, 8, 96, 64);
  for (const Case& each : {Case{of_camera, {}, of_camera}, Case{of_camera, cv::Size(96, 64), of_camera},
                           Case{of_camera, cv::Size(94, 62), {5, 9, 94, 62}},
                           Case{of_camera, cv::Size(104, 80), {0, 0, 104, 80}}, Case{{}, {}, {0, 0, 104, 80}},
                           Case{{}, cv::Size(100, 76), {2, 2, 100, 76}}}) {
    DngCamera camera;
    camera.crop = each.crop;
    const double error =
        WorstError(Decode(DngBytes(camera, Slopes), each.wanted).light, LightOf(Slopes, each.expected));
    EXPECT_LT(error, 0.0015) << each.expected;
  }
}

TEST(RawFile, RefusesASizeThatIsNoCrop) {
  const std::string bytes = DngBytes({}, Slopes);
  EXPECT_THAT([&] { Decode(bytes, cv::Size(48, 32)); },
              ThrowsMessage<Error>(AllOf(StartsWith("scene.dng: "), HasSubstr("96x64"), HasSubstr("104x80"),
                                         HasSubstr("48x32"), HasSubstr("JPEG"))));
  EXPECT_THAT([&] { Decode(bytes, cv::Size(64, 96)); }, ThrowsMessage<Error>(HasSubstr("turned")));
  EXPECT_THROW(Decode(bytes, cv::Size(106, 80)), Error) << "more than the sensor shows";
}

TEST(RawFile, DoesNotDependOnWhatElseThePictureShows) {
  const auto with_corner = [](double level) {
    return
        [level](int x, int y) { return x < 40 && y < 40 ? cv::Vec3d(0.2, 0.2, 0.2) : cv::Vec3d::all(level); };
  };
  for (const double others : {0.02, 0.2, 0.9}) {
    const cv::Mat light = Decode(DngBytes({}, with_corner(others))).light;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(light.at<cv::Vec3w>(10, 10)[c] / 65535.0, 0.2, 0.001) << "beside " << others;
  }
}

TEST(RawFile, SaturatedPixelsAreWhite) {
  const cv::Mat light = Decode(DngBytes({}, [](int, int) { return cv::Vec3d(4, 4, 4); })).light;
  EXPECT_EQ(light.at<cv::Vec3w>(20, 20), cv::Vec3w::all(65535));
}

TEST(RawFile, SaysWhatTheFileDoesNotTell) {
  DngCamera camera;
  camera.neutral = {0, 0, 0};
  EXPECT_FALSE(Decode(DngBytes(camera, Slopes)).facts.has_white_balance);
  camera = {};
  camera.matrix = {};
  EXPECT_FALSE(Decode(DngBytes(camera, Slopes)).facts.has_color_matrix);
}

TEST(RawFile, AFileThatIsCutShortIsAnError) {
  const std::string whole = DngBytes({}, Slopes);
  int refused = 0;
  for (std::size_t length = 0; length < whole.size(); length += length < 1200 ? 7 : 397) {
    EXPECT_THAT([&] { Decode(whole.substr(0, length)); }, ThrowsMessage<Error>(StartsWith("scene.dng: ")))
        << length << " of " << whole.size() << " bytes";
    ++refused;
  }
  EXPECT_GT(refused, 200);
  EXPECT_THROW(Decode(whole.substr(0, whole.size() - 1)), Error) << "a single byte is missing";
  EXPECT_NO_THROW(Decode(whole));
  const ScratchFolder folder;
  const auto path = folder / "cut.nef";
  std::ofstream(path, std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_THAT([&] { ReadImageFile(path.string()); },
              ThrowsMessage<Error>(AllOf(StartsWith(path.string()), HasSubstr("copy it again"))));
  EXPECT_THAT([&] { ReadRawFacts((folder / "none.nef").string()); },
              ThrowsMessage<Error>(HasSubstr("missing")));
}

// LibRaw alone would take eight bytes for each: 288 MB, where a small file may stand for 256
// (RequirePixelsOfFile).
TEST(RawFile, RefusesTooManyPixelsBeforeAllocating) {
  std::string lying = DngBytes({}, Slopes);
  const auto claim = [&](char tag, int was) {
    const std::string entry{tag, 1, 4, 0, 1, 0, 0, 0, static_cast<char>(was),
                            0,   0, 0};  // one number of 32 bits
    const std::size_t at = lying.find(entry);
    ASSERT_NE(at, std::string::npos);
    constexpr int kSide = 6000;
    lying[at + 8] = static_cast<char>(kSide & 0xff);
    lying[at + 9] = static_cast<char>(kSide >> 8);
  };
  claim(0, DngCamera{}.sensor.width);
  claim(1, DngCamera{}.sensor.height);
  EXPECT_THAT([&] { RawFactsOf(lying, "scene.dng"); },
              ThrowsMessage<Error>(AllOf(StartsWith("scene.dng: says that it holds 36 million pixels"),
                                         HasSubstr("copy it again"))));
}

TEST(RawFile, MangledFileIsAnErrorOrOfTheAskedSize) {
  const std::string whole = DngBytes({}, Slopes);
  std::mt19937 random(7);
  int pictures = 0, errors = 0;
  for (int i = 0; i < 400; ++i) {
    std::string mangled = whole;
    for (int flips = 1 + i % 4; flips > 0; --flips)
      mangled[random() % 900] = static_cast<char>(random());  // the directories
    try {
      EXPECT_EQ(Decode(mangled, cv::Size(96, 64)).light.size(), cv::Size(96, 64));
      ++pictures;
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(pictures, 20);
  EXPECT_GT(errors, 20);
}

TEST(RawFile, AnythingElseIsRefusedWithTheWayOut) {
  EXPECT_THAT([&] { Decode(std::string(100'000, 'x') + "no photograph, whatever its name says"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("LibRaw"), HasSubstr("convert it to DNG"))));
  EXPECT_FALSE(IsRawFile("photograph.jpg"));
  EXPECT_FALSE(IsRawFile("nef"));
  EXPECT_TRUE(IsRawFile("a/b.CR2"));
}

}  // namespace
}  // namespace ulf::test::raw_file_test
