// Tests: core/image/exposure_merge, core/image/exposure_alignment, core/image/exposure_ghosts,
// core/image/sensor_noise.
#include "core/image/exposure_merge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/sensor.h"
#include "core/geometry/angles.h"
#include "core/image/exposure_alignment.h"
#include "tests/support/floors.h"

namespace ulf::test::exposure_merge_test {
namespace {

constexpr int kWidth = 384, kHeight = 256, kStops = 16;
constexpr double kReferenceS = 0.005;  // full scale is a light of 1

// Bands of one light each, from 2^-10 to 2^5: sixteen stops.
int BandOf(int x) { return x * kStops / kWidth; }
double LightOfBand(int band) { return std::exp2(band - 10); }

cv::Mat Bands() {
  cv::Mat radiance(kHeight, kWidth, CV_32FC4);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto light = static_cast<float>(LightOfBand(BandOf(x)));
      radiance.at<cv::Vec4f>(y, x) = {light, light, light, 0};
    }
  return radiance;
}

ExposedLight Exposed(const cv::Mat& radiance, double stops, std::uint64_t seed) {
  const SensorPicture picture{Expose(
      radiance,
      {.exposure_s = kReferenceS * std::exp2(stops), .format = SensorFormat::kRgb8, .noise_seed = seed})};
  return ExposedLightsOf({&picture, 1}).front();
}

std::vector<AlignedExposure> Bracket(const cv::Mat& radiance, const std::vector<double>& stops,
                                     std::uint64_t seed) {
  std::vector<AlignedExposure> exposures;
  for (const double each : stops)
    exposures.push_back(WithoutAlignment(Exposed(radiance, each, seed++), std::exp2(each)));
  return exposures;
}

// Root mean square of the relative error in the middle of a band.
double ErrorInBand(const cv::Mat& light, int band) {
  const int from = band * kWidth / kStops + 4, end = (band + 1) * kWidth / kStops - 4;
  double squares = 0;
  int count = 0;
  for (int y = 4; y < kHeight - 4; ++y)
    for (int x = from; x < end; ++x)
      for (int c = 0; c < 3; ++c, ++count)
        squares += std::pow(light.at<cv::Vec3f>(y, x)[c] / LightOfBand(band) - 1, 2);
  return std::sqrt(squares / count);
}

TEST(ExposureMerge, CoversSixteenStopsFromEight) {
  for (const std::uint64_t seed : {1u, 20u, 300u}) {
    const cv::Mat radiance = Bands();
    const MergedLight one = MergeExposures(Bracket(radiance, {0}, seed));
    const MergedLight seven = MergeExposures(Bracket(radiance, {0, -2, 2, -4, 4, -6, 6}, seed));
    EXPECT_EQ(cv::countNonZero(seven.clipped), 0);
    EXPECT_LT(seven.ghost_share, 0.002) << seed;
    for (int band = 0; band < kStops; ++band) {
      // The darkest band has a sixteenth of full scale in the longest exposure: 4.6 % of noise in that alone.
      EXPECT_LT(ErrorInBand(seven.light, band), band == 0 ? 0.046 : 0.04) << band << ", seed " << seed;
      if (band > 10) {
        EXPECT_GT(ErrorInBand(one.light, band), 0.3) << "clipped, band " << band;
      }
    }
    EXPECT_GT(ErrorInBand(one.light, 0), 0.5) << "noise";
    EXPECT_GT(cv::countNonZero(one.clipped), 0);
    EXPECT_LT(ErrorInBand(seven.light, 6), 0.7 * ErrorInBand(one.light, 6))
        << "several exposures are less noisy than one";
  }
}

// By noise, not by equal shares: the darker exposures must not spoil the lighter ones.
TEST(ExposureMerge, WeightsAreNearTheBestPossible) {
  const cv::Mat radiance = Bands();
  const std::vector<double> stops{0, -3, 3};
  const auto exposures = Bracket(radiance, stops, 5);
  const MergedLight merged = MergeExposures(exposures);
  for (int band = 2; band < 6; ++band) {
    double weights = 0;
    for (const double each : stops) {
      const double light = LightOfBand(band) * std::exp2(each);
      const double read = kReadNoiseElectrons / kFullWellElectrons;
      const double variance = light / kFullWellElectrons + read * read + 1.0 / (255 * 255 * 12);
      weights += std::exp2(2 * each) / variance;
    }
    const double best = 1 / std::sqrt(weights) / LightOfBand(band);
    EXPECT_LT(ErrorInBand(merged.light, band), 1.15 * best) << band;
  }
}

TEST(ExposureMerge, NoiseIsMeasuredInTheScene) {
  cv::Mat radiance(480, 640, CV_32FC4);
  for (int y = 0; y < radiance.rows; ++y)
    for (int x = 0; x < radiance.cols; ++x) {
      const float light = 0.02f + 0.8f * static_cast<float>(x) / 640 * (y / 40 % 2 == 0 ? 1.0f : 0.4f);
      radiance.at<cv::Vec4f>(y, x) = {light, 0.8f * light, 0.5f * light, 0};
    }
  for (const double gain : {1.0, 4.0}) {
    const SensorPicture picture{Expose(
        radiance,
        {.exposure_s = kReferenceS / gain, .gain = gain, .format = SensorFormat::kRgb8, .noise_seed = 3})};
    const ExposedLight exposed = ExposedLightsOf({&picture, 1}).front();
    const double electrons = kFullWellElectrons / gain;
    const double at = 0.5,
                 true_variance = at / electrons + std::pow(8 / electrons, 2) + 1.0 / (255 * 255 * 12);
    EXPECT_NEAR(exposed.noise.VarianceAt(at) / true_variance, 1, 0.25) << gain;
  }
}

// A demosaicking makes most pixels means of others: what is measured between neighbours there is no noise
// of the sensor.
TEST(ExposureMerge, NoiseIsMeasuredInDemosaickedPictures) {
  cv::Mat radiance(480, 640, CV_32FC4);
  for (int y = 0; y < radiance.rows; ++y)
    for (int x = 0; x < radiance.cols; ++x) {
      const float light = 0.01f + 0.6f * static_cast<float>(x) / 640;
      radiance.at<cv::Vec4f>(y, x) = {light, light, light, 0};
    }
  std::vector<SensorPicture> pictures;
  for (const double stops : {0.0, -2.0, -4.0, -6.0})
    pictures.push_back(
        {Demosaiced(Expose(radiance, {.exposure_s = kReferenceS * std::exp2(stops),
                                      .format = SensorFormat::kBayerRg12,
                                      .noise_seed = static_cast<std::uint64_t>(40 + stops)}))});
  for (const ExposedLight& exposed : ExposedLightsOf(pictures))
    for (const double at : {0.003, 0.03, 0.3}) {
      const double electrons = kFullWellElectrons;
      const double true_sigma = std::sqrt(at / electrons + std::pow(8 / electrons, 2));
      EXPECT_NEAR(std::sqrt(exposed.noise.VarianceAt(at)) / true_sigma, 1, 0.25) << at;
    }
}

// Of an exposure that is blurred or lies off the edge is left to the others, what is flat becomes
// less noisy by it.
TEST(ExposureMerge, MisalignedExposureDoesNotBlurEdges) {
  cv::Mat radiance(96, 128, CV_32FC4, cv::Scalar(0.02, 0.02, 0.02, 0)), beside = radiance.clone();
  radiance.colRange(64, 128).setTo(cv::Scalar(0.06, 0.06, 0.06, 0));
  beside.colRange(65, 128).setTo(cv::Scalar(0.06, 0.06, 0.06, 0));
  std::vector<AlignedExposure> exposures = Bracket(radiance, {0, 3}, 11);
  exposures[1] = WithoutAlignment(Exposed(beside, 3, 12), 8);
  const auto error = [&](int from, int to) {
    const MergedLight merged = MergeExposures(exposures);
    double sum = 0;
    for (int y = 8; y < 88; ++y)
      for (int x = from; x < to; ++x)
        sum += std::abs(merged.light.at<cv::Vec3f>(y, x)[1] / radiance.at<cv::Vec4f>(y, x)[1] - 1);
    return sum / (80 * (to - from));
  };
  exposures[1].misaligned_px = 1;
  const double at_edge = error(64, 65), flat = error(20, 50);
  exposures.resize(1);
  EXPECT_LT(at_edge, 2 * error(64, 65));
  EXPECT_LT(flat, 0.6 * error(20, 50));
}

TEST(ExposureMerge, MovedContentKeepsTheReference) {
  cv::Mat radiance = Bands();
  std::vector<AlignedExposure> exposures = Bracket(radiance, {0, -2, 2}, 9);
  // A dark thing stands elsewhere in the second exposure.
  cv::Mat moved = radiance.clone();
  const cv::Rect thing(190, 60, 40, 60);  // bands 8 and 9
  moved(thing).setTo(cv::Scalar::all(0.05));
  exposures[1] = WithoutAlignment(Exposed(moved, -2, 77), 0.25);
  const MergedLight merged = MergeExposures(exposures);
  const double share = thing.area() / static_cast<double>(radiance.total());
  EXPECT_NEAR(merged.ghost_share, share, 0.25 * share);
  EXPECT_GT(cv::countNonZero(merged.ghosts(thing)), 0.95 * thing.area());
  double worst = 0;
  for (int y = thing.y; y < thing.br().y; ++y)
    for (int x = thing.x; x < thing.br().x; ++x)
      worst = std::max<double>(
          worst, std::abs(merged.light.at<cv::Vec3f>(y, x)[1] / radiance.at<cv::Vec4f>(y, x)[1] - 1));
  EXPECT_LT(worst, 0.2) << "of the reference alone, not of the thing that stood there in another exposure";
}

TEST(ExposureMerge, ClippedInAllIsALowerBound) {
  const cv::Mat radiance(64, 64, CV_32FC4, cv::Scalar::all(20));
  const MergedLight merged = MergeExposures(Bracket(radiance, {0, -2, 2}, 1));
  EXPECT_EQ(cv::countNonZero(merged.clipped), 64 * 64);
  EXPECT_NEAR(merged.light.at<cv::Vec3f>(30, 30)[0], 4, 0.1) << "what fills the shortest";
}

TEST(ExposureMerge, RatioIsMeasuredWhereBothAreValid) {
  const auto exposures = Bracket(Bands(), {0, 1.7}, 4);
  EXPECT_NEAR(MeasuredRatio(exposures[1], exposures[0]), std::exp2(1.7), 0.01 * std::exp2(1.7));
  const auto dark = Bracket(cv::Mat(64, 64, CV_32FC4, cv::Scalar::all(1e-4)), {0, 1}, 4);
  EXPECT_EQ(MeasuredRatio(dark[1], dark[0]), 0);
}

// A painted plane, seen from two places; a board before it hides a part.
TEST(ExposureAlignment, UsesPoseDepthAndSkipsHiddenParts) {
  CameraModel camera = CameraModel::Pinhole(320, 240, 300);
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {-0.05, 0.02, 0, 0, 0};
  const Rigid3 moved_from_reference{
      Eigen::Quaterniond(Eigen::AngleAxisd(Radians(1.5), Eigen::Vector3d::UnitY())), {0.06, -0.02, 0.01}};
  constexpr double kPlane = 2, kBoard = 1;
  const auto depth_along = [&](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const double t = (kBoard - origin.z()) / direction.z();
    const Eigen::Vector3d at = origin + t * direction;
    const bool on_board = std::abs(at.x()) < 0.12 && std::abs(at.y()) < 0.12;
    return on_board ? t : (kPlane - origin.z()) / direction.z();
  };
  const auto draw = [&](const Rigid3& cam_from_reference, cv::Mat* depth) {
    cv::Mat light(camera.height, camera.width, CV_32FC3);
    if (depth) depth->create(light.size(), CV_32FC1);
    const Rigid3 reference_from_cam = cam_from_reference.Inverse();
    for (int y = 0; y < light.rows; ++y)
      for (int x = 0; x < light.cols; ++x) {
        const Eigen::Vector3d direction =
            reference_from_cam.rotation * *camera.RayFromImg({x + 0.5, y + 0.5});
        const Eigen::Vector3d origin = reference_from_cam.translation;
        const double t = depth_along(origin, direction);
        const Eigen::Vector3d at = origin + t * direction;
        const double wave = 0.5 + 0.2 * std::sin(25 * at.x()) + 0.2 * std::cos(31 * at.y() + 9 * at.x());
        const bool on_board = at.z() < 0.5 * (kBoard + kPlane);
        light.at<cv::Vec3f>(y, x) = cv::Vec3f::all(static_cast<float>(on_board ? 0.9 * wave : 0.4 * wave));
        if (depth) depth->at<float>(y, x) = static_cast<float>((cam_from_reference * at).z());
      }
    return light;
  };
  cv::Mat depth;
  const cv::Mat reference = draw({}, &depth), moved = draw(moved_from_reference, nullptr);
  const cv::Mat none = cv::Mat::zeros(reference.size(), CV_8UC3);
  const AlignedExposure aligned = AlignExposure({moved, none, {}}, camera, depth, moved_from_reference, 1);
  const auto mean_error = [&](const cv::Mat& light, const cv::Mat& where) {
    cv::Mat difference;
    cv::absdiff(light, reference, difference);
    return cv::mean(difference, where)[0];
  };
  const double share = cv::countNonZero(aligned.seen) / static_cast<double>(aligned.seen.total());
  EXPECT_GT(share, 0.85);
  EXPECT_LT(share, 0.99) << "the board hides something of the plane";
  EXPECT_LT(mean_error(aligned.light, aligned.seen), 0.006);
  EXPECT_GT(mean_error(moved, {}), 0.03) << "as it lies";
  // Depth of an undistorted camera of another size comes to the same pixels.
  const CameraModel other = camera.WithoutDistortion().ScaledTo(640, 480);
  const cv::Mat flat(480, 640, CV_32FC1, cv::Scalar(kPlane));
  EXPECT_EQ(cv::countNonZero(DepthInPicture(camera, other, flat) == kPlane), 320 * 240);
}

}  // namespace
}  // namespace ulf::test::exposure_merge_test
