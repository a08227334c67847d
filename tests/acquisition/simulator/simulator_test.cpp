// Tests: acquisition/simulator/simulated_camera, acquisition/simulator/sensor,
// acquisition/simulator/simulated_device, acquisition/simulator/scene/scene,
// acquisition/simulator/scene/ray_caster, acquisition/simulator/scene/primitive,
// acquisition/simulator/scene/lanes, acquisition/simulator/scene/texture, acquisition/simulator/scene/bake,
// acquisition/simulator/scene/materials, acquisition/simulator/scene/noise,
// acquisition/simulator/scene/studio_scenes.
//
// The simulated scene, sensor and camera against what they claim: exact geometry, physical light, repeatable
// bytes.
#include <gmock/gmock.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/scene/bake.h"
#include "acquisition/simulator/simulated_camera.h"
#include "acquisition/simulator/simulated_device.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::simulator_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kDegree = M_PI / 180;

SimulationOptions Small() {
  SimulationOptions options;
  options.width = 320;
  options.height = 240;
  return options;
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

// A pose before the scene's subject, turned away from the first one.
Rigid3 PoseAround(const Scene& scene, double azimuth_deg, double lift_deg, double distance_m) {
  const Vector3d first = scene.FirstDirection();
  const Vector3d turned = Eigen::AngleAxisd(azimuth_deg * kDegree, Vector3d::UnitZ()) * first;
  const Vector3d side = turned.cross(Vector3d::UnitZ()).normalized();
  const Vector3d direction = Eigen::AngleAxisd(-lift_deg * kDegree, side) * turned;
  const Vector3d center = scene.subject().center_in_world;
  return LookAt(center + distance_m * direction, center, Vector3d::UnitZ());
}

Vector3d RayInWorld(const CameraModel& camera, const Rigid3& cam_from_world, const Vector2d& img) {
  return cam_from_world.DirectionInSource(*camera.RayFromImg(img));
}

TEST(Scene, UnknownNameListsTheScenes) {
  try {
    Scene::Named("kitchen");
    FAIL() << "should have thrown";
  } catch (const Refusal& error) {
    EXPECT_THAT(error.what(), HasSubstr("kitchen"));
    for (const std::string& name : Scene::Names()) EXPECT_THAT(error.what(), HasSubstr(name));
  }
}

TEST(Scene, SubjectSphereEnclosesTheSubjectAndTouchesIt) {
  const auto scene = Scene::Named("studio");
  const Subject& subject = scene->subject();
  EXPECT_GT(subject.radius, 0.14);
  EXPECT_LT(subject.radius, 0.2);
  double farthest = 0;
  int met = 0;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) {
      // Rays from all around and above towards points in the sphere.
      const double azimuth = 6 * i * kDegree, height = (1 + 1.4 * j) * kDegree;
      const Vector3d out(std::cos(height) * std::cos(azimuth), std::cos(height) * std::sin(azimuth),
                         std::sin(height));
      const Vector3d aim = subject.center_in_world +
                           0.9 * subject.radius *
                               Vector3d(std::sin(37.0 * j), std::cos(23.0 * i), std::sin(11.0 * i + j)) / 1.8;
      const Vector3d origin = subject.center_in_world + 0.45 * out;
      const Vector3d direction = (aim - origin).normalized();
      if (!scene->primitives()[static_cast<std::size_t>(scene->PartAlong(origin, direction))].of_subject)
        continue;
      ++met;
      const Vector3d point = origin + scene->DepthAlong(origin, direction) * direction;
      farthest = std::max(farthest, (point - subject.center_in_world).norm());
    }
  EXPECT_GT(met, 1000);
  EXPECT_LE(farthest, subject.radius + 1e-6);
  EXPECT_GT(farthest, 0.9 * subject.radius) << "the sphere is not a loose one";
}

