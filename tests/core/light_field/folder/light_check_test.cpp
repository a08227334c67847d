// Tests: core/light_field/folder/light_check, core/light_field/folder/light_at_points,
// core/image/color_profile.
#include "core/light_field/folder/light_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <string>

#include "core/base/atomic_file.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/tiff_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "tests/core/light_field/simulated_session.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::light_check_test {
namespace {

using testing::HasSubstr;

std::string Uri(const std::string& scene, unsigned seed, const std::string& more = "") {
  return fmt::format("sim:{}?width=320&height=240&seed={}&speed_deg_s=8{}", scene, seed, more);
}

std::string AllWords(const LightCheck& check) {
  std::string words;
  for (const LampDrift& drift : check.drifts) words += drift.Words() + "; ";
  return words;
}

const LampDrift* Of(const LightCheck& check, LampDrift::Kind kind) {
  const auto found = std::ranges::find(check.drifts, kind, &LampDrift::kind);
  return found == check.drifts.end() ? nullptr : &*found;
}

// A session of the studio, seed 1, for all that look at it: rendering one is most of a check's time.
LightField StudioSession(const std::string& more = "") {
  static const test::ScratchFolder scratch;
  static std::map<std::string, LightField> sessions;
  const auto [at, is_new] = sessions.try_emplace(more);
  if (is_new)
    at->second =
        test::WriteSimulatedSession(scratch / std::to_string(sessions.size()), Uri("studio", 1, more));
  return at->second;
}

// Scenes with a glazed sphere, and with vases that mirror the lamps.
TEST(LightCheck, FindsNothingWhereNothingChanged) {
  for (const unsigned seed : test::SeedsOf({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}))
    for (const char* scene : {"studio", "gloss"}) {
      test::ScratchFolder scratch;
      const LightCheck check =
          CheckLight(seed == 1 && scene == std::string("studio")
                         ? StudioSession()
                         : test::WriteSimulatedSession(scratch / "lf", Uri(scene, seed)));
      EXPECT_EQ(check.not_compared, "");
      EXPECT_GT(check.compared, 30u) << scene << ", seed " << seed;
      EXPECT_EQ(AllWords(check), "") << scene << ", seed " << seed;
      EXPECT_THAT(check.fluctuations, testing::IsEmpty()) << scene << ", seed " << seed;
    }
}

// Over a minute, between the means of the halves: half of what the lamp drifts by.
TEST(LightCheck, NoticesALampThatGrowsBrighter) {
  for (const unsigned seed : test::SeedsOf({1, 2, 3, 4, 5, 6, 7, 8, 9, 10})) {
    test::ScratchFolder scratch;
    const LightCheck check = CheckLight(
        seed == 1 ? StudioSession("&fault=drift=-0.4")
                  : test::WriteSimulatedSession(scratch / "lf", Uri("studio", seed, "&fault=drift=-0.4")));
    const LampDrift* drift = Of(check, LampDrift::Kind::kBrightness);
    ASSERT_TRUE(drift) << "seed " << seed;
    EXPECT_NEAR(drift->difference, -0.5 * 0.4 * M_LN2, 0.01) << "seed " << seed;
    EXPECT_THAT(drift->Words(), HasSubstr("darker than views 1 to ")) << "seed " << seed;
    EXPECT_EQ(check.drifts.size(), 1u) << AllWords(check);
  }
}

TEST(LightCheck, NoticesALampThatGrowsBluer) {
  for (const unsigned seed : test::SeedsOf({1, 2, 3, 4, 5, 6, 7, 8, 9, 10})) {
    test::ScratchFolder scratch;
    const LightCheck check =
        CheckLight(test::WriteSimulatedSession(scratch / "lf", Uri("studio", seed, "&fault=bluer=0.15")));
    const LampDrift* drift = Of(check, LampDrift::Kind::kBlueness);
    ASSERT_TRUE(drift) << "seed " << seed << ": " << AllWords(check);
    EXPECT_NEAR(drift->difference, 0.5 * 2 * 0.15 * M_LN2, 0.01) << "seed " << seed;
    EXPECT_THAT(drift->Words(), HasSubstr("% bluer than views 1 to ")) << "seed " << seed;
    EXPECT_FALSE(Of(check, LampDrift::Kind::kBrightness)) << "seed " << seed;
  }
}

// An exposure that the camera reports is no lamp.
TEST(LightCheck, TakesReportedExposuresIntoAccount) {
  LightField light_field = StudioSession("&fault=drift=-0.4");
  EXPECT_TRUE(Of(CheckLight(light_field), LampDrift::Kind::kBrightness));
  for (View& view : light_field.views) view.exposure_s *= std::exp2(-0.4 * view.device_time_s / 60);
  EXPECT_EQ(AllWords(CheckLight(light_field)), "");
}

// "The same from the first to the last" would be false.
TEST(LightCheck, SaysWhatGoesUpAndDown) {
  LightField light_field = StudioSession();
  EXPECT_THAT(CheckLight(light_field).fluctuations, testing::IsEmpty());
  for (View& view : light_field.views) view.exposure_s *= std::exp2(0.25 * std::sin(2 * M_PI * view.id / 10));
  const LightCheck check = CheckLight(light_field);
  EXPECT_EQ(AllWords(check), "") << "no part differs for good";
  ASSERT_EQ(check.fluctuations.size(), 1u);
  EXPECT_EQ(check.fluctuations[0].kind, LampDrift::Kind::kBrightness);
  EXPECT_NEAR(check.fluctuations[0].spread, 2 * 0.25 * M_LN2, 0.05);
  EXPECT_EQ(check.fluctuations[0].Words().find("brightness goes up and down by "), 0u);
}

TEST(LightCheck, SaysWhereItCannotCompare) {
  test::ScratchFolder scratch;
  LightField light_field = test::WriteSimulatedSession(scratch / "lf", Uri("studio", 1),
                                                       {.views = 12, .seconds = 20, .points = 50});
  light_field.points.clear();
  const LightCheck check = CheckLight(light_field);
  EXPECT_THAT(check.not_compared, HasSubstr("ulf refine"));
  EXPECT_EQ(check.views, 12u);
}

// As an import and every other reader do.
TEST(LightCheck, NamesPhotographsThatAreCut) {
  test::ScratchFolder scratch;
  LightField light_field = test::TrackedLightField(scratch / "lf", {CameraModel::Pinhole(96, 64, 90)}, 110);
  cv::Mat light(64, 96, CV_32FC3, cv::Scalar(0.1, 0.2, 0.3));
  std::set<int> cut;
  const auto put = [&](std::size_t view, const char* ending, const std::string& bytes) {
    View& changed = light_field.views[view];
    changed.image_path = fmt::format("images/other{}{}", view, ending);
    WriteFileAtomically(light_field.root / changed.image_path, bytes.substr(0, bytes.size() / 2));
    cut.insert(changed.id);
  };
  cv::Mat noise(64, 96, CV_8UC3);
  cv::randu(noise, 0, 255);
  put(0, ".jpg", JpegBytes(noise));
  put(1, ".png", PngBytes(noise));
  put(2, ".exr", ExrBytes({{"B", light, 0}, {"G", light, 1}, {"R", light, 2}}, ExrCompression::kZip));
  put(3, ".tif", [&] {
    const FileContent content = TiffContent(noise);
    std::string bytes(content.size, '\0');
    content.copy(0, bytes);
    return bytes;
  }());
  // Of a hundred views that the check reads these are none: 10, 21, 32 ... of 110.
  put(10, ".jpg", JpegBytes(noise));
  const LightCheck check = CheckLight(light_field);
  EXPECT_EQ(check.views, 96u);
  std::set<int> named;
  for (const auto& [id, why] : check.unread) {
    named.insert(id);
    EXPECT_THAT(why, HasSubstr("images/other"));
  }
  EXPECT_EQ(named, cut);
}

TEST(LightCheck, CountsWhatIsClipped) {
  test::ScratchFolder scratch;
  const LightField light_field = test::WriteSimulatedSession(
      scratch / "lf", Uri("studio", 1, "&exposure_us=12000"), {.views = 12, .seconds = 20, .points = 50});
  const LightCheck check = CheckLight(light_field);
  std::uint64_t clipped = 0;
  for (const View& view : light_field.views) {
    cv::Mat full;
    const cv::Mat at_254 = ReadViewMaster(light_field, view).pixels >= 254;
    cv::reduce(at_254.reshape(1, 320 * 240), full, 1, cv::REDUCE_MAX);
    clipped += static_cast<std::uint64_t>(cv::countNonZero(full));
  }
  EXPECT_GT(clipped, 1000u);
  EXPECT_EQ(check.clipped_px, clipped);
  EXPECT_EQ(check.pixels, 12u * 320 * 240);
  EXPECT_GT(check.most_clipped_share, static_cast<double>(clipped) / (12 * 320 * 240));
  EXPECT_NE(check.most_clipped_view, 0);
}

// A lamp and filters that are known, and the profile that undoes them, kept by the light field: its light
// is the scene's.
TEST(ColorProfile, RestoresTheScenesLight) {
  const std::string sensor = "&lamp_k=3200&crosstalk=0.2&format=bayerrg12&noise=0&exposure_us=1500";
  const acquisition::SensorColors colors{.lamp_k = 3200, .crosstalk = 0.2};
  const Eigen::Vector3d balance = colors.WhiteBalance();
  const Eigen::Matrix3d matrix = colors.SrgbFromBalanced();
  ColorProfile profile{.white_balance = {balance[0], balance[1], balance[2]}};
  for (int i = 0; i < 9; ++i) profile.matrix[static_cast<std::size_t>(i)] = matrix(i / 3, i % 3);
  const test::SessionOptions few{.views = 3, .seconds = 4, .points = 0};
  const auto error = [&](const std::optional<ColorProfile>& known) {
    test::ScratchFolder scratch;
    test::SessionOptions options = few;
    options.color_profile = known;
    test::WriteSimulatedSession(scratch / "lf", Uri("studio", 3, sensor), options);
    const LightField light_field = ReadLightField(scratch / "lf");  // from the journal
    EXPECT_EQ(light_field.color_profiles.contains(0), known.has_value());
    const acquisition::SimulatedCamera truth_camera(acquisition::SimulationOptions::FromUri(
        DeviceUri::Parse(Uri("studio", 3, "&noise=0&exposure_us=1500"))));
    const double white = (colors.CameraFromSrgb() * Eigen::Vector3d::Ones())[1];
    double worst = 0;
    for (const View& view : light_field.views) {
      const cv::Mat light = LinearFloat(ReadViewLight(light_field, view));
      const cv::Mat truth = truth_camera.CleanLinear(view.cam_from_world) * white;
      cv::Mat a, b, difference;  // motion blur and the mosaic's edges are not the colours'
      cv::resize(light, a, {16, 12}, 0, 0, cv::INTER_AREA);
      cv::resize(truth, b, {16, 12}, 0, 0, cv::INTER_AREA);
      cv::absdiff(a, b, difference);
      for (const double mean : {cv::mean(difference)[0], cv::mean(difference)[1], cv::mean(difference)[2]})
        worst = std::max(worst, mean / cv::mean(b)[1]);
    }
    return worst;
  };
  EXPECT_LT(error(profile), 0.02);
  EXPECT_GT(error(std::nullopt), 0.15);
}

TEST(LampDrift, SaysByHowMuch) {
  const auto words = [](LampDrift::Kind kind, double difference) {
    return LampDrift{kind, difference, 0.01, 1, 40, 41, 80}.Words();
  };
  EXPECT_EQ(words(LampDrift::Kind::kBlueness, std::log(1.12)),
            "views 41 to 80 are 12 % bluer than views 1 to 40");
  EXPECT_EQ(words(LampDrift::Kind::kBlueness, -std::log(1.12)),
            "views 41 to 80 are 12 % redder than views 1 to 40");
  EXPECT_EQ(words(LampDrift::Kind::kBrightness, std::log(0.5)),
            "views 41 to 80 are 50 % darker than views 1 to 40");
  EXPECT_EQ(words(LampDrift::Kind::kBrightness, std::log(2)),
            "views 41 to 80 are 100 % brighter than views 1 to 40");
}

}  // namespace
}  // namespace ulf::light_check_test
