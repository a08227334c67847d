#include "tests/tracking/textured_room.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::test {
namespace {

// Noise on several scales and rectangles of all sizes: corners on every pyramid level.
cv::Mat MakeTexture(cv::Size size, unsigned seed) {
  cv::RNG random(seed);
  cv::Mat sum = cv::Mat::zeros(size, CV_32F);
  for (const int step : {4, 12, 40}) {
    cv::Mat coarse(size.height / step + 2, size.width / step + 2, CV_32F), fine;
    random.fill(coarse, cv::RNG::UNIFORM, -30, 30);
    cv::resize(coarse, fine, size, 0, 0, cv::INTER_CUBIC);
    sum += fine;
  }
  const int rectangles = size.area() / 1200;
  for (int i = 0; i < rectangles; ++i) {
    const cv::Rect rectangle(random.uniform(0, size.width), random.uniform(0, size.height),
                             random.uniform(6, 50), random.uniform(6, 50));
    const cv::Rect inside = rectangle & cv::Rect({}, size);
    if (!inside.empty()) sum(inside) += random.uniform(-40.0, 40.0);
  }
  cv::Mat texture;
  sum.convertTo(texture, CV_8U, 1, 128);
  cv::GaussianBlur(texture, texture, {}, 0.8);
  return texture;
}

}  // namespace

TexturedRoom::TexturedRoom(const Options& options) : options_(options) {
  const auto add = [&](Eigen::Vector3d center, double width, double height, double turn_deg, double tilt_deg,
                       double pixels_per_m) {
    const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(turn_deg * M_PI / 180, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(tilt_deg * M_PI / 180, Eigen::Vector3d::UnitX()))
                                         .toRotationMatrix();
    Plane plane;
    plane.along_x = rotation.col(0);
    plane.along_y = rotation.col(1);
    plane.corner = center - 0.5 * width * plane.along_x - 0.5 * height * plane.along_y;
    plane.pixels_per_m = pixels_per_m;
    plane.texture =
        MakeTexture({static_cast<int>(width * pixels_per_m), static_cast<int>(height * pixels_per_m)},
                    options.seed * 100 + static_cast<unsigned>(planes_.size()));
    planes_.push_back(std::move(plane));
  };
  add({0, 0, 3}, 9, 7, 0, 0, 200);
  if (!options.panels) return;
  add({-0.9, 0.2, 2.4}, 0.9, 1.2, 25, 0, 260);
  add({0.8, -0.3, 2.2}, 0.8, 0.8, -20, 10, 280);
  add({0.1, 0.4, 1.7}, 0.6, 0.5, 10, -15, 330);
}

Frame TexturedRoom::Take(const Rigid3& cam_from_world, std::uint64_t id, const CameraModel& camera) const {
  cv::Mat image(camera.height, camera.width, CV_8U, cv::Scalar(128));
  for (const Plane& plane : planes_) {
    // Texture pixel (integer-centred) to plane to camera to image (integer-centred, as warpPerspective
    // counts).
    Eigen::Matrix3d plane_from_texture;
    plane_from_texture << 1 / plane.pixels_per_m, 0, 0.5 / plane.pixels_per_m,  //
        0, 1 / plane.pixels_per_m, 0.5 / plane.pixels_per_m, 0, 0, 1;
    Eigen::Matrix3d cam_from_plane;
    cam_from_plane.col(0) = cam_from_world.rotation * plane.along_x;
    cam_from_plane.col(1) = cam_from_world.rotation * plane.along_y;
    cam_from_plane.col(2) = cam_from_world * plane.corner;
    Eigen::Matrix3d intrinsics;
    intrinsics << camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1;
    const Eigen::Matrix3d map = intrinsics * cam_from_plane * plane_from_texture;
    cv::Matx33d matrix;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) matrix(r, c) = map(r, c);
    cv::warpPerspective(plane.texture, image, matrix, image.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
  }
  if (options_.noise > 0) {
    cv::RNG random(static_cast<std::uint64_t>(options_.seed) * 100003 + id + 1);
    cv::Mat noise(image.size(), CV_16S), noisy;
    random.fill(noise, cv::RNG::NORMAL, 0, options_.noise);
    image.convertTo(noisy, CV_16S);
    noisy += noise;
    noisy.convertTo(image, CV_8U);
  }
  Frame frame;
  frame.image.pixels = image;
  frame.id = id;
  frame.device_time_s = static_cast<double>(id) / 30;
  frame.known_cam_from_world = cam_from_world;
  return frame;
}

Rigid3 TexturedRoom::HandAt(int frame) {
  const double t = frame / 30.0;
  const Eigen::Vector3d center(0.5 * std::sin(0.9 * t), 0.2 * std::sin(1.7 * t), 0.15 * std::sin(1.1 * t));
  const Eigen::Vector3d target(0.1 * std::sin(2.3 * t), 0.05 * std::cos(1.9 * t), 2.5);
  return LookAt(center, target, -Eigen::Vector3d::UnitY());
}

Rigid3 TexturedRoom::TurningAt(int frame) {
  const double t = frame / 30.0;
  const Eigen::Vector3d target(std::sin(0.8 * t), 0.4 * std::sin(1.3 * t), 2.5);
  return LookAt(Eigen::Vector3d::Zero(), target, -Eigen::Vector3d::UnitY());
}

}  // namespace ulf::test
