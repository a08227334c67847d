// Tests: commands/light_field/export_light, render/quality/evened_light,
// core/light_field/exchange/exported_photographs, core/light_field/exchange/export_light_field.
//
// `ulf export FORM --light --format` on photographs of one plane with other exposures, a vignetting lens and
// a sensor's own colours.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/exif_insertion.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/jpeg_codec.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/pictures/exif_tags.h"
#include "tests/support/test_paths.h"

namespace ulf::export_light_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::array kTimes{0.005, 0.01, 0.02, 0.01, 0.005, 0.02};
constexpr double kMedianTime = 0.01, kBlack = 0.015625, kBrightness = 0.3;

// How the drawn camera records light.
struct Sensor {
  bool tells_exposures = true;
  bool is_linear = false;  // masters of 16 bits in its own colours, else 8-bit sRGB
  bool is_jpeg = false;
  double most_stops = 1;  // 0: the same exposure for all
  std::optional<std::size_t> odd =
      {};  // this photograph's exposure is not known, but its ISO by its Exif data
};

class ExportLight : public testing::Test {
 protected:
  const CameraModel camera_ = CameraModel::Pinhole(96, 72, 80);

  // The plane's light at the median exposure, in sRGB's primaries.
  cv::Mat LightAt(std::size_t i) const {
    const cv::Mat light = test::LightOfPlane(camera_, Pose(i));
    return light * kBrightness;
  }
  static Rigid3 Pose(std::size_t i) {
    return LookAt(test::CapViewpoints(static_cast<int>(kTimes.size()), 0.4, 2.0)[i], {0, 0, 0}, {0, 1, 0});
  }
  static FlatField Vignette() {
    return {.width = 96, .height = 72, .powers = {{2, 0, {-0.5, -0.5, -0.4}}, {0, 2, {-0.5, -0.5, -0.4}}}};
  }
  static double Factor(std::size_t i, const Sensor& sensor) {
    return sensor.most_stops > 0 ? kTimes[i] / kMedianTime : 1;
  }
  Frame FrameOf(std::size_t i, const Sensor& sensor) const {
    Frame frame;
    cv::Mat light = LightAt(i) * Factor(i, sensor);
    if (sensor.is_linear) {
      cv::multiply(light, Vignette().Light(96, 72), light);
      cv::divide(light, cv::Scalar(1.25, 1, 1.6), light);
      light += cv::Scalar::all(kBlack);
      light.convertTo(frame.image.pixels, CV_16U, 65535);
      frame.image.transfer = Transfer::kLinear;
      frame.black_level = kBlack;
    } else {
      frame.image = {.pixels = Srgb8FromLinear(light), .transfer = Transfer::kSrgb};
    }
    if (sensor.is_jpeg) {
      std::string jpeg = JpegBytes(frame.image.pixels, 98);
      ExifFacts facts;
      facts.iso = 800;
      if (sensor.odd == i) jpeg = WithExif(jpeg, facts).value();
      frame.encoded = EncodedImage{".jpg", std::make_shared<std::string>(jpeg)};
    }
    if (sensor.tells_exposures && sensor.odd != i) {
      frame.exposure_s = kTimes[i];
      frame.gain = 2;
      frame.f_number = 4;
    }
    frame.id = i;
    return frame;
  }
  fs::path Record(const std::string& name, const Sensor& sensor) const {
    CaptureHeader header;
    header.camera = camera_;
    header.device_maker = "Maker";
    if (sensor.is_linear) {
      header.flat_field = Vignette();
      header.color_profile = ColorProfile{.white_balance = {1.6, 1, 1.25}, .source = "drawn"};
    }
    LightFieldWriter writer = LightFieldWriter::Create(scratch_ / name, header);
    for (std::size_t i = 0; i < kTimes.size(); ++i) {
      View view;
      view.cam_from_world = Pose(i);
      writer.AddView(FrameOf(i, sensor), view);
    }
    writer.SetSubject({{0, 0, 0}, 0.3});
    writer.Close(1);
    return scratch_ / name;
  }
  test::CommandResult Run(const std::string& arguments, const fs::path& dir, const std::string& out) const {
    return test::RunUlf("export nerfstudio --known-points " + arguments + " " + dir.string() + " -o " +
                        (scratch_ / out).string());
  }
  std::vector<fs::path> Exported(const std::string& out) const {
    std::vector<fs::path> files;
    const LightField read = ReadLightField(scratch_ / out);
    for (const View& view : read.views) files.push_back(scratch_ / out / view.image_path);
    return files;
  }
  // The greatest difference of linear light from the plane's at the median exposure.
  double WorstError(std::size_t i, const cv::Mat& linear) const {
    return cv::norm(linear, LightAt(i), cv::NORM_INF);
  }