TEST(RayCaster, EightLanesMeetWhatDoublePrecisionMeets) {
  for (const std::string& name : Scene::Names()) {
    const auto scene = Scene::Named(name);
    const CameraModel camera = SimulatedIntrinsics(320, 240);
    const RayCaster caster(scene, camera);
    for (const double azimuth_deg : {-30.0, 25.0}) {
      const Rigid3 pose = PoseAround(*scene, azimuth_deg, 0.4 * azimuth_deg, 0.9);
      const cv::Mat lengths = caster.RayLength(pose);
      int wrong = 0, looked = 0;
      for (int y = 0; y < camera.height; y += 3)
        for (int x = 0; x < camera.width; x += 3, ++looked) {
          const Vector3d ray = RayInWorld(camera, pose, {x + 0.5, y + 0.5});
          if (std::abs(lengths.at<float>(y, x) - scene->DepthAlong(pose.OriginInSource(), ray)) > 2e-5)
            ++wrong;
        }
      // A ray that grazes a silhouette may fall on either side of it.
      EXPECT_LT(wrong, looked / 2000) << name << " from " << azimuth_deg << " degrees";
    }
  }
}

// A point seen from one pose, projected into another: there the caster must find the same point, or something
// nearer that hides it; and where it is matte and visible, the same colour.
TEST(RayCaster, PosesAndPicturesAgree) {
  const auto scene = Scene::Named("studio");
  const CameraModel camera = SimulatedIntrinsics(640, 480);
  const RayCaster caster(scene, camera);
  const Rigid3 a = PoseAround(*scene, -4, 0, 1), b = PoseAround(*scene, 3, 2, 0.97);
  const cv::Mat color_a = caster.Radiance(a), color_b = caster.Radiance(b);
  cv::Mat smooth_a, smooth_b;
  cv::GaussianBlur(color_a, smooth_a, {}, 1.5);
  cv::GaussianBlur(color_b, smooth_b, {}, 1.5);
  int visible = 0, hidden = 0;
  double difference = 0, shifted_difference = 0;
  for (int y = 12; y < 468; y += 5)
    for (int x = 12; x < 628; x += 5) {
      const Vector3d ray = RayInWorld(camera, a, {x + 0.5, y + 0.5});
      const Vector3d point = a.OriginInSource() + scene->DepthAlong(a.OriginInSource(), ray) * ray;
      const auto img = camera.ImgFromCam(b * point);
      if (!img || !camera.Contains(*img)) continue;
      const Vector3d ray_b = RayInWorld(camera, b, *img);
      const double met = scene->DepthAlong(b.OriginInSource(), ray_b),
                   distance = (point - b.OriginInSource()).norm();
      EXPECT_LE(met, distance + 1e-6) << "a point that was seen has become transparent, at " << x << "," << y;
      if (met < distance - 1e-6) {
        ++hidden;
        continue;
      }
      ++visible;
      if (scene->primitives()[static_cast<std::size_t>(scene->PartAlong(b.OriginInSource(), ray_b))].finish !=
          Finish::kMatte)
        continue;
      const auto at = [](const cv::Mat& image, const Vector2d& where) {
        cv::Mat patch;
        cv::getRectSubPix(image, {1, 1},
                          {static_cast<float>(where.x() - 0.5), static_cast<float>(where.y() - 0.5)}, patch);
        return patch.at<cv::Vec3f>(0, 0);
      };
      const cv::Vec3f own = smooth_a.at<cv::Vec3f>(y, x);
      difference += cv::norm(own - at(smooth_b, *img), cv::NORM_L1) / 3;
      shifted_difference += cv::norm(own - at(smooth_b, *img + Vector2d(4, 0)), cv::NORM_L1) / 3;
    }
  EXPECT_GT(visible, 8000);
  EXPECT_GT(hidden, 20) << "parts of the subject hide others";
  EXPECT_LT(difference / visible, 0.012);
  EXPECT_GT(shifted_difference, 4 * difference) << "colours would not tell a wrong pose";
}

