#include "render/splats/splat_views.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/base/mutex.h"
#include "core/base/parallel_for.h"
#include "render/proxy/depth_raster.h"
#include "render/scene/even_picture.h"

namespace ulf::render {
namespace {

constexpr int kOwnMapPx = 640;         // longer side of the maps of a scene without its own. Guessed.
constexpr double kOwnMapStep = 0.005;  // their uncertainty, as a share. Guessed.

// Orders the views so that each stands and looks as far as possible from those before it, and returns the
// first `most`. Distances are the subject's, with an angle of a radian for one.
std::vector<std::size_t> SpreadOrder(const RenderScene& scene, std::size_t most) {
  struct ViewPlace {
    Eigen::Vector3d center, axis;
  };
  std::vector<ViewPlace> places;
  for (const SceneView& view : scene.views) {
    const double distance =
        std::max(scene.subject.radius, (view.center_in_world - scene.subject.center_in_world).norm());
    places.push_back(
        {view.center_in_world / distance, view.cam_from_world.DirectionInSource(Eigen::Vector3d::UnitZ())});
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const ViewPlace& place : places) middle += place.center / static_cast<double>(places.size());
  std::vector<double> gaps;
  for (const ViewPlace& place : places) gaps.push_back(1e9 - (place.center - middle).norm());
  std::vector<std::size_t> order;
  while (order.size() < std::min(most, places.size())) {
    const auto next = static_cast<std::size_t>(std::ranges::max_element(gaps) - gaps.begin());
    order.push_back(next);
    for (std::size_t i = 0; i < places.size(); ++i)
      gaps[i] = std::min(gaps[i], (places[i].center - places[next].center).norm() +
                                      (places[i].axis - places[next].axis).norm());
    gaps[next] = -1;
  }
  return order;
}

SurfaceMap MeshSurfaceOf(const SceneView& view, const Proxy& proxy) {
  const CameraModel camera = Within(view.camera, kOwnMapPx).WithoutDistortion();
  const cv::Mat inverse_depth = DrawInverseDepth(*proxy.Occluder(), camera, view.cam_from_world);
  double most = 0;
  cv::minMaxLoc(inverse_depth, nullptr, &most);
  return SurfaceMap(MakeViewDepthMap(camera, inverse_depth, most > 0 ? kOwnMapStep * most : 1));
}

// Returns the longer side that all pictures may have so that they have no more than `most_px` together.
int SizeWithin(const std::vector<Undistortion>& undistortions, double most_px) {
  int longest = 1;
  for (const Undistortion& one : undistortions) longest = std::max({longest, one.to.width, one.to.height});
  const auto pixels = [&](int size_px) {
    double sum = 0;
    for (const Undistortion& one : undistortions) {
      const CameraModel camera = Within(one.to, size_px);
      sum += 1.0 * camera.width * camera.height;
    }
    return sum;
  };
  int least = 1;
  while (least < longest) {
    const int middle = (least + longest + 1) / 2;
    if (pixels(middle) <= most_px)
      least = middle;
    else
      longest = middle - 1;
  }
  return least;
}

// Fills the means of cells and how far the photograph is from them.
void MeasureCells(SplatView& view) {
  cv::Mat bgr = view.photograph;
  if (bgr.channels() == 4) cv::cvtColor(view.photograph, bgr, cv::COLOR_BGRA2BGR);
  constexpr int kLargest = 1 << (kCellSizes - 1);
  const auto padded = [](int size) { return (size + kLargest - 1) / kLargest * kLargest; };
  cv::Mat even;
  cv::copyMakeBorder(bgr, even, 0, padded(bgr.rows) - bgr.rows, 0, padded(bgr.cols) - bgr.cols,
                     cv::BORDER_REPLICATE);
  view.means[0] = even;
  for (int size = 1; size < kCellSizes; ++size) {
    const cv::Size cells(even.cols >> size, even.rows >> size);
    cv::Mat mean, smooth, difference, most;
    cv::resize(even, mean, cells, 0, 0, cv::INTER_AREA);
    cv::resize(mean, smooth, even.size(), 0, 0, cv::INTER_LINEAR);
    cv::absdiff(even, smooth, difference);
    std::array<cv::Mat, 3> channels;
    cv::split(difference, channels.data());
    most = cv::max(cv::max(channels[0], channels[1]), channels[2]);
    cv::Mat& roughness = view.roughness[At(size)];
    roughness = cv::Mat::zeros(cells, CV_8U);
    for (int y = 0; y < most.rows; ++y)
      for (int x = 0; x < most.cols; ++x) {
        auto& of_cell = roughness.at<std::uint8_t>(y >> size, x >> size);
        of_cell = std::max(of_cell, most.at<std::uint8_t>(y, x));
      }
    view.means[At(size)] = mean;
  }
}

}  // namespace

int LongestSide(const std::vector<SplatView>& views) {
  int longest = 0;
  for (const SplatView& view : views) longest = std::max({longest, view.camera.width, view.camera.height});
  return longest;
}

std::vector<SplatView> MakeSplatViews(const RenderScene& scene, int most, double most_px,
                                      const std::function<void(double share)>& progress) {
  const std::vector<std::size_t> order = SpreadOrder(scene, At(most));
  std::vector<Undistortion> undistortions;
  for (const std::size_t v : order) undistortions.push_back(UndistortionOf(scene.views[v]));
  const int size_px = SizeWithin(undistortions, most_px);
  std::vector<SplatView> views(order.size());
  Mutex mutex;
  std::size_t done = 0;
  ParallelFor(order.size(), [&](std::size_t i) {
    const SceneView& view = scene.views[order[i]];
    SplatView& made = views[i];
    made.camera = Within(undistortions[i].to, size_px);
    made.cam_from_world = view.cam_from_world;
    made.photograph = EvenPicture(view, undistortions[i], made.camera);
    made.mesh_surface = MeshSurfaceOf(view, *scene.proxy);
    made.surface = view.depth_map ? SurfaceMap(view.depth_map->Get()) : made.mesh_surface;
    made.done = cv::Mat::zeros(made.photograph.size(), CV_8U);
    MeasureCells(made);
    const MutexLock lock(mutex);
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(order.size()));
  });
  return views;
}

std::vector<SplatView> Reduced(const std::vector<SplatView>& views, int size_px) {
  std::vector<SplatView> reduced(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    const SplatView& view = views[i];
    SplatView& made = reduced[i];
    made.camera = Within(view.camera, size_px);
    made.cam_from_world = view.cam_from_world;
    made.reduced = static_cast<float>(view.camera.width) / static_cast<float>(made.camera.width);
    cv::resize(view.photograph, made.photograph, {made.camera.width, made.camera.height}, 0, 0,
               cv::INTER_AREA);
    made.surface = view.surface;
    made.mesh_surface = view.mesh_surface;
    made.done = cv::Mat::zeros(made.photograph.size(), CV_8U);
    MeasureCells(made);
  });
  return reduced;
}

}  // namespace ulf::render
