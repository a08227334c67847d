#include "render/splats/surface_map.h"

#include <algorithm>
#include <cmath>

namespace ulf::render {
namespace {

constexpr int kPlaneRadius = 2;       // px: planes are fitted to windows of 5 x 5
constexpr float kSameSurface = 1.5f;  // steps of the map; farther off a pixel shows another surface
constexpr int kFewestOfPlane = 6;     // pixels of a fit

// Returns the smaller change of the two to the sides: beside an edge that of the own surface. Unknown
// neighbours are 0.
float SmallerChange(float before, float here, float behind) {
  if (!(before > 0) && !(behind > 0)) return 0;
  if (!(before > 0)) return behind - here;
  if (!(behind > 0)) return here - before;
  const float back = here - before, on = behind - here;
  return std::abs(back) < std::abs(on) ? back : on;
}

cv::Vec3f PlaneAtPixel(const cv::Mat& inverse_depth, int x, int y, float tolerance) {
  const auto at = [&](int column, int row) {
    return column < 0 || row < 0 || column >= inverse_depth.cols || row >= inverse_depth.rows
               ? 0.0f
               : inverse_depth.at<float>(row, column);
  };
  const float here = at(x, y);
  if (!(here > 0)) return {0, 0, 0};
  const float by_x = SmallerChange(at(x - 1, y), here, at(x + 1, y));
  const float by_y = SmallerChange(at(x, y - 1), here, at(x, y + 1));
  Eigen::Matrix3f products = Eigen::Matrix3f::Zero();
  Eigen::Vector3f right = Eigen::Vector3f::Zero();
  int count = 0;
  for (int dy = -kPlaneRadius; dy <= kPlaneRadius; ++dy)
    for (int dx = -kPlaneRadius; dx <= kPlaneRadius; ++dx) {
      const float value = at(x + dx, y + dy);
      const auto u = static_cast<float>(dx), v = static_cast<float>(dy);
      if (!(value > 0) || std::abs(value - here - by_x * u - by_y * v) > tolerance) continue;
      const Eigen::Vector3f row(1, u, v);
      products += row * row.transpose();
      right += (value - here) * row;
      ++count;
    }
  // A determinant of whole numbers: 0 for pixels on a line.
  if (count < kFewestOfPlane || !(products.determinant() > 0.5f)) return {here, by_x, by_y};
  const Eigen::Vector3f plane = products.inverse() * right;
  return {here + plane[0], plane[1], plane[2]};
}

}  // namespace

SurfaceMap::SurfaceMap(const ViewDepthMap& map)
    : fx_(static_cast<float>(map.camera.fx)),
      fy_(static_cast<float>(map.camera.fy)),
      cx_(static_cast<float>(map.camera.cx)),
      cy_(static_cast<float>(map.camera.cy)),
      step_(static_cast<float>(map.step)),
      planes_(map.inverse_depth.size(), CV_32FC3) {
  cv::Mat inverse_depth;
  map.inverse_depth.convertTo(inverse_depth, CV_32F, map.unit);
  for (int y = 0; y < planes_.rows; ++y)
    for (int x = 0; x < planes_.cols; ++x)
      planes_.at<cv::Vec3f>(y, x) = PlaneAtPixel(inverse_depth, x, y, kSameSurface * step_);
}

std::optional<RayPlane> SurfaceMap::At(float ray_x, float ray_y) const {
  const float x = fx_ * ray_x + cx_, y = fy_ * ray_y + cy_;
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(planes_.cols) && y < static_cast<float>(planes_.rows)))
    return std::nullopt;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const auto& plane = planes_.at<cv::Vec3f>(row, column);
  const float inverse_depth = plane[0] + plane[1] * (x - static_cast<float>(column) - 0.5f) +
                              plane[2] * (y - static_cast<float>(row) - 0.5f);
  if (!(plane[0] > 0) || !(inverse_depth > 0)) return std::nullopt;
  return RayPlane{inverse_depth, plane[1] * fx_, plane[2] * fy_};
}

}  // namespace ulf::render
