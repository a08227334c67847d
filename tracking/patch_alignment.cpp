#include "tracking/patch_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ulf {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTemplate = 8;
constexpr int kFramed = kTemplate + 2;  // one more on each side for central differences
constexpr double kMinCorrelation = 0.85;

// Integer-centred coordinates; the caller has checked that the four neighbours exist.
inline float Bilinear(const std::uint8_t* pixels, std::size_t stride, float x, float y) {
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const std::uint8_t* p = pixels + static_cast<std::size_t>(iy) * stride + ix;
  const float top = p[0] + fx * static_cast<float>(p[1] - p[0]);
  const float bottom = p[stride] + fx * static_cast<float>(p[stride + 1] - p[stride]);
  return top + fy * (bottom - top);
}

struct Template {
  std::array<float, kTemplate * kTemplate> value, by_x, by_y;
};

// `reference_by_level`: reference-level pixels per pixel of the image level that is aligned with.
std::optional<Template> Warp(const ReferencePatch& patch, const Matrix2d& reference_by_level) {
  constexpr float kCenter = (ReferencePatch::kSide - 1) * 0.5f;
  constexpr float kHalf = (kFramed - 1) * 0.5f;
  const Eigen::Matrix2f warp = reference_by_level.cast<float>();
  const float reach = kHalf * std::max(std::abs(warp(0, 0)) + std::abs(warp(0, 1)),
                                       std::abs(warp(1, 0)) + std::abs(warp(1, 1)));
  if (!(reach < kCenter - 0.01f)) return std::nullopt;
  float framed[kFramed][kFramed];
  for (int v = 0; v < kFramed; ++v)
    for (int u = 0; u < kFramed; ++u) {
      const Eigen::Vector2f at =
          warp * Eigen::Vector2f(static_cast<float>(u) - kHalf, static_cast<float>(v) - kHalf);
      framed[v][u] = Bilinear(patch.pixels.data(), ReferencePatch::kSide, at.x() + kCenter, at.y() + kCenter);
    }
  Template made;
  for (int v = 0; v < kTemplate; ++v)
    for (int u = 0; u < kTemplate; ++u) {
      const std::size_t i = static_cast<std::size_t>(v * kTemplate + u);
      made.value[i] = framed[v + 1][u + 1];
      made.by_x[i] = 0.5f * (framed[v + 1][u + 2] - framed[v + 1][u]);
      made.by_y[i] = 0.5f * (framed[v + 2][u + 1] - framed[v][u + 1]);
    }
  return made;
}

// The 8x8 of the image around a level point (integer-centred); false where it leaves the image.
bool Sample(const cv::Mat& image, const Vector2d& center, std::array<float, kTemplate * kTemplate>& values) {
  constexpr double kHalf = (kTemplate - 1) * 0.5;
  const double left = center.x() - kHalf, top = center.y() - kHalf;
  if (!(left >= 0 && top >= 0 && left + kTemplate < image.cols && top + kTemplate < image.rows)) return false;
  const int ix = static_cast<int>(left), iy = static_cast<int>(top);
  const float fx = static_cast<float>(left - ix), fy = static_cast<float>(top - iy);
  const float w00 = (1 - fx) * (1 - fy), w01 = fx * (1 - fy), w10 = (1 - fx) * fy, w11 = fx * fy;
  for (int v = 0; v < kTemplate; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(iy + v) + ix;
    const std::uint8_t* below = image.ptr<std::uint8_t>(iy + v + 1) + ix;
    for (int u = 0; u < kTemplate; ++u)
      values[static_cast<std::size_t>(v * kTemplate + u)] =
          w00 * row[u] + w01 * row[u + 1] + w10 * below[u] + w11 * below[u + 1];
  }
  return true;
}

double Correlation(const std::array<float, kTemplate * kTemplate>& a,
                   const std::array<float, kTemplate * kTemplate>& b) {
  float sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum_a += a[i];
    sum_b += b[i];
    aa += a[i] * a[i];
    bb += b[i] * b[i];
    ab += a[i] * b[i];
  }
  constexpr float kCount = kTemplate * kTemplate;
  const float var_a = aa - sum_a * sum_a / kCount, var_b = bb - sum_b * sum_b / kCount;
  if (var_a < kCount || var_b < kCount) return 0;  // less than one grey level: nothing to align
  return (ab - sum_a * sum_b / kCount) / std::sqrt(var_a * var_b);
}

}  // namespace