TEST(RayCaster, OnlyTheGlazeFollowsTheEye) {
  const auto scene = Scene::Named("studio");
  const CameraModel camera = SimulatedIntrinsics(640, 480);
  const RayCaster caster(scene, camera);
  const auto glossy =
      std::find_if(scene->primitives().begin(), scene->primitives().end(),
                   [](const Primitive& primitive) { return primitive.finish == Finish::kGlazed; });
  ASSERT_NE(glossy, scene->primitives().end());
  const int part = static_cast<int>(glossy - scene->primitives().begin());
  double most = 0;
  const Rigid3 a = PoseAround(*scene, -25, 0, 1), b = PoseAround(*scene, 0, 0, 1);
  const cv::Mat color_a = caster.Radiance(a), color_b = caster.Radiance(b);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const Vector3d ray = RayInWorld(camera, a, {x + 0.5, y + 0.5});
      if (scene->PartAlong(a.OriginInSource(), ray) != part) continue;
      const Vector3d point = a.OriginInSource() + scene->DepthAlong(a.OriginInSource(), ray) * ray;
      const auto img = camera.ImgFromCam(b * point);
      if (!img || !camera.Contains(*img)) continue;
      const Vector3d ray_b = RayInWorld(camera, b, *img);
      if (scene->DepthAlong(b.OriginInSource(), ray_b) < (point - b.OriginInSource()).norm() - 1e-6) continue;
      const cv::Vec3f seen_b = color_b.at<cv::Vec3f>(static_cast<int>(img->y()), static_cast<int>(img->x()));
      most = std::max(most, cv::norm(color_a.at<cv::Vec3f>(y, x) - seen_b, cv::NORM_INF));
    }
  EXPECT_GT(most, 0.5) << "a lamp's mirror image moves over the glaze";
}

// One look a pixel, against sixteen: textures and edges must already be filtered to the pixel.
TEST(RayCaster, PicturesAreFilteredToThePixel) {
  for (const std::string& name : Scene::Names()) {
    const auto scene = Scene::Named(name);
    const CameraModel fine_camera = SimulatedIntrinsics(1280, 960);
    const RayCaster coarse(scene, fine_camera.ScaledTo(320, 240)), fine(scene, fine_camera);
    const Rigid3 pose = PoseAround(*scene, 12, 3, 1);
    cv::Mat averaged;
    cv::resize(fine.Radiance(pose), averaged, {320, 240}, 0, 0, cv::INTER_AREA);
    // What is brighter than white, as lamps are, counts as white.
    cv::Mat difference;
    cv::absdiff(cv::min(coarse.Radiance(pose), 1), cv::min(averaged, 1), difference);
    cv::Mat values = difference.reshape(1, 1).clone();
    cv::sort(values, values, cv::SORT_ASCENDING);
    EXPECT_LT(cv::mean(values)[0], 0.012) << name;
    EXPECT_LT(values.at<float>(0, values.cols * 99 / 100), 0.08) << name;
  }
}

// Each scene from one of three sides every day, from all of them in the long run.
TEST(Scene, HasCornersEverywhere) {
  constexpr std::array<double, 3> kAzimuths_deg{-28, 28, 0};
  unsigned scenes = 0;
  for (const std::string& name : Scene::Names()) {
    ++scenes;
    if (name == "bust" || name == "picture" || name == "room") continue;  // have bare places by intent
    SimulationOptions options;
    options.scene = name;
    const SimulatedCamera camera(options);
    for (const unsigned side : test::SeedsOf({0, 1, 2})) {
      const double azimuth_deg = kAzimuths_deg[(scenes + side) % 3];
      const cv::Mat gray = [&] {
        cv::Mat result;
        cv::cvtColor(camera.CleanSrgb(PoseAround(camera.scene(), azimuth_deg, 0.3 * azimuth_deg, 1)), result,
                     cv::COLOR_BGR2GRAY);
        return result;
      }();
      std::vector<cv::KeyPoint> corners;
      cv::FAST(gray, corners, 20);
      cv::Mat counts = cv::Mat::zeros(6, 8, CV_32S);
      for (const cv::KeyPoint& corner : corners)
        ++counts.at<int>(static_cast<int>(corner.pt.y) / 80, static_cast<int>(corner.pt.x) / 80);
      EXPECT_GE(cv::countNonZero(counts >= 8), 46) << name << " from " << azimuth_deg << ":\n" << counts;
    }
  }
}

