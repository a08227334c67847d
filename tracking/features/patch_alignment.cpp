#include "tracking/features/patch_alignment.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/at.h"

namespace ulf::tracking {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kAlignmentIterations = 8;  // an alignment that has not settled by then is refused. Guessed
constexpr double kSettledStep = 0.02;    // level pixels; a smaller step ends the alignment. Guessed

constexpr int kTemplate = 8;
constexpr int kFramed = kTemplate + 2;  // with a border for central differences

// A row of the template. Sums run over eight lanes side by side, which are added last and always in the same
// order: the result does not depend on how wide the machine's vectors are.
using Float8 = float __attribute__((vector_size(32)));
using Rows = std::array<Float8, kTemplate>;

inline float Sum(const Float8& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

inline Float8 LoadBytes(const std::uint8_t* from) {
#ifdef __AVX2__
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
#else
  using Int8 = std::int32_t __attribute__((vector_size(32)));
  using Byte8 = std::uint8_t __attribute__((vector_size(8)));
  Byte8 bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return __builtin_convertvector(__builtin_convertvector(bytes, Int8), Float8);
#endif
}

inline Float8 LoadFloats(const float* from) {
  Float8 floats;
  std::memcpy(&floats, from, sizeof floats);
  return floats;
}

// Integer-centred coordinates; the caller has checked that the four neighbours exist.
inline float Bilinear(const std::uint8_t* pixels, std::size_t stride, float x, float y) {
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const std::uint8_t* p = pixels + At(iy) * stride + ix;
  const float top = p[0] + fx * static_cast<float>(p[1] - p[0]);
  const float bottom = p[stride] + fx * static_cast<float>(p[stride + 1] - p[stride]);
  return top + fy * (bottom - top);
}

// Warps the patch, with a border of one pixel, row by row; false where the patch is too small.
// `reference_by_level`: reference-level pixels per pixel of the image level that is aligned with.
bool Warp(const ReferencePatch& patch, const Matrix2d& reference_by_level,
          std::array<float, kFramed * kFramed>& framed) {
  constexpr float kCenter = (ReferencePatch::kSide - 1) * 0.5f;
  constexpr float kHalf = (kFramed - 1) * 0.5f;
  const Eigen::Matrix2f warp = reference_by_level.cast<float>();
  const float reach = kHalf * std::max(std::abs(warp(0, 0)) + std::abs(warp(0, 1)),
                                       std::abs(warp(1, 0)) + std::abs(warp(1, 1)));
  if (!(reach < kCenter - 0.01f)) return false;
  // Works in three passes: the compiler vectorises all but the one that fetches the pixels.
  std::array<float, kFramed * kFramed> fx, fy;
  std::array<std::int32_t, kFramed * kFramed> at;
  std::array<std::uint32_t, kFramed * kFramed> four;
  for (int v = 0; v < kFramed; ++v)
    for (int u = 0; u < kFramed; ++u) {
      const float du = static_cast<float>(u) - kHalf, dv = static_cast<float>(v) - kHalf;
      const float x = kCenter + (warp(0, 0) * du + warp(0, 1) * dv);
      const float y = kCenter + (warp(1, 0) * du + warp(1, 1) * dv);
      const auto ix = static_cast<std::int32_t>(x), iy = static_cast<std::int32_t>(y);
      const auto i = At(v * kFramed + u);
      fx[i] = x - static_cast<float>(ix);
      fy[i] = y - static_cast<float>(iy);
      at[i] = iy * ReferencePatch::kSide + ix;
    }
  for (std::size_t i = 0; i < four.size(); ++i) {
    const std::uint8_t* p = patch.pixels.data() + at[i];
    four[i] = static_cast<std::uint32_t>(p[0]) | static_cast<std::uint32_t>(p[1]) << 8 |
              static_cast<std::uint32_t>(p[ReferencePatch::kSide]) << 16 |
              static_cast<std::uint32_t>(p[ReferencePatch::kSide + 1]) << 24;
  }
  for (std::size_t i = 0; i < four.size(); ++i) {
    const auto byte = [&](unsigned k) {
      return static_cast<float>(static_cast<int>(four[i] >> 8 * k & 255u));
    };
    const float top = byte(0) + fx[i] * (byte(1) - byte(0)), bottom = byte(2) + fx[i] * (byte(3) - byte(2));
    framed[i] = top + fy[i] * (bottom - top);
  }
  return true;
}

// Describes what the image is aligned with. Gain and offset of the image are free: the slopes are projected
// orthogonally to the template and to a constant, so that two of four parameters are left to solve for.
struct Template {
  Rows value;
  float sum = 0, sum2 = 0;  // of value
  Rows by_x, by_y;
  Eigen::Matrix2f step_by_right;  // inverse of their normal matrix
};

std::optional<Template> MakeTemplate(const std::array<float, kFramed * kFramed>& framed) {
  constexpr float kCount = kTemplate * kTemplate;
  Template made;
  Float8 value_sum{}, value2{}, x_sum{}, y_sum{}, x_value{}, y_value{};
  for (std::size_t v = 0; v < kTemplate; ++v) {
    const float* row = framed.data() + (v + 1) * kFramed + 1;
    const Float8 value = LoadFloats(row);
    const Float8 x = 0.5f * (LoadFloats(row + 1) - LoadFloats(row - 1));
    const Float8 y = 0.5f * (LoadFloats(row + kFramed) - LoadFloats(row - kFramed));
    made.value[v] = value;
    made.by_x[v] = x;
    made.by_y[v] = y;
    value_sum += value;
    value2 += value * value;
    x_sum += x;
    y_sum += y;
    x_value += x * value;
    y_value += y * value;
  }
  made.sum = Sum(value_sum);
  made.sum2 = Sum(value2);
  const float mean = made.sum / kCount;
  const float variance_sum = made.sum2 - made.sum * mean;
  if (!(variance_sum > kCount)) return std::nullopt;  // less than one grey level: nothing to align
  const float x_mean = Sum(x_sum) / kCount, y_mean = Sum(y_sum) / kCount;
  const float x_gain = (Sum(x_value) - Sum(x_sum) * mean) / variance_sum;
  const float y_gain = (Sum(y_value) - Sum(y_sum) * mean) / variance_sum;
  Float8 xx{}, xy{}, yy{};
  for (std::size_t v = 0; v < kTemplate; ++v) {
    const Float8 centred = made.value[v] - mean;
    made.by_x[v] -= x_mean + x_gain * centred;
    made.by_y[v] -= y_mean + y_gain * centred;
    xx += made.by_x[v] * made.by_x[v];
    xy += made.by_x[v] * made.by_y[v];
    yy += made.by_y[v] * made.by_y[v];
  }
  const float a = Sum(xx), b = Sum(xy), c = Sum(yy);
  const float determinant = a * c - b * b, larger = std::max(a, c);
  constexpr float kLeastSlope = 1e-3f;  // of the normal matrix: less texture determines no shift. Guessed
  if (!(larger > kLeastSlope && determinant > kLeastSlope * larger)) return std::nullopt;
  made.step_by_right << c / determinant, -b / determinant, -b / determinant, a / determinant;
  return made;
}

// Returns the 8x8 of the image around a level point (integer-centred); false where it leaves the image.
bool Sample(const cv::Mat& image, const Vector2d& center, Rows& values) {
  constexpr double kHalf = (kTemplate - 1) * 0.5;
  const double left = center.x() - kHalf, top = center.y() - kHalf;
  if (!(left >= 0 && top >= 0 && left + kTemplate < image.cols && top + kTemplate < image.rows)) return false;
  const int ix = static_cast<int>(left), iy = static_cast<int>(top);
  const float fx = static_cast<float>(left - ix), fy = static_cast<float>(top - iy);
  const auto row_at = [&](int v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(iy + v) + ix;
    const Float8 here = LoadBytes(row);
    return here + fx * (LoadBytes(row + 1) - here);
  };
  Float8 above = row_at(0);
  for (int v = 0; v < kTemplate; ++v) {
    const Float8 below = row_at(v + 1);
    values[At(v)] = above + fy * (below - above);
    above = below;
  }
  return true;
}

double Correlation(const Template& wanted, const Rows& seen) {
  constexpr float kCount = kTemplate * kTemplate;
  Float8 seen_sum{}, seen2{}, product{};
  for (std::size_t v = 0; v < kTemplate; ++v) {
    seen_sum += seen[v];
    seen2 += seen[v] * seen[v];
    product += seen[v] * wanted.value[v];
  }
  const float sum = Sum(seen_sum);
  const float wanted_variance = wanted.sum2 - wanted.sum * wanted.sum / kCount;
  const float variance = Sum(seen2) - sum * sum / kCount;
  if (variance < kCount) return 0;  // less than one grey level
  return (Sum(product) - wanted.sum * sum / kCount) / std::sqrt(wanted_variance * variance);
}

}  // namespace

std::optional<ReferencePatch> CutPatch(const Pyramid& pyramid, const Vector2d& img, int level) {
  constexpr int kSide = ReferencePatch::kSide;
  const cv::Mat& image = pyramid.levels[At(level)];
  const Vector2d center = pyramid.ToLevel(level, pyramid.Seen(img)) - Vector2d(0.5, 0.5);
  const Vector2d corner = center - Vector2d::Constant((kSide - 1) * 0.5);
  if (!(corner.x() >= 0 && corner.y() >= 0 && corner.x() + kSide < image.cols &&
        corner.y() + kSide < image.rows))
    return std::nullopt;
  ReferencePatch patch;
  patch.level = level;
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      patch.pixels[At(v * kSide + u)] =
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
                                         const Vector2d& expected_img, const PatchAlignmentOptions& options) {
  Eigen::Matrix<double, 2, 3> img_by_point;
  const Vector3d point_in_cam = cam_from_world * point_in_world;
  if (!camera.ImgFromCam(point_in_cam, &img_by_point)) return std::nullopt;
  const Matrix2d img_by_reference = img_by_point * cam_from_world.RotationMatrix() * axes;
  const double area = img_by_reference.determinant();
  constexpr double kMostChange = 1e3;  // of the patch's area: beyond it no level shows it. Guessed
  if (!(area > 1 / kMostChange && area < kMostChange)) return std::nullopt;
  // The level on which a patch pixel is about one pixel.
  const int level = NearestLevel(std::sqrt(area));
  std::array<float, kFramed * kFramed> framed;
  if (!Warp(patch, (img_by_reference / LevelScale(level)).inverse(), framed)) return std::nullopt;
  const auto wanted = MakeTemplate(framed);
  if (!wanted) return std::nullopt;

  const cv::Mat& image = pyramid.levels[At(level)];
  const Vector2d start =
      pyramid.ToLevel(level, pyramid.Seen(expected_img, &point_in_cam)) - Vector2d(0.5, 0.5);
  Vector2d at = start;
  Rows seen;
  bool settled = false;
  for (int iteration = 0; iteration < kAlignmentIterations && !settled; ++iteration) {
    if (!Sample(image, at, seen)) return std::nullopt;
    Float8 right_x{}, right_y{};
    for (std::size_t v = 0; v < kTemplate; ++v) {
      right_x += seen[v] * wanted->by_x[v];
      right_y += seen[v] * wanted->by_y[v];
    }
    const Vector2d shift =
        (wanted->step_by_right * Eigen::Vector2f(Sum(right_x), Sum(right_y))).cast<double>();
    if (!shift.allFinite()) return std::nullopt;
    at -= shift;
    if ((at - start).squaredNorm() > options.max_shift * options.max_shift) return std::nullopt;
    settled = shift.squaredNorm() < kSettledStep * kSettledStep;
  }
  if (!settled || !Sample(image, at, seen)) return std::nullopt;
  const double correlation = Correlation(*wanted, seen);
  if (correlation < options.min_correlation) return std::nullopt;
  const Vector2d seen_at = pyramid.FromLevel(level, at + Vector2d(0.5, 0.5));
  return PatchAlignment{pyramid.Global(seen_at, &point_in_cam), level, correlation};
}

}  // namespace ulf::tracking
