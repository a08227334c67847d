#include "tests/tracking/scenes/textured_room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kWallZ = 3;
constexpr double kMirrorWidth = 1.2, kMirrorHeight = 0.9;
const Vector3d kMirrorCenter(-0.2, -0.3, kWallZ);

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

Matrix3d Turned(double turn_deg, double tilt_deg) {
  return (Eigen::AngleAxisd(turn_deg * M_PI / 180, Vector3d::UnitY()) *
          Eigen::AngleAxisd(tilt_deg * M_PI / 180, Vector3d::UnitX()))
      .toRotationMatrix();
}

// A rectangle's outline in the picture, integer-centred pixels: the part before the camera.
std::vector<cv::Point> Outline(const std::array<Vector3d, 4>& corners, const CameraModel& camera) {
  constexpr double kNear = 0.05;
  std::vector<cv::Point> outline;
  const auto add = [&](const Vector3d& in_cam) {
    const double most = 20.0 * camera.width;
    outline.emplace_back(
        static_cast<int>(std::clamp(camera.fx * in_cam.x() / in_cam.z() + camera.cx - 0.5, -most, most)),
        static_cast<int>(std::clamp(camera.fy * in_cam.y() / in_cam.z() + camera.cy - 0.5, -most, most)));
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d &a = corners[i], &b = corners[(i + 1) % 4];
    if (a.z() > kNear) add(a);
    if ((a.z() > kNear) != (b.z() > kNear)) add(a + (b - a) * ((kNear - a.z()) / (b.z() - a.z())));
  }
  return outline;
}

}  // namespace

void TexturedRoom::Add(const Vector3d& center, const Matrix3d& axes, double width, double height,
                       double pixels_per_m) {
  Plane plane;
  plane.along_x = axes.col(0);
  plane.along_y = axes.col(1);
  plane.corner = center - 0.5 * width * plane.along_x - 0.5 * height * plane.along_y;
  plane.pixels_per_m = pixels_per_m;
  plane.texture =
      MakeTexture({static_cast<int>(width * pixels_per_m), static_cast<int>(height * pixels_per_m)},
                  options_.seed * 100 + static_cast<unsigned>(planes_.size()));
  planes_.push_back(std::move(plane));
}