std::optional<ReferencePatch> CutPatch(const Pyramid& pyramid, const Vector2d& img, int level) {
  constexpr int kSide = ReferencePatch::kSide;
  const cv::Mat& image = pyramid.levels[static_cast<std::size_t>(level)];
  const Vector2d center = pyramid.ToLevel(level, img) - Vector2d(0.5, 0.5);
  const Vector2d corner = center - Vector2d::Constant((kSide - 1) * 0.5);
  if (!(corner.x() >= 0 && corner.y() >= 0 && corner.x() + kSide < image.cols &&
        corner.y() + kSide < image.rows))
    return std::nullopt;
  ReferencePatch patch;
  patch.level = level;
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      patch.pixels[static_cast<std::size_t>(v * kSide + u)] =
          static_cast<std::uint8_t>(Bilinear(image.data, image.step, static_cast<float>(corner.x() + u),
                                             static_cast<float>(corner.y() + v)) +
                                    0.5f);
  return patch;
}

std::optional<PatchAxes> AxesOf(const CameraModel& camera, const Rigid3& reference_from_world,
                                const Vector3d& point_in_world, int level) {
  Eigen::Matrix<double, 2, 3> img_by_point;
  const Vector3d in_reference = reference_from_world * point_in_world;
  if (!camera.ImgFromCam(in_reference, &img_by_point)) return std::nullopt;
  const Vector3d toward = in_reference.normalized();
  Eigen::Matrix<double, 3, 2> facing;
  facing.col(0) = toward.unitOrthogonal();
  facing.col(1) = toward.cross(facing.col(0));
  const Matrix2d level_by_facing = img_by_point * facing / LevelScale(level);
  if (std::abs(level_by_facing.determinant()) < 1e-12) return std::nullopt;
  return PatchAxes(reference_from_world.rotation.conjugate().toRotationMatrix() * facing *
                   level_by_facing.inverse());
}

std::optional<PatchAlignment> AlignPatch(const CameraModel& camera, const ReferencePatch& patch,
                                         const PatchAxes& axes, const Vector3d& point_in_world,
                                         const Rigid3& cam_from_world, const Pyramid& pyramid,
                                         const Vector2d& expected_img, double max_shift) {
  Eigen::Matrix<double, 2, 3> img_by_point;
  if (!camera.ImgFromCam(cam_from_world * point_in_world, &img_by_point)) return std::nullopt;
  const Matrix2d img_by_reference = img_by_point * cam_from_world.RotationMatrix() * axes;
  const double area = img_by_reference.determinant();
  if (!(area > 1e-3 && area < 1e3)) return std::nullopt;
  // The level on which a patch pixel is about one pixel.
  const int level = std::clamp(static_cast<int>(std::lround(0.5 * std::log(area) / std::log(kPyramidFactor))),
                               0, kPyramidLevels - 1);
  const auto warped = Warp(patch, (img_by_reference / LevelScale(level)).inverse());
  if (!warped) return std::nullopt;

  // Unknown: shift of the template, gain and offset of the image; the Hessian is the template's alone.
  Eigen::Matrix4f hessian = Eigen::Matrix4f::Zero();
  for (std::size_t i = 0; i < warped->value.size(); ++i) {
    const Eigen::Vector4f jacobian(warped->by_x[i], warped->by_y[i], warped->value[i] * (1 / 128.f), 1);
    hessian += jacobian * jacobian.transpose();
  }
  const Eigen::LDLT<Eigen::Matrix4f> solver(hessian);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-3f)) return std::nullopt;

  const cv::Mat& image = pyramid.levels[static_cast<std::size_t>(level)];
  const Vector2d start = pyramid.ToLevel(level, expected_img) - Vector2d(0.5, 0.5);
  Vector2d at = start;
  std::array<float, kTemplate * kTemplate> seen;
  bool settled = false;
  constexpr int kIterations = 8;
  for (int iteration = 0; iteration < kIterations && !settled; ++iteration) {
    if (!Sample(image, at, seen)) return std::nullopt;
    Eigen::Vector4f right = Eigen::Vector4f::Zero();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const float difference = seen[i] - warped->value[i];
      right +=
          difference * Eigen::Vector4f(warped->by_x[i], warped->by_y[i], warped->value[i] * (1 / 128.f), 1);
    }
    const Eigen::Vector4f step = solver.solve(right);
    const Vector2d shift(step(0), step(1));
    if (!shift.allFinite()) return std::nullopt;
    at -= shift;
    if ((at - start).squaredNorm() > max_shift * max_shift) return std::nullopt;
    settled = shift.squaredNorm() < 0.02 * 0.02;
  }
  if (!settled || !Sample(image, at, seen)) return std::nullopt;
  const double correlation = Correlation(warped->value, seen);
  if (correlation < kMinCorrelation) return std::nullopt;
  return PatchAlignment{pyramid.FromLevel(level, at + Vector2d(0.5, 0.5)), level, correlation};
}

}  // namespace ulf