  const test::ScratchFolder scratch_;
};

cv::Mat LinearOfPng(const fs::path& file) {
  return LinearFloat({cv::imread(file.string(), cv::IMREAD_UNCHANGED), Transfer::kSrgb});
}

TEST_F(ExportLight, EvenIsThePlaneAtTheMedianExposure) {
  const fs::path dir = Record("linear", {.is_linear = true});
  const auto run = Run("--light even --format png16", dir, "png16");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output,
              testing::AllOf(HasSubstr("2.0 stops"), HasSubstr("flat field"), HasSubstr("profile")));
  ASSERT_EQ(Run("--light even --format exr", dir, "exr").exit_code, 0);
  for (std::size_t i = 0; i < kTimes.size(); ++i) {
    const fs::path png = Exported("png16")[i], exr = Exported("exr")[i];
    EXPECT_EQ(cv::imread(png.string(), cv::IMREAD_UNCHANGED).depth(), CV_16U);
    EXPECT_LT(WorstError(i, LinearOfPng(png)), 1e-3) << i;
    EXPECT_LT(WorstError(i, ReadExr(exr.string())), 1e-3) << i;
    EXPECT_EQ(ExrColorsOf(exr.string()), ExrColors(kRec709));
    EXPECT_EQ(test::ExifTagsOf(ReadWholeFile(png)), test::ExifTags{}) << "their exposures are one";
  }
}

TEST_F(ExportLight, EvenOfEightBitsIsEvenToo) {
  const fs::path dir = Record("srgb", {});
  ASSERT_EQ(Run("--light even", dir, "even").exit_code, 0);
  for (std::size_t i = 0; i < kTimes.size(); ++i) {
    const cv::Mat pixels = cv::imread(Exported("even")[i].string(), cv::IMREAD_UNCHANGED);
    EXPECT_EQ(pixels.type(), CV_8UC3);
    cv::Mat difference;
    cv::absdiff(LinearFloat({pixels, Transfer::kSrgb}), LightAt(i), difference);
    EXPECT_LT(cv::mean(difference.reshape(1))[0], 0.004) << i;
  }
}

TEST_F(ExportLight, ExrIsLinearLightAboveBlack) {
  const fs::path dir = Record("linear", {.is_linear = true}), encoded = Record("encoded", {});
  const auto run = Run("--format exr", dir, "exr");
  EXPECT_THAT(run.output, HasSubstr("the sensor's own"));
  ASSERT_EQ(Run("--format exr --light exif", encoded, "named").exit_code, 0);
  for (std::size_t i = 0; i < kTimes.size(); ++i) {
    const std::string exr = Exported("exr")[i].string(), named = Exported("named")[i].string();
    cv::Mat recorded;
    FrameOf(i, {.is_linear = true}).image.pixels.convertTo(recorded, CV_32F, 1 / 65535.0);
    EXPECT_LT(cv::norm(ReadExr(exr), recorded - cv::Scalar::all(kBlack), cv::NORM_INF), 1e-6) << i;
    EXPECT_FALSE(ExrColorsOf(exr));
    EXPECT_EQ(ExrColorsOf(named), ExrColors(kRec709));
    // An attribute is its name, its type, four bytes of length, and its value.
    const std::string bytes = ReadWholeFile(named), mark("expTime\0float\0\4\0\0\0", 18);
    const std::size_t at = bytes.find(mark);
    ASSERT_NE(at, std::string::npos);
    float seconds = 0;
    std::memcpy(&seconds, bytes.data() + at + mark.size(), sizeof seconds);
    EXPECT_FLOAT_EQ(seconds, static_cast<float>(kTimes[i]));
  }
}

TEST_F(ExportLight, MergedExposuresKeepLightBeyondWhite) {
  const fs::path dir = Record("merged", {.is_linear = true});
  const cv::Mat bright(72, 96, CV_32FC3, cv::Scalar(3, 5, 9));
  LightFieldWriter writer = LightFieldWriter::Resume(dir);
  writer.SetMerged(1, ExrBytes({{"B", bright, 0}, {"G", bright, 1}, {"R", bright, 2}}, ExrCompression::kZip),
                   3, 0);
  writer.Close(1);
  ASSERT_EQ(Run("--format exr", dir, "exr").exit_code, 0);
  EXPECT_LT(cv::norm(ReadExr(Exported("exr")[0].string()), bright, cv::NORM_INF), 1e-5);
}