TexturedRoom::TexturedRoom(const Options& options) : options_(options) {
  scrolling_ = MakeTexture({640, 700}, options.seed * 100 + 99);
  const Matrix3d facing = Matrix3d::Identity();
  if (options.furniture == Furniture::kCorridor) {
    constexpr double kLength = 14, kMiddle = 6;
    Add({0, 0, 13}, facing, 2.4, 2.4, 100);
    for (const double side : {-1.2, 1.2}) {
      Add({side, 0, kMiddle}, Turned(90, 0), kLength, 2.4, 140);  // its x axis runs along z
      Add({0, side, kMiddle}, Turned(0, 90), 2.4, kLength, 140);
    }
    return;
  }
  if (options.furniture == Furniture::kRound) {
    // Every second one further away, and drawn first: those between hide their edges.
    constexpr int kWalls = 12;
    for (const bool near : {false, true})
      for (int i = near; i < kWalls; i += 2) {
        const double turn_deg = 360.0 * i / kWalls;
        const Matrix3d axes = Turned(turn_deg, near ? 8 : 0);
        Add((near ? 2.6 + 0.05 * i : 3.4) * axes.col(2), axes, near ? 1.3 : 3.0, near ? 2.4 : 4.5,
            near ? 240 : 190);
      }
    return;
  }
  if (options.furniture == Furniture::kRepeated) {
    constexpr int kTimes = 4;
    cv::RNG random(options.seed);
    for (int i = 0; i < 4; ++i) {
      const Matrix3d axes = Turned(90.0 * i, 0);
      Add(kWallZ * axes.col(2), axes, 2 * kWallZ, 4, 160);
      cv::Mat& wall = planes_.back().texture;
      const cv::Mat part = planes_.front().texture.colRange(0, wall.cols / kTimes).clone();
      const int down = random.uniform(0, part.rows);
      cv::Mat moved;
      cv::vconcat(part.rowRange(down, part.rows), part.rowRange(0, down), moved);
      cv::repeat(moved, 1, kTimes, wall);
    }
    Add({0, 2, 0}, Turned(0, 90), 2 * kWallZ, 2 * kWallZ, 160);
    return;
  }
  Add({0, 0, kWallZ}, facing, 9, 7, 200);
  switch (options.furniture) {
    case Furniture::kTiles: {
      cv::Mat& wall = planes_[0].texture;
      const int size = static_cast<int>(kTile * planes_[0].pixels_per_m);
      const cv::Mat tile = wall(cv::Rect(0, 0, size, size)).clone();
      cv::rectangle(tile, {0, 0, size, size}, cv::Scalar(30), 3);
      cv::Mat tiled;
      cv::repeat(tile, wall.rows / size, wall.cols / size, tiled);
      wall = tiled;
      Add({-0.7, 0.2, 2.4}, Turned(25, 0), 0.6, 0.8, 260);
      Add({0.5, -0.2, 2.2}, Turned(-20, 10), 0.5, 0.5, 280);
      break;
    }
    case Furniture::kMosaic: {
      cv::Mat& wall = planes_[0].texture;
      const int size = static_cast<int>(kTile * planes_[0].pixels_per_m);
      const cv::Mat tile = wall(cv::Rect(0, 0, size, size)).clone();
      cv::RNG random(options.seed);
      for (int y = 0; y + size <= wall.rows; y += size)
        for (int x = 0; x + size <= wall.cols; x += size)
          if (random.uniform(0.0, 1.0) < options.equal_share) tile.copyTo(wall(cv::Rect(x, y, size, size)));
      break;
    }
    case Furniture::kBox:  // two of its sides
      Add({0.0, 0.2, 2.6}, facing * Turned(45, 0), 0.5, 0.6, 300);
      Add({0.3536, 0.2, 2.6}, facing * Turned(-45, 0), 0.5, 0.6, 300);
      break;
    case Furniture::kPanels:
    case Furniture::kMirror:
      Add({-0.9, 0.2, 2.4}, Turned(25, 0), 0.9, 1.2, 260);
      Add({0.8, -0.3, 2.2}, Turned(-20, 10), 0.8, 0.8, 280);
      Add({0.1, 0.4, 1.7}, Turned(10, -15), 0.6, 0.5, 330);
      break;
    case Furniture::kWall:
    case Furniture::kCorridor:
    case Furniture::kRound:
    case Furniture::kRepeated:
      break;
  }
  if (options.furniture != Furniture::kMirror) return;
  Add({0, 0, -2}, facing, 9, 7, 200);  // behind the camera
  mirrored_ = {planes_.back()};
  planes_.pop_back();
  for (std::size_t i = planes_.size(); i-- > 1;) mirrored_.push_back(planes_[i]);  // the nearest is farthest
  for (Plane& plane : mirrored_) {
    plane.corner.z() = 2 * kWallZ - plane.corner.z();
    plane.along_x.z() = -plane.along_x.z();
    plane.along_y.z() = -plane.along_y.z();
  }
}