TEST(KeptCharts, AreReadBackOrBakedAgainIfUnreadable) {
  namespace fs = std::filesystem;
  const auto scene = Scene::Named("picture");
  const test::ScratchFolder scratch;
  const auto is_as_baked = [&](const MipTexture& chart, int i) {
    const MipTexture& baked = scene->Chart(i);
    return chart.width() == baked.width() && chart.height() == baked.height() &&
           chart.wrap_u() == baked.wrap_u() && chart.wrap_v() == baked.wrap_v() &&
           std::ranges::equal(chart.Texels(), baked.Texels());
  };
  const auto are_as_baked = [&] {
    const std::vector<MipTexture> charts = KeptOrBakedCharts(*scene, scratch / "kept");
    int differ = 0;
    for (std::size_t i = 0; i < charts.size(); ++i) differ += !is_as_baked(charts[i], static_cast<int>(i));
    return !charts.empty() && differ == 0;
  };
  EXPECT_TRUE(are_as_baked());
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(scratch / "kept")) files.push_back(entry.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_TRUE(are_as_baked());
  // That they are read is seen by what is written into the file.
  const auto size = fs::file_size(files[0]);
  std::fstream(files[0], std::ios::binary | std::ios::in | std::ios::out).seekp(-8, std::ios::end)
      << "12345678";
  EXPECT_FALSE(are_as_baked());
  for (const std::uintmax_t left : {size - 8, std::uintmax_t{20}}) {
    fs::resize_file(files[0], left);
    EXPECT_TRUE(are_as_baked()) << left;
    EXPECT_EQ(fs::file_size(files[0]), size) << "kept again";
  }
  // Where nothing can be kept the scene is there all the same.
  std::ofstream(scratch / "file") << "no folder";
  EXPECT_FALSE(KeptOrBakedCharts(*scene, scratch / "file" / "kept").empty());
}

TEST(Sensor, NoiseGrowsWithTheSignalAsShotNoiseDoes) {
  for (const double level : {0.02, 0.1, 0.4, 0.8})
    for (const double gain : {1.0, 2.0, 4.0}) {
      if (level * gain > 0.9) continue;
      const cv::Mat light(256, 256, CV_32FC4, cv::Scalar::all(level));
      const Image image = Expose(light, {.exposure_s = kReferenceExposure_s,
                                         .gain = gain,
                                         .format = SensorFormat::kMono8,
                                         .noise_seed = 5});
      cv::Scalar mean, deviation;
      cv::meanStdDev(image.pixels, mean, deviation);
      const double well = kFullWellElectrons;
      const double expected =
          255.0 * 255 * gain * gain * (level / well + std::pow(kReadNoiseElectrons / well, 2)) +
          1.0 / 12;                  // rounding to integers
      if (expected < 0.4) continue;  // rounding hides noise that is finer than the numbers
      EXPECT_NEAR(mean[0], 255 * gain * level, 0.1) << level << " gain " << gain;
      EXPECT_NEAR(deviation[0] * deviation[0], expected, 0.04 * expected) << level << " gain " << gain;
    }
}