TEST_F(ExportLight, ExifSaysTheExposures) {
  const fs::path jpeg = Record("jpeg", {.is_jpeg = true}), png = Record("png", {});
  ASSERT_EQ(Run("--light exif", jpeg, "copied").exit_code, 0);
  EXPECT_THAT(Run("--light exif", png, "pngs").output,
              testing::AllOf(HasSubstr("6 of 6 photographs say theirs"), HasSubstr("--format jpeg:95")));
  ASSERT_EQ(Run("--light exif --format jpeg:90", png, "made").exit_code, 0);
  for (std::size_t i = 0; i < kTimes.size(); ++i)
    for (const char* out : {"copied", "pngs", "made"}) {
      const test::ExifTags tags = test::ExifTagsOf(ReadWholeFile(Exported(out)[i]));
      EXPECT_DOUBLE_EQ(tags.numbers.at(test::kExposureTimeTag), kTimes[i]) << out;
      EXPECT_DOUBLE_EQ(tags.numbers.at(test::kFNumberTag), 4);
      EXPECT_EQ(tags.numbers.at(test::kIsoTag), 200);
      EXPECT_EQ(tags.texts.at(test::kMakeTag), "Maker");
    }
  const auto pixels = [](const fs::path& file) { return cv::imread(file.string(), cv::IMREAD_UNCHANGED); };
  const LightField source = ReadLightField(jpeg);
  EXPECT_EQ(cv::norm(pixels(Exported("copied")[0]), pixels(jpeg / source.views[0].image_path), cv::NORM_INF),
            0)
      << "the pixels are not encoded again";
}

TEST_F(ExportLight, APhotographsOwnIsoGoesBeforeAGuess) {
  const auto run = Run("--light exif", Record("odd", {.is_jpeg = true, .odd = 3}), "out");
  ASSERT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output,
              HasSubstr("5 of 6 photographs have an exposure time, 5 an f-number, 6 an ISO speed"));
  const test::ExifTags tags = test::ExifTagsOf(ReadWholeFile(Exported("out")[3]));
  EXPECT_EQ(tags.numbers.at(test::kIsoTag), 800);
  EXPECT_FALSE(tags.numbers.contains(test::kExposureTimeTag));
}

TEST_F(ExportLight, WhatNobodyKnowsIsAbsent) {
  const fs::path dir = Record("unknown", {.tells_exposures = false, .is_jpeg = true});
  const auto run = Run("--light exif", dir, "out");
  ASSERT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr("0 of 6 photographs say theirs"));
  for (const fs::path& file : Exported("out")) {
    const test::ExifTags tags = test::ExifTagsOf(ReadWholeFile(file));
    for (const int tag : {test::kExposureTimeTag, test::kFNumberTag, test::kIsoTag})
      EXPECT_FALSE(tags.numbers.contains(tag));
  }
  const auto even = Run("--light even", dir, "even");
  EXPECT_EQ(even.exit_code, 0);
  EXPECT_THAT(even.output, HasSubstr("no exposure is known"));
}

TEST_F(ExportLight, FormatsAreWhatTheySayAndTheUsualCopies) {
  const fs::path dir = Record("jpeg", {.is_jpeg = true}), png = Record("png", {});
  const LightField source = ReadLightField(dir);
  ASSERT_EQ(Run("", dir, "usual").exit_code, 0);
  ASSERT_EQ(Run("--format jpeg:95", dir, "kept").exit_code, 0);
  for (std::size_t i = 0; i < kTimes.size(); ++i)
    for (const char* out : {"usual", "kept"})
      EXPECT_EQ(ReadWholeFile(Exported(out)[i]), ReadWholeFile(dir / source.views[i].image_path)) << out;
  ASSERT_EQ(Run("--format jpeg:95", png, "good").exit_code, 0);
  ASSERT_EQ(Run("--format jpeg:30", png, "poor").exit_code, 0);
  EXPECT_EQ(Exported("good")[0].extension(), ".jpg");
  EXPECT_GT(fs::file_size(Exported("good")[0]), 2 * fs::file_size(Exported("poor")[0]));
  for (const char* wrong : {"--format tiff", "--format jpeg:0", "--format jpeg:95x", "--light bright"})
    EXPECT_EQ(Run(wrong, png, "wrong").exit_code, 2) << wrong;
}

}  // namespace
}  // namespace ulf::export_light_test
