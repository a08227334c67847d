#include "render/quality/nearest_view.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/geometry/pinhole.h"
#include "render/quality/evaluate.h"
#include "render/renderer/renderer.h"

namespace ulf::render {
namespace {

// Maps each display value of a view to that at the common exposure.
cv::Mat ExposureTable(const SceneView& view) {
  cv::Mat table(1, 256, CV_8UC1);
  for (int i = 0; i < 256; ++i) {
    const float light = (LinearFromSrgb(static_cast<float>(i) / 255) - view.black) * view.scale;
    table.at<unsigned char>(i) =
        cv::saturate_cast<unsigned char>(255 * SrgbFromLinear(std::clamp(light, 0.0f, 1.0f)));
  }
  return table;
}

}  // namespace

NearestViewRenderer::NearestViewRenderer(const RenderScene& scene, Progress* progress)
    : subject_(scene.subject) {
  if (scene.views.empty()) throw Error("there are no views to show");
  for (const SceneView& view : scene.views) {
    Flat flat{view.camera.WithoutDistortion(), view.cam_from_world,
              (view.center_in_world - subject_.center_in_world).normalized(), Undistort(view).srgb8};
    if (view.black != 0 || view.scale != 1) cv::LUT(flat.srgb8, ExposureTable(view), flat.srgb8);
    views_.push_back(std::move(flat));
    if (progress)
      progress->Show(static_cast<double>(views_.size()) / static_cast<double>(scene.views.size()),
                     "photographs");
  }
}

int NearestViewRenderer::Nearest(const Rigid3& cam_from_world) const {
  const Eigen::Vector3d direction = cam_from_world.OriginInSource() - subject_.center_in_world;
  const auto closer = [&](const Flat& a, const Flat& b) {
    return a.direction.dot(direction) < b.direction.dot(direction);
  };
  return static_cast<int>(std::ranges::max_element(views_, closer) - views_.begin());
}

int NearestViewRenderer::Draw(const CameraModel& camera, const Rigid3& cam_from_world, cv::Mat& srgb8) const {
  RequireUndistorted(camera);
  const int nearest = Nearest(cam_from_world);
  const Flat& view = views_[static_cast<std::size_t>(nearest)];
  const PlaneInCamera plane = PlaneThroughSubject(subject_, cam_from_world);
  const Rigid3 view_from_cam = view.cam_from_world * cam_from_world.Inverse();
  // On the plane n.x = d: x' = R x + t = (R + t n^T / d) x.
  Eigen::Matrix3d homography =
      PinholeMatrix(view.camera) *
      (view_from_cam.RotationMatrix() + view_from_cam.translation * plane.normal.transpose() / plane.offset) *
      PinholeMatrix(camera).inverse();
  // OpenCV counts pixel centres as integers.
  Eigen::Matrix3d up = Eigen::Matrix3d::Identity(), down = Eigen::Matrix3d::Identity();
  up(0, 2) = up(1, 2) = 0.5;
  down(0, 2) = down(1, 2) = -0.5;
  homography = down * homography * up;
  const cv::Matx33d map(homography(0, 0), homography(0, 1), homography(0, 2), homography(1, 0),
                        homography(1, 1), homography(1, 2), homography(2, 0), homography(2, 1),
                        homography(2, 2));
  cv::warpPerspective(view.srgb8, srgb8, map, {camera.width, camera.height},
                      cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
  return nearest;
}

}  // namespace ulf::render
