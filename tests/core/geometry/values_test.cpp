// Tests: core/geometry/rigid3, core/geometry/camera_model, core/image/image, core/base/device_uri,
// core/light_field/findings, core/geometry/small_matrices.
//
// Poses, cameras, images: the values everything else is made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "acquisition/device/device.h"
#include "core/base/error.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/small_matrices.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "core/light_field/findings.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::values_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

Rigid3 RandomPose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Rigid3 pose;
  pose.rotation =
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  pose.translation = {normal(random), normal(random), normal(random)};
  return pose;
}

TEST(Rigid3, InverseAndCompositionAgreeWithMatrices) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const Rigid3 b_from_a = RandomPose(random), c_from_b = RandomPose(random);
    const Vector3d point_in_a = RandomPose(random).translation;
    EXPECT_LT(((c_from_b * b_from_a).Matrix() - c_from_b.Matrix() * b_from_a.Matrix()).norm(), 1e-12);
    EXPECT_LT((b_from_a.Inverse() * (b_from_a * point_in_a) - point_in_a).norm(), 1e-12);
    EXPECT_LT((b_from_a * b_from_a.OriginInSource()).norm(), 1e-12);
    EXPECT_LT((Rigid3::FromMatrix(b_from_a.Matrix()).Matrix() - b_from_a.Matrix()).norm(), 1e-12);
  }
}

TEST(Rigid3, LookAtPutsTheTargetOnTheAxisAndUpUpwards) {
  const Vector3d center(1, 2, 3), target(-2, 0.5, 4), up(0, 0, 1);
  const Rigid3 cam_from_world = LookAt(center, target, up);
  const Vector3d target_in_cam = cam_from_world * target;
  EXPECT_NEAR(target_in_cam.x(), 0, 1e-12);
  EXPECT_NEAR(target_in_cam.y(), 0, 1e-12);
  EXPECT_NEAR(target_in_cam.z(), (target - center).norm(), 1e-12);
  EXPECT_LT((cam_from_world.OriginInSource() - center).norm(), 1e-12);
  EXPECT_LT((cam_from_world * (target + up)).y(), 0) << "y points down";
  EXPECT_NEAR(cam_from_world.RotationMatrix().determinant(), 1, 1e-12);
}

TEST(Rigid3, RotationAngleIsTheShortWayRound) {
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(M_PI / 2, Vector3d(1, 2, 3).normalized()));
  EXPECT_NEAR(RotationAngle(quarter), M_PI / 2, 1e-12);
  EXPECT_NEAR(RotationAngle(Eigen::Quaterniond(-quarter.coeffs())), M_PI / 2, 1e-12);
}

struct NamedCamera {
  std::string name;
  CameraModel camera;
};

std::vector<NamedCamera> Cameras() {
  CameraModel pinhole = CameraModel::Pinhole(640, 480, 525);
  CameraModel webcam = CameraModel::FromOpenCv(640, 480, 527, 529, 318, 243, Distortion::kRadialTangential,
                                               {-0.28, 0.09, 0.001, -0.0007, -0.012});
  CameraModel fox =
      CameraModel::FromOpenCv(540, 960, 687.76, 687.245, 276.8, 482.1, Distortion::kRadialTangential,
                              {0.0578421, -0.0805099, -0.000980296, 0.00015575, 0});
  CameraModel fisheye = CameraModel::FromOpenCv(1280, 960, 410, 411, 640, 478, Distortion::kFisheye,
                                                {-0.02, 0.004, -0.001, 0.0002, 0});
  return {{"pinhole", pinhole}, {"webcam", webcam}, {"fox", fox}, {"fisheye", fisheye}};
}

TEST(CameraModel, RoundTripsToAMillionthOfAPixel) {
  for (const auto& [name, camera] : Cameras())
    for (int y = 0; y <= camera.height; y += 16)
      for (int x = 0; x <= camera.width; x += 16) {
        const Vector2d img(x, y);
        const auto ray = camera.RayFromImg(img);
        ASSERT_TRUE(ray) << name << " at " << img.transpose();
        EXPECT_NEAR(ray->norm(), 1, 1e-12);
        const auto back = camera.ImgFromCam(*ray * 3.7);
        ASSERT_TRUE(back) << name << " at " << img.transpose();
        EXPECT_LT((*back - img).norm(), 1e-6) << name << " at " << img.transpose();
      }
}