TEST(Sensor, NoiseIsDrawnAnewForEverySeedAndPixel) {
  const cv::Mat light(64, 64, CV_32FC4, cv::Scalar::all(0.5));
  const auto shoot = [&](std::uint64_t seed) {
    return Expose(light, {.format = SensorFormat::kMono8, .noise_seed = seed}).pixels;
  };
  EXPECT_TRUE(SameBytes(shoot(1), shoot(1)));
  cv::Mat one, two;
  shoot(1).convertTo(one, CV_32F);
  shoot(2).convertTo(two, CV_32F);
  one -= cv::mean(one)[0];
  two -= cv::mean(two)[0];
  const double power = one.dot(one);
  EXPECT_LT(std::abs(one.dot(two)) / power, 0.06) << "two seeds";
  EXPECT_LT(std::abs(one.colRange(0, 63).clone().dot(one.colRange(1, 64).clone())) / power, 0.06)
      << "neighbours";
}

TEST(SimulatedCamera, SameSeedSameBytesOtherSeedOthers) {
  const SimulatedCamera first(Small()), second(Small());
  SimulationOptions other_options = Small();
  other_options.seed = 8;
  const SimulatedCamera other(other_options);
  for (const std::uint64_t index : {0u, 17u}) {
    const Frame a = first.Capture(index), b = second.Capture(index), c = other.Capture(index);
    EXPECT_TRUE(SameBytes(a.image.pixels, b.image.pixels)) << index;
    EXPECT_EQ(a.known_cam_from_world->Matrix(), b.known_cam_from_world->Matrix()) << index;
    EXPECT_FALSE(SameBytes(a.image.pixels, c.image.pixels)) << index;
  }
  EXPECT_GT((first.hand().CamFromWorld(20).translation - other.hand().CamFromWorld(20).translation).norm(),
            1e-3);
}

TEST(SimulatedCamera, FrameSaysHowItWasTaken) {
  SimulationOptions options = Small();
  options.gain_db = 6;
  const SimulatedCamera camera(options);
  const Frame frame = camera.Capture(30);
  EXPECT_EQ(frame.id, 30u);
  EXPECT_NEAR(frame.device_time_s, 2 + 0.0025, 1e-12);
  EXPECT_EQ(frame.known_cam_from_world->Matrix(), camera.hand().CamFromWorld(2.0025).Matrix())
      << "middle of exposure";
  EXPECT_EQ(frame.image.transfer, Transfer::kLinear);
  EXPECT_NEAR(frame.gain, 1.9953, 1e-4);
  EXPECT_EQ(frame.exposure_s, options.exposure_s);
}

TEST(SimulatedCamera, ExposureAndGainScaleTheLight) {
  SimulationOptions options = Small();
  options.noise = false;
  const SimulatedCamera camera(options);
  const auto mean = [&](double exposure_s, double gain) {
    return cv::mean(camera
                        .Capture({.open_s = 1 - 0.5 * exposure_s,
                                  .exposure_s = exposure_s,
                                  .gain = gain,
                                  .format = SensorFormat::kMono8})
                        .image.pixels)[0];
  };
  const double once = mean(0.001, 1);
  EXPECT_GT(once, 4);
  EXPECT_NEAR(mean(0.002, 1) / once, 2, 0.03);
  EXPECT_NEAR(mean(0.001, 2) / once, 2, 0.03);
}

