// Tests: core/image/color_difference, core/image/color_profile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/image/color_difference.h"
#include "core/image/color_profile.h"

namespace ulf::color_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// Pairs of Sharma, Wu and Dalal's table 1, which branches of the formula that programs get
// wrong are made for.
TEST(ColorDifference, MatchesThePublishedPairs) {
  struct Pair {
    Vector3d a, b;
    double difference;
  };
  for (const Pair& pair :
       {Pair{{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
        Pair{{50, 3.1571, -77.2803}, {50, 0, -82.7485}, 2.8615},
        Pair{{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000}, Pair{{50, 0, 0}, {50, -1, 2}, 2.3669},
        Pair{{50, 2.49, -0.001}, {50, -2.49, 0.0010}, 7.1792},
        Pair{{50, 2.49, -0.001}, {50, -2.49, 0.0011}, 7.2195},
        Pair{{50, -0.001, 2.49}, {50, 0.0009, -2.49}, 4.8045}, Pair{{50, 2.5, 0}, {50, 0, -2.5}, 4.3065},
        Pair{{50, 2.5, 0}, {73, 25, -18}, 27.1492}, Pair{{50, 2.5, 0}, {61, -5, 29}, 22.8977},
        Pair{{50, 2.5, 0}, {56, -27, -3}, 31.9030},
        Pair{{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
        Pair{{63.0109, -31.0961, -5.8663}, {62.8187, -29.7946, -4.0864}, 1.2630},
        Pair{{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
        Pair{{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
        Pair{{6.7747, -0.2908, -2.4247}, {5.8714, -0.0985, -2.2286}, 0.6377},
        Pair{{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082}}) {
    EXPECT_NEAR(ColorDifference2000(pair.a, pair.b), pair.difference, 1e-4) << pair.a.transpose();
    EXPECT_NEAR(ColorDifference2000(pair.b, pair.a), pair.difference, 1e-4) << pair.a.transpose();
  }
}

TEST(ColorDifference, LabRoundTrips) {
  EXPECT_LT((LabFromLinearSrgb(Vector3d::Ones()) - Vector3d(100, 0, 0)).norm(), 1e-9);
  // Of sRGB's red, adapted to D50 (Lindbloom's calculator).
  EXPECT_LT((LabFromLinearSrgb({1, 0, 0}) - Vector3d(54.29, 80.81, 69.89)).norm(), 0.05);
  for (const Vector3d& rgb :
       {Vector3d(0.2, 0.7, 0.1), Vector3d(0.001, 0.002, 0.004), Vector3d(-0.05, 0.3, 0.4)})
    EXPECT_LT((LinearSrgbFromLab(LabFromLinearSrgb(rgb)) - rgb).norm(), 1e-9);
}

ColorProfile Warm() {
  return {.white_balance = {1.6, 1, 2.2},
          .matrix = {1.4, -0.3, -0.1, -0.2, 1.5, -0.3, 0.0, -0.5, 1.5},
          .source = "chart",
          .delta_e = 1.25};
}

TEST(ColorProfile, BalancesThenMixes) {
  const ColorProfile profile = Warm();
  cv::Mat light(2, 2, CV_32FC3, cv::Scalar(0.3 / 2.2, 0.3, 0.3 / 1.6));  // B G R: a grey
  light.at<cv::Vec3f>(1, 1) = {0.1f, 0.2f, 0.3f};
  const Image out = profile.Applied({.pixels = light, .transfer = Transfer::kLinear}, 0, {});
  EXPECT_EQ(out.transfer, Transfer::kLinear);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(out.pixels.at<cv::Vec3f>(0, 0)[c], 0.3, 1e-6) << "grey stays grey";
  const double r = 0.3 * 1.6, g = 0.2, b = 0.1 * 2.2;
  EXPECT_NEAR(out.pixels.at<cv::Vec3f>(1, 1)[2], 1.4 * r - 0.3 * g - 0.1 * b, 1e-6);
  EXPECT_NEAR(out.pixels.at<cv::Vec3f>(1, 1)[1], -0.2 * r + 1.5 * g - 0.3 * b, 1e-6);
  EXPECT_NEAR(out.pixels.at<cv::Vec3f>(1, 1)[0], -0.5 * g + 1.5 * b, 1e-6);
  // Above a black level of 5 %, which stays where it is: the views' exposure takes it off afterwards.
  const Image above = profile.Applied(
      {.pixels = light * 0.95 + cv::Scalar::all(0.05), .transfer = Transfer::kLinear}, 0.05, {});
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(above.pixels.at<cv::Vec3f>(1, 1)[c], 0.95 * out.pixels.at<cv::Vec3f>(1, 1)[c] + 0.05, 1e-6);
}

// A full sensor's channels are equal; balanced they would be magenta.
TEST(ColorProfile, FullInAllChannelsIsWhite) {
  const cv::Mat light(1, 2, CV_32FC3, cv::Scalar::all(1));
  cv::Mat clipped = cv::Mat::zeros(1, 2, CV_8UC1);
  clipped.at<std::uint8_t>(0, 1) = 255;
  const cv::Mat out = Warm().Applied({.pixels = light, .transfer = Transfer::kLinear}, 0, clipped).pixels;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(out.at<cv::Vec3f>(0, 1)[c], 1, 1e-6);
  EXPECT_GT(out.at<cv::Vec3f>(0, 0)[0], 1.5) << "what is not clipped keeps its range";
}

// Merged exposures are cut above 1: what is cut there stays as bright as what is not.
TEST(ColorProfile, FullInAllExposuresStaysBright) {
  const cv::Mat light(1, 2, CV_32FC3, cv::Scalar::all(4));
  cv::Mat clipped = cv::Mat::zeros(1, 2, CV_8UC1);
  clipped.at<std::uint8_t>(0, 1) = 255;
  const cv::Mat out = Warm().Applied({.pixels = light, .transfer = Transfer::kLinear}, 0, clipped).pixels;
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(out.at<cv::Vec3f>(0, 1)[c], 4, 1e-5) << "not what one exposure is cut at";
}

TEST(ColorProfile, IsKeptAsJson) {
  ColorProfile profile = Warm();
  EXPECT_EQ(ColorProfileFromJson(ColorProfileToJson(profile), "here"), profile);
  profile.raw_white_balance = {2.1, 1, 1.4};
  profile.delta_e.reset();
  nlohmann::json json = ColorProfileToJson(profile);
  EXPECT_EQ(ColorProfileFromJson(json, "here"), profile);
  json["white_balance"][1] = 0;
  EXPECT_THAT([&] { ColorProfileFromJson(json, "here"); },
              testing::ThrowsMessage<Error>(HasSubstr("white_balance")));
  json = ColorProfileToJson(profile);
  json["space"] = "ACES";
  EXPECT_THAT([&] { ColorProfileFromJson(json, "here"); }, testing::ThrowsMessage<Error>(HasSubstr("ACES")));
}

}  // namespace
}  // namespace ulf::color_test