TEST(CameraModel, DerivativeAgreesWithDifferences) {
  for (const auto& [name, camera] : Cameras())
    for (const Vector3d& point : {Vector3d(0.3, -0.2, 1.1), Vector3d(-0.4, 0.25, 2), Vector3d(1e-14, 0, 1)}) {
      Eigen::Matrix<double, 2, 3> derivative;
      ASSERT_TRUE(camera.ImgFromCam(point, &derivative));
      constexpr double kStep = 1e-6;
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d step = kStep * Vector3d::Unit(axis);
        const Vector2d difference =
            (*camera.ImgFromCam(point + step) - *camera.ImgFromCam(point - step)) / (2 * kStep);
        EXPECT_LT((difference - derivative.col(axis)).norm(), 1e-4) << name << " " << point.transpose();
      }
    }
}

TEST(CameraModel, ProjectsAsOpenCvDoesHalfAPixelLater) {
  const std::vector<cv::Point3d> points{{0.2, -0.1, 1.5}, {-0.4, 0.3, 2}, {0, 0, 1}};
  for (const auto& [name, camera] : Cameras()) {
    const cv::Matx33d k(camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1);
    std::vector<cv::Point2d> expected;
    const auto& c = camera.coefficients;
    if (camera.distortion == Distortion::kFisheye)
      cv::fisheye::projectPoints(points, expected, cv::Vec3d(), cv::Vec3d(), k,
                                 cv::Vec4d(c[0], c[1], c[2], c[3]));
    else
      cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k, std::vector<double>(c.begin(), c.end()),
                        expected);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto img = camera.ImgFromCam({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(img) << name;
      EXPECT_NEAR(img->x(), expected[i].x + 0.5, 1e-9) << name;
      EXPECT_NEAR(img->y(), expected[i].y + 0.5, 1e-9) << name;
    }
  }
}

TEST(CameraModel, SaysNothingBehindItselfOrPastTheFold) {
  for (const auto& [name, camera] : Cameras()) EXPECT_FALSE(camera.ImgFromCam({0, 0, -1})) << name;
  CameraModel folding = CameraModel::Pinhole(640, 480, 300);
  folding.distortion = Distortion::kRadialTangential;
  folding.coefficients = {-0.4, 0, 0, 0, 0};  // r (1 - 0.4 r^2) turns back at r = 0.913
  EXPECT_TRUE(folding.ImgFromCam({0.9, 0, 1}));
  EXPECT_FALSE(folding.ImgFromCam({0.95, 0, 1}));
  EXPECT_FALSE(folding.RayFromImg({folding.cx + 300 * 0.7, folding.cy})) << "no ray reaches so far out";
}

TEST(CameraModel, DistortionExtentIsWhereImagesEnd) {
  CameraModel camera = CameraModel::Pinhole(640, 480, 500);
  EXPECT_GT(camera.DistortionExtent(), 1e20) << "no distortion";
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {-0.4, 0, 0, 0, 0};
  const auto has_image = [&](double radius) { return camera.ImgFromCam({radius, 0, 1}).has_value(); };
  const double radius = std::sqrt(camera.DistortionExtent());
  EXPECT_TRUE(has_image(0.9999 * radius));
  EXPECT_FALSE(has_image(1.0001 * radius));
  camera.distortion = Distortion::kFisheye;
  camera.coefficients = {-0.2, 0, 0, 0, 0};
  const double angle = camera.DistortionExtent();
  EXPECT_NEAR(angle, std::sqrt(1 / 0.6), 1e-6);
  EXPECT_TRUE(camera.ImgFromCam({std::sin(angle - 1e-4), 0, std::cos(angle - 1e-4)}));
  EXPECT_FALSE(camera.ImgFromCam({std::sin(angle + 1e-4), 0, std::cos(angle + 1e-4)}));
}

TEST(CameraModel, ScalingKeepsRays) {
  for (const auto& [name, camera] : Cameras()) {
    const CameraModel half = camera.ScaledTo(camera.width / 2, camera.height / 2);
    const Vector3d point(0.21, -0.13, 1);
    EXPECT_LT((2 * *half.ImgFromCam(point) - *camera.ImgFromCam(point)).norm(), 1e-9) << name;
  }
}