void TexturedRoom::Draw(const Plane& plane, const Rigid3& cam_from_world, const CameraModel& camera,
                        cv::Mat& image) const {
  // Texture pixel (integer-centred) to plane to camera to image (integer-centred, as warpPerspective counts).
  Matrix3d plane_from_texture;
  plane_from_texture << 1 / plane.pixels_per_m, 0, 0.5 / plane.pixels_per_m,  //
      0, 1 / plane.pixels_per_m, 0.5 / plane.pixels_per_m, 0, 0, 1;
  Matrix3d cam_from_plane;
  cam_from_plane.col(0) = cam_from_world.rotation * plane.along_x;
  cam_from_plane.col(1) = cam_from_world.rotation * plane.along_y;
  cam_from_plane.col(2) = cam_from_world * plane.corner;
  Matrix3d intrinsics;
  intrinsics << camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1;
  const Matrix3d map = intrinsics * cam_from_plane * plane_from_texture;
  cv::Matx33d matrix;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix(r, c) = map(r, c);
  const Vector3d across = plane.texture.cols / plane.pixels_per_m * cam_from_plane.col(0);
  const Vector3d down = plane.texture.rows / plane.pixels_per_m * cam_from_plane.col(1);
  const Vector3d corner = cam_from_plane.col(2);
  const std::array<Vector3d, 4> corners{corner, corner + across, corner + across + down, corner + down};
  // Only where the plane is: a room has many of them, and most stand beside or behind the camera.
  std::vector<cv::Point> outline = Outline(corners, camera);
  if (outline.size() < 3) return;
  cv::Rect where = cv::boundingRect(outline);
  where = cv::Rect(where.tl() - cv::Point(2, 2), where.br() + cv::Point(2, 2)) & cv::Rect({}, image.size());
  if (where.empty()) return;
  const cv::Matx33d into_part(1, 0, -where.x, 0, 1, -where.y, 0, 0, 1);
  cv::Mat part = image(where);
  const auto warp = [&](cv::Mat& into) {
    cv::warpPerspective(plane.texture, into, into_part * matrix, where.size(), cv::INTER_LINEAR,
                        cv::BORDER_TRANSPARENT);
  };
  const bool behind =
      std::any_of(corners.begin(), corners.end(), [](const Vector3d& c) { return c.z() < 0.05; });
  if (!behind) {
    warp(part);
    return;
  }
  // What is behind the camera would be drawn upside down.
  cv::Mat mask = cv::Mat::zeros(where.size(), CV_8U), drawn = part.clone();
  for (cv::Point& point : outline) point -= where.tl();
  cv::fillConvexPoly(mask, outline, cv::Scalar(255));
  warp(drawn);
  drawn.copyTo(part, mask);
}

void TexturedRoom::DrawMirror(const Rigid3& cam_from_world, const CameraModel& camera, cv::Mat& image) const {
  cv::Mat behind = image.clone();
  for (const Plane& plane : mirrored_) Draw(plane, cam_from_world, camera, behind);
  std::array<Vector3d, 4> corners;
  constexpr std::array<std::array<double, 2>, 4> kSigns{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = cam_from_world * (kMirrorCenter + 0.5 * Vector3d(kSigns[i][0] * kMirrorWidth,
                                                                  kSigns[i][1] * kMirrorHeight, 0));
  const std::vector<cv::Point> outline = Outline(corners, camera);
  if (outline.size() < 3) return;
  cv::Mat mask = cv::Mat::zeros(image.size(), CV_8U);
  cv::fillConvexPoly(mask, outline, cv::Scalar(255));
  behind.copyTo(image, mask);
}

Frame TexturedRoom::Take(const Rigid3& cam_from_world, std::uint64_t id, const CameraModel& camera,
                         const Moment& moment) const {
  cv::Mat image(camera.height, camera.width, CV_8U, cv::Scalar(128));
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    const Eigen::Vector3d shift = i > 0 ? moment.furniture_shift : Eigen::Vector3d::Zero();
    Draw(planes_[i], cam_from_world * Rigid3{Eigen::Quaterniond::Identity(), shift}, camera, image);
    if (i == 0 && !mirrored_.empty()) DrawMirror(cam_from_world, camera, image);
  }
  const double t = static_cast<double>(id) / 30;
  if (moment.moving_half) {
    const int width = camera.width / 2;
    const int start = static_cast<int>(0.15 * camera.height * (1 + std::sin(3.6 * t)));
    scrolling_(cv::Rect(0, start, width, camera.height)).copyTo(image(cv::Rect(0, 0, width, camera.height)));
  }
  if (moment.shadow) {
    const double edge = camera.width * (0.5 + 0.4 * std::sin(1.5 * t)), penumbra = 0.01 * camera.width;
    for (int x = 0; x < camera.width; ++x) {
      const double light = 0.75 - 0.25 * std::clamp((x - edge) / penumbra, -1.0, 1.0);
      image.col(x) *= light;
    }
  }
  if (const double length = moment.blur_px.norm(); length > 1) {
    const int half = static_cast<int>(length / 2) + 1;
    cv::Mat line = cv::Mat::zeros(2 * half + 1, 2 * half + 1, CV_32F);
    const Eigen::Vector2d end = 0.5 * moment.blur_px;
    cv::line(line, cv::Point2d(half - end.x(), half - end.y()), cv::Point2d(half + end.x(), half + end.y()),
             cv::Scalar(1));
    cv::filter2D(image, image, -1, line / cv::sum(line)[0], {-1, -1}, 0, cv::BORDER_REPLICATE);
  }
  if (moment.gain != 1) image *= moment.gain;
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
  frame.device_time_s = t;
  frame.known_cam_from_world = cam_from_world;
  return frame;
}

