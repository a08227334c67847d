#include "render/proxy/view_depth_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/proxy/depth_raster.h"

namespace ulf::render {

ViewDepthMap MakeViewDepthMap(const CameraModel& camera, const cv::Mat& inverse_depth, double step) {
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  double most = 0;
  cv::minMaxLoc(inverse_depth, nullptr, &most);
  ViewDepthMap map{camera, cv::Mat::zeros(inverse_depth.size(), CV_16UC1), most > 0 ? most / kMost : 1, step};
  for (int y = 0; y < inverse_depth.rows; ++y)
    for (int x = 0; x < inverse_depth.cols; ++x) {
      const double value = inverse_depth.at<float>(y, x);
      if (value > 0)  // a known depth must not become 0
        map.inverse_depth.at<std::uint16_t>(y, x) =
            static_cast<std::uint16_t>(std::clamp(std::round(value / map.unit), 1.0, kMost));
    }
  return map;
}

ViewDepthMap DepthMapOfMesh(const TriangleMesh& mesh, const CameraModel& camera, const Rigid3& cam_from_world,
                            double step) {
  cv::Mat inverse_depth = DrawInverseDepth(mesh, camera, cam_from_world);
  if (cv::countNonZero(inverse_depth) > 0) FillHoles(inverse_depth);
  return MakeViewDepthMap(camera, inverse_depth, step);
}

double MovedPx(const CameraModel& camera, const Rigid3& then, const Rigid3& now, double distance) {
  const double turned = now.rotation.angularDistance(then.rotation);
  const double shifted = (now.OriginInSource() - then.OriginInSource()).norm();
  return camera.MeanFocalPx() * std::max(turned, shifted / distance);
}

}  // namespace ulf::render