TEST(CameraModel, RefusesNonsenseByName) {
  CameraModel camera = CameraModel::Pinhole(640, 480, 500);
  camera.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { camera.Validate("cam7"); }, ThrowsMessage<Error>(HasSubstr("cam7")));
  camera = CameraModel::Pinhole(640, 480, -1);
  EXPECT_THAT([&] { camera.Validate("cam7"); }, ThrowsMessage<Error>(HasSubstr("must be positive")));
  camera = CameraModel::Pinhole(0, 480, 500);
  EXPECT_THAT([&] { camera.Validate("cam7"); }, ThrowsMessage<Error>(HasSubstr("0x480")));
}

TEST(Image, SrgbEncodingRoundTripsEveryCode) {
  cv::Mat codes(1, 256, CV_8UC3);
  for (int i = 0; i < 256; ++i) codes.at<cv::Vec3b>(0, i) = cv::Vec3b::all(static_cast<std::uint8_t>(i));
  const cv::Mat back = Srgb8FromLinear(LinearFloat({codes, Transfer::kSrgb}));
  EXPECT_EQ(cv::norm(codes, back, cv::NORM_INF), 0);
  EXPECT_NEAR(LinearFromSrgb(SrgbFromLinear(0.18f)), 0.18f, 1e-6);
  EXPECT_NEAR(SrgbFromLinear(0.18f), 0.4614f, 1e-3) << "middle grey, IEC 61966-2-1";
}

TEST(Image, EveryMosaicPatternGivesBackTheColour) {
  // A red surface: only the red sites of a mosaic carry light.
  struct Pattern {
    Mosaic mosaic;
    int red_x, red_y;
  };
  for (const Pattern& pattern : {Pattern{Mosaic::kRggb, 0, 0}, Pattern{Mosaic::kGrbg, 1, 0},
                                 Pattern{Mosaic::kGbrg, 0, 1}, Pattern{Mosaic::kBggr, 1, 1}}) {
    cv::Mat mosaic = cv::Mat::zeros(16, 16, CV_8UC1);
    for (int y = pattern.red_y; y < 16; y += 2)
      for (int x = pattern.red_x; x < 16; x += 2) mosaic.at<std::uint8_t>(y, x) = 200;
    const cv::Mat linear = LinearFloat({mosaic, Transfer::kLinear, pattern.mosaic});
    const cv::Vec3f middle = linear.at<cv::Vec3f>(8, 8);
    EXPECT_NEAR(middle[2], 200.0f / 255, 0.01f) << static_cast<int>(pattern.mosaic);
    EXPECT_LT(middle[0], 0.01f) << static_cast<int>(pattern.mosaic);
    EXPECT_LT(middle[1], 0.01f) << static_cast<int>(pattern.mosaic);
  }
}

TEST(Image, TruncatedAndMissingFilesAreNamed) {
  test::ScratchFolder scratch;
  const cv::Mat noise(64, 64, CV_8UC3);
  cv::randu(noise, 0, 255);
  for (const char* name : {"picture.png", "picture.jpg"}) {
    const std::string path = (scratch / name).string();
    cv::imwrite(path, noise);
    EXPECT_NO_THROW(ReadImageFile(path));
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    EXPECT_THAT([&] { ReadImageFile(path); },
                ThrowsMessage<Error>(testing::AllOf(HasSubstr(name), HasSubstr("truncated"))));
  }
  EXPECT_THAT([&] { ReadImageFile((scratch / "gone.png").string()); },
              ThrowsMessage<Error>(testing::AllOf(HasSubstr("gone.png"), HasSubstr("missing"))));
  std::ofstream(scratch / "words.png") << "this is not a picture but some words";
  EXPECT_THAT([&] { ReadImageFile((scratch / "words.png").string()); },
              ThrowsMessage<Error>(HasSubstr("words.png")));
}