TEST(SimulatedCamera, MosaicHoldsTheFullPicturesColours) {
  SimulationOptions options = Small();
  options.noise = false;
  const SimulatedCamera camera(options);
  const auto shoot = [&](SensorFormat format) {
    return camera.Capture({.open_s = 1, .format = format}).image;
  };
  const Image color = shoot(SensorFormat::kRgb8), mosaic = shoot(SensorFormat::kBayerRg8),
              mono = shoot(SensorFormat::kMono8);
  ASSERT_EQ(mosaic.mosaic, Mosaic::kRggb);
  for (int y = 0; y < mosaic.height(); ++y)
    for (int x = 0; x < mosaic.width(); ++x) {
      const int channel =
          y % 2 == 0 ? (x % 2 == 0 ? 2 : 1) : (x % 2 == 0 ? 1 : 0);  // R G / G B, in B, G, R order
      ASSERT_EQ(mosaic.pixels.at<std::uint8_t>(y, x), color.pixels.at<cv::Vec3b>(y, x)[channel])
          << x << "," << y;
    }
  cv::Mat difference;
  cv::absdiff(Srgb8(mosaic), Srgb8(color), difference);
  const cv::Scalar mean = cv::mean(difference);
  EXPECT_LT((mean[0] + mean[1] + mean[2]) / 3, 9) << "after demosaicing, of 255";
  cv::Mat gray, brightest;
  cv::cvtColor(color.pixels, gray, cv::COLOR_BGR2GRAY);
  cv::reduce(color.pixels.reshape(1, mono.height() * mono.width()), brightest, 1, cv::REDUCE_MAX);
  const cv::Mat unclipped = brightest.reshape(1, mono.height()) < 255;
  EXPECT_LE(cv::norm(gray, mono.pixels, cv::NORM_INF, unclipped), 2);
  EXPECT_GT(cv::countNonZero(unclipped), 300 * 240);
}

const Hand& ScanningHand(const SimulatedCamera& camera) { return dynamic_cast<const Hand&>(camera.hand()); }

TEST(SimulatedCamera, MovingBlursAlongTheMotion) {
  SimulationOptions options = Small();
  options.noise = false;
  const SimulatedCamera camera(options);
  double fast_s = 0;
  while (!ScanningHand(camera).LooksAway(fast_s)) fast_s += 0.01;  // the head begins to turn
  fast_s += 0.1;
  constexpr double kLong = 0.02, kShort = 0.0002;
  const double blur_px = camera.BlurPx(fast_s - 0.5 * kLong, kLong);
  EXPECT_GT(blur_px, 4);
  EXPECT_LT(camera.BlurPx(fast_s, kShort), 0.3);
  const auto sharpness = [&](double exposure_s, bool across) {
    const Frame frame = camera.Capture({.open_s = fast_s - 0.5 * exposure_s,
                                        .exposure_s = exposure_s,
                                        .gain = 0.005 / exposure_s,
                                        .format = SensorFormat::kMono8});
    cv::Mat slope;
    cv::Sobel(frame.image.pixels, slope, CV_32F, across ? 1 : 0, across ? 0 : 1);
    return cv::norm(slope);
  };
  // The head turns about the vertical: columns smear, rows keep more.
  const double across_left = sharpness(kLong, true) / sharpness(kShort, true);
  const double down_left = sharpness(kLong, false) / sharpness(kShort, false);
  EXPECT_LT(across_left, 0.6);
  EXPECT_GT(down_left, across_left + 0.1);
}

TEST(SimulatedCamera, BlurredFrameIsTheMeanOfItsInstants) {
  SimulationOptions options = Small();
  options.noise = false;
  const SimulatedCamera camera(options);
  double fast_s = 0;
  while (!ScanningHand(camera).LooksAway(fast_s)) fast_s += 0.01;
  fast_s += 0.1;
  constexpr double kExposure = 0.01;
  cv::Mat truth = cv::Mat::zeros(options.height, options.width, CV_32FC3);
  constexpr int kInstants = 40;
  for (int i = 0; i < kInstants; ++i)
    truth +=
        camera.caster().Radiance(camera.hand().CamFromWorld(fast_s + (i + 0.5) / kInstants * kExposure)) /
        kInstants;
  const Frame frame = camera.Capture({.open_s = fast_s, .exposure_s = kExposure, .gain = 0.5});
  cv::Mat light;
  frame.image.pixels.convertTo(light, CV_32F, 1 / 255.0);
  cv::Mat difference;
  cv::absdiff(light, truth, difference);
  EXPECT_LT(cv::mean(difference.reshape(1))[0], 0.012);
}