Frame TexturedRoom::TakeRolling(const std::function<Rigid3(double)>& motion, int frame, double readout_s,
                                const CameraModel& camera, int bands) const {
  cv::Mat image(camera.height, camera.width, CV_8U);
  for (int band = 0; band < bands; ++band) {
    const int first = camera.height * band / bands, end = camera.height * (band + 1) / bands;
    CameraModel rows = camera;
    rows.height = end - first;
    rows.cy -= first;
    const double time_s = readout_s * (0.5 * (first + end) / camera.height - 0.5);
    Take(motion(frame + 30 * time_s), static_cast<std::uint64_t>(frame * bands + band), rows)
        .image.pixels.copyTo(image.rowRange(first, end));
  }
  Frame taken = Take(motion(frame), static_cast<std::uint64_t>(frame), camera);
  taken.image.pixels = image;
  return taken;
}

Rigid3 TexturedRoom::TurningAndSwayingAt(double frame) {
  const double t = frame / 19;
  const double begun = std::min(1.0, frame / 15);
  const auto about = [](double deg, const Vector3d& axis) {
    return Eigen::AngleAxisd(deg * M_PI / 180, axis);
  };
  const Eigen::Quaterniond turn = about(35 * std::sin(0.9 * t + 1.7) * begun, Vector3d::UnitY()) *
                                  about(18 * std::sin(1.3 * t + 1), Vector3d::UnitX()) *
                                  about(15 * std::sin(1.7 * t + 0.5), Vector3d::UnitZ());
  const Vector3d center(std::sin(0.7 * t + 1.7), 0.6 * std::sin(1.1 * t + 3.4),
                        0.7 * std::sin(0.5 * t + 0.7));
  return Rigid3{turn, 0.2 * center}.Inverse();
}

Rigid3 TexturedRoom::HandAt(int frame) {
  const double t = frame / 30.0;
  const Vector3d center(0.5 * std::sin(0.9 * t), 0.2 * std::sin(1.7 * t), 0.15 * std::sin(1.1 * t));
  const Vector3d target(0.1 * std::sin(2.3 * t), 0.05 * std::cos(1.9 * t), 2.5);
  return LookAt(center, target, -Vector3d::UnitY());
}

Rigid3 TexturedRoom::TurningAt(int frame) {
  const double t = frame / 30.0;
  const Vector3d target(std::sin(0.8 * t), 0.4 * std::sin(1.3 * t), 2.5);
  return LookAt(Vector3d::Zero(), target, -Vector3d::UnitY());
}

Rigid3 TexturedRoom::WalkingAt(int frame) {
  const double t = frame / 30.0;
  const Vector3d center(0.02 * std::sin(5 * t), 0.02 * std::sin(7 * t), 0.8 * t);
  return LookAt(center, {0.1 * std::sin(1.1 * t), 0.05 * std::sin(1.7 * t), 13}, -Vector3d::UnitY());
}

Rigid3 TexturedRoom::RoundAt(int frame) {
  const double angle = 2 * M_PI * frame / kRoundFrames;
  const Vector3d outwards(std::sin(angle), 0, std::cos(angle));
  const Vector3d sway(0, 0.15 * std::sin(9 * angle), 0);
  return LookAt(outwards + sway, 3 * outwards, -Vector3d::UnitY());
}

}  // namespace ulf::test