TEST(DeviceUri, TakesApartAndRefuses) {
  const DeviceUri uri = DeviceUri::Parse("sim:studio?seed=7&fps=15");
  EXPECT_EQ(uri.scheme, "sim");
  EXPECT_EQ(uri.path, "studio");
  EXPECT_EQ(uri.Option("seed"), "7");
  EXPECT_EQ(uri.Option("width"), std::nullopt);
  EXPECT_EQ(uri.Text(), "sim:studio?seed=7&fps=15");
  EXPECT_EQ(DeviceUri::Parse("replay:/a/b?glob=*.color.jpg").Option("glob"), "*.color.jpg");
  EXPECT_THAT([&] { uri.AllowOnly({"seed"}); }, ThrowsMessage<Refusal>(HasSubstr("'fps'")));
  EXPECT_THROW(DeviceUri::Parse("studio"), Refusal);
  EXPECT_THROW(DeviceUri::Parse("sim:studio?seed"), Refusal);
}

TEST(SmallMatrices, AreTakenApartAndPutTogetherAgain) {
  Eigen::Matrix3d any;
  any << 1, 2, 3, -4, 5, 0.5, 0.1, -7, 2;
  const SingularValues3 svd = SingularValuesOf(any);
  EXPECT_LT((svd.u * svd.values.asDiagonal() * svd.v.transpose() - any).norm(), 1e-12);
  EXPECT_GT(svd.values(0), svd.values(1));
  EXPECT_GT(svd.values(1), svd.values(2));

  const Eigen::Matrix3d symmetric = any * any.transpose();
  const Eigenvalues3 axes = EigenvaluesOf(symmetric);
  EXPECT_LT((symmetric * axes.vectors - axes.vectors * axes.values.asDiagonal()).norm(), 1e-10);
  EXPECT_LT(axes.values(0), axes.values(1));
  EXPECT_LT(axes.values(1), axes.values(2));
  EXPECT_NEAR(std::abs(EigenvaluesOfAnySize(symmetric).vectors.col(0).dot(axes.vectors.col(0))), 1, 1e-9);

  const auto inverse = InverseOf(any);
  ASSERT_TRUE(inverse);
  EXPECT_LT((*inverse * any - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_FALSE(InverseOf(Vector3d(1, 2, 3) * Vector3d(3, 2, 1).transpose())) << "of rank one";
}

TEST(SmallMatrices, NormalEquationsAreSolved) {
  std::mt19937 random(3);
  std::normal_distribution<double> number;
  Eigen::Matrix<double, 6, 6> any;
  Eigen::Matrix<double, 6, 1> x;
  for (Eigen::Index i = 0; i < any.size(); ++i) any.data()[i] = number(random);
  for (Eigen::Index i = 0; i < 6; ++i) x(i) = number(random);
  const Eigen::Matrix<double, 6, 6> normal = any * any.transpose();
  EXPECT_LT((SolveNormal(normal, Eigen::Matrix<double, 6, 1>(normal * x)) - x).norm(), 1e-7);
  const Eigen::Matrix3d corner = normal.topLeftCorner<3, 3>();
  const Vector3d part = x.head<3>();
  EXPECT_LT((SolveNormal(corner, Vector3d(corner * part)) - part).norm(), 1e-7);
}

TEST(SmallMatrices, RotationTakesAnyDirectionToAnother) {
  const Vector3d from(0.3, -0.2, 2);
  for (const Vector3d& to : {Vector3d(1, 2, 3), Vector3d(-from), from})
    EXPECT_LT((TurnBetween(from, to) * from.normalized() - to.normalized()).norm(), 1e-9) << to.transpose();
  EXPECT_NEAR(TurnBetween({1, 0, 0}, {0, 1, 0}).angularDistance(Eigen::Quaterniond::Identity()), M_PI / 2,
              1e-12);
}

TEST(ViewNumbers, AreNamedInRuns) {
  EXPECT_EQ(ViewNumbers({}), "");
  EXPECT_EQ(ViewNumbers({7}), "view 7");
  EXPECT_EQ(ViewNumbers({3, 4}), "views 3 and 4");
  EXPECT_EQ(ViewNumbers({1, 3, 4}), "views 1, 3 and 4");
  EXPECT_EQ(ViewNumbers({1, 2, 3, 5, 7, 8, 9}), "views 1 to 3, 5 and 7 to 9");
  EXPECT_EQ(ViewNumbers({1, 3, 5, 7, 9, 11, 13, 15}), "views 1, 3, 5, 7, 9 and 3 more");
}

}  // namespace
}  // namespace ulf::values_test
