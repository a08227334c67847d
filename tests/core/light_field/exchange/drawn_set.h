// A set of drawn photographs for readers of other programs' sets: each shows a few points as spots, where the
// program's own formula has them, so that a set that is read right has its points on the spots of its
// pictures.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::test {

// A camera of a drawn set: x right, y down, z forward.
struct DrawnCamera {
  std::string name;
  Eigen::Matrix3d cam_from_world;
  Eigen::Vector3d center;

  Eigen::Vector3d InCam(const Eigen::Vector3d& point) const { return cam_from_world * (point - center); }
  Eigen::Vector3d Translation() const { return -(cam_from_world * center); }
};

class DrawnSet : public testing::Test {
 protected:
  static constexpr int kDrawnWidth = 240, kDrawnHeight = 180;
  static constexpr double kSpot_px = 1.5;  // standard deviation
  // Returns the image point of a point of the camera's frame, by the formula of the other program.
  using Formula = std::function<Eigen::Vector2d(const Eigen::Vector3d& point_in_cam)>;

  DrawnSet() {
    // Cameras on an arc, not upright, and points on a grid of uneven depth.
    for (int i = 0; i < 5; ++i) {
      const double angle = 0.14 * (i - 2);
      const Eigen::Vector3d center(4 * std::sin(angle) + 0.3, -0.2 + 0.1 * i, 1.5 - 4 * std::cos(angle));
      const Eigen::Vector3d forward = (Eigen::Vector3d(0.3, 0.1, 1.5) - center).normalized();
      const Eigen::Vector3d up = Eigen::Vector3d(0.1 * i - 0.15, -1, 0.05).normalized();
      const Eigen::Vector3d right = forward.cross(up).normalized();
      Eigen::Matrix3d cam_from_world;
      cam_from_world << right.transpose(), forward.cross(right).transpose(), forward.transpose();
      cameras_.push_back({fmt::format("shot_{}.png", i), cam_from_world, center});
    }
    for (int row = -1; row <= 1; ++row)
      for (int column = -2; column <= 2; ++column)
        points_.emplace_back(0.3 + 0.75 * column, 0.1 + 0.95 * row, 1.5 + 0.2 * ((row + 2 * column + 6) % 3));
  }

  // Draws the photographs. `first_pixel` is where the formula has the centre of the first pixel (0 or 0.5).
  void Draw(const std::filesystem::path& folder, const Formula& formula, double first_pixel,
            cv::Size size = {kDrawnWidth, kDrawnHeight}) {
    std::filesystem::create_directories(folder);
    for (const DrawnCamera& camera : cameras_) {
      cv::Mat light(size, CV_32F, cv::Scalar(20));
      for (const Eigen::Vector3d& point : points_) {
        const Eigen::Vector2d at = formula(camera.InCam(point)) - Eigen::Vector2d::Constant(first_pixel);
        constexpr int kReach = 9;
        const int x0 = static_cast<int>(at.x()), y0 = static_cast<int>(at.y());
        for (int y = std::max(0, y0 - kReach); y < std::min(light.rows, y0 + kReach); ++y)
          for (int x = std::max(0, x0 - kReach); x < std::min(light.cols, x0 + kReach); ++x)
            light.at<float>(y, x) += static_cast<float>(
                220 * std::exp(-0.5 * (Eigen::Vector2d(x, y) - at).squaredNorm() / kSpot_px / kSpot_px));
      }
      cv::Mat picture;
      light.convertTo(picture, CV_8U);
      cv::imwrite((folder / camera.name).string(), picture);
    }
  }

  // Expects every view's points on the spots of its picture, whose pixels have their centres at integer +
  // 0.5.
  void ExpectSpots(const LightField& read, std::size_t views = 5) const {
    constexpr double kOff_px = 0.05;
    constexpr int kAround = 6;
    EXPECT_EQ(read.views.size(), views);
    for (const View& view : read.views) {
      const cv::Mat picture = cv::imread((read.root / view.image_path).string(), cv::IMREAD_GRAYSCALE);
      ASSERT_FALSE(picture.empty()) << view.image_path;
      std::size_t compared = 0;
      for (const Eigen::Vector3d& point : points_) {
        const auto img = read.CameraOf(view).ImgFromCam(view.cam_from_world * point);
        ASSERT_TRUE(img) << view.image_path;
        const int x0 = static_cast<int>(img->x()), y0 = static_cast<int>(img->y());
        if (x0 < kAround || y0 < kAround || x0 + kAround >= picture.cols || y0 + kAround >= picture.rows)
          continue;
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        double weight = 0;
        for (int y = y0 - kAround; y <= y0 + kAround; ++y)
          for (int x = x0 - kAround; x <= x0 + kAround; ++x) {
            const double light = picture.at<std::uint8_t>(y, x) - 20.0;
            sum += light * Eigen::Vector2d(x + 0.5, y + 0.5);
            weight += light;
          }
        ASSERT_GT(weight, 1000) << view.image_path << ": no spot at " << img->transpose();
        EXPECT_LT((sum / weight - *img).norm(), kOff_px)
            << view.image_path << ", point " << point.transpose();
        ++compared;
      }
      EXPECT_GE(compared, points_.size() - 2) << view.image_path;
    }
  }

  void Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((scratch_ / name).parent_path());
    std::ofstream(scratch_ / name) << text;
  }

  ScratchFolder scratch_;
  std::vector<DrawnCamera> cameras_;
  std::vector<Eigen::Vector3d> points_;
};

// Joins numbers row by row, or column by column.
inline std::string Joined(const Eigen::MatrixXd& matrix, const char* between, bool by_columns = false,
                          const char* quote = "") {
  std::string text;
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    const double value = by_columns ? matrix(i % matrix.rows(), i / matrix.rows())
                                    : matrix(i / matrix.cols(), i % matrix.cols());
    text += fmt::format("{}{}{:.17g}{}", i == 0 ? "" : between, quote, value, quote);
  }
  return text;
}

}  // namespace ulf::test