// Each row as a global shutter would see it at that row's moment; the frame's time is the middle row's.
TEST(SimulatedCamera, ARollingShutterReadsRowByRow) {
  SimulationOptions options;
  options.width = 320;
  options.height = 240;
  options.noise = options.looks_away = false;
  const SimulatedCamera global(options);
  options.readout_s = 0.02;
  const SimulatedCamera rolling(options);
  const double open_s = 1.5;
  const Frame frame = rolling.Capture(Shot{.open_s = open_s});
  EXPECT_NEAR(frame.device_time_s, open_s + 0.5 * 0.02 + 0.5 * 0.005, 1e-12);
  for (const int first : {8, 112, 224}) {  // bands of eight rows, away from their edges
    const Frame then = global.Capture(Shot{.open_s = open_s + 0.02 * (first + 4) / 240.0});
    const cv::Mat difference =
        frame.image.pixels.rowRange(first + 2, first + 6) - then.image.pixels.rowRange(first + 2, first + 6);
    EXPECT_LT(cv::norm(difference, cv::NORM_INF), 2) << "rows from " << first;
    const Frame other = global.Capture(Shot{.open_s = open_s + 0.02 * (first < 120 ? 1 : 0)});
    EXPECT_GT(cv::norm(frame.image.pixels.rowRange(first, first + 8),
                       other.image.pixels.rowRange(first, first + 8)),
              100)
        << "rows from " << first;
  }
  EXPECT_THROW(OpenDevice("sim:studio?readout_ms=-1"), Refusal);
  EXPECT_THROW(OpenDevice("sim:studio?fps=30&readout_ms=34"), Refusal);  // longer than a frame
}

TEST(SimulatedDevice, GivesFramesUntilItsDurationIsOver) {
  const auto device = OpenSimulatedDevice(
      DeviceUri::Parse("sim:studio?width=160&height=120&fps=10&duration_s=0.45&format=mono8"));
  EXPECT_FALSE(device->IsLive());
  ASSERT_TRUE(device->Camera());
  EXPECT_EQ(device->Camera()->width, 160);
  EXPECT_FALSE(device->Next(std::chrono::milliseconds(1))) << "not started";
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  device->Start();
  std::vector<std::uint64_t> ids;
  while (const auto frame = device->Next(std::chrono::milliseconds(100))) {
    ids.push_back(frame->id);
    EXPECT_EQ(frame->image.pixels.type(), CV_8UC1);
    EXPECT_GT(frame->host_time_s, 1e9);
  }
  EXPECT_THAT(ids, ::testing::ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(device->State(), DeviceState::kEnded);
  EXPECT_EQ(device->Statistics().delivered, 5u);
  device->Stop();
  EXPECT_EQ(device->State(), DeviceState::kConnected);
}

TEST(SimulatedDevice, WrongOptionsAreNamed) {
  const std::pair<const char*, const char*> kCases[] = {{"sim:nowhere", "nowhere"},
                                                        {"sim:studio?sede=3", "sede"},
                                                        {"sim:studio?seed=-3", "seed"},
                                                        {"sim:studio?fps=fast", "fast"},
                                                        {"sim:studio?fps=0", "frame rate"},
                                                        {"sim:studio?width=9999999", "width"},
                                                        {"sim:studio?format=yuv", "yuv"},
                                                        {"sim:studio?noise=yes", "noise"},
                                                        {"sim:studio?cap=60", "WIDTHxHEIGHT"},
                                                        {"sim:studio?cap=60x80", "height"},
                                                        {"sim:studio?exposure_us=1e9", "exposure"},
                                                        {"sim:studio?duration_s=0", "duration"},
                                                        {"sim:studio?width=640px", "640px"}};
  for (const auto& [uri, mentioned] : kCases) {
    EXPECT_THAT([&uri = uri] { OpenSimulatedDevice(DeviceUri::Parse(uri)); },
                testing::ThrowsMessage<Refusal>(HasSubstr(mentioned)))
        << uri;
  }
}

}  // namespace
}  // namespace ulf::simulator_test
