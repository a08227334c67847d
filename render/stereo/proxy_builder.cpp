#include "render/stereo/proxy_builder.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "render/stereo/depth_fusion.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/gl_plane_sweep.h"
#include "render/stereo/surface_cut.h"
#include "render/stereo/view_selection.h"

namespace ulf::render {
namespace {

class Stopwatch {
 public:
  double LapSeconds() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::vector<StereoView> StereoViews(const RenderScene& scene, int size_px, Progress* progress) {
  std::vector<StereoView> views(scene.views.size());
  struct {
    Mutex mutex;
    std::size_t done ULF_GUARDED_BY(mutex) = 0;
  } shown;
  cv::parallel_for_(
      cv::Range(0, static_cast<int>(views.size())),
      [&](const cv::Range& range) {
        for (int i = range.start; i < range.end; ++i) {
          views[static_cast<std::size_t>(i)] =
              MakeStereoView(scene.views[static_cast<std::size_t>(i)], size_px);
          const MutexLock lock(shown.mutex);
          if (progress)
            progress->Show(0.1 * static_cast<double>(++shown.done) / static_cast<double>(views.size()),
                           "photographs");
        }
      },
      static_cast<double>(views.size()));
  return views;
}

struct Task {
  int view;
  std::vector<const StereoView*> neighbours;
};

std::vector<Task> TasksOf(const std::vector<StereoView>& views, const Subject& subject,
                          const ProxyOptions& options) {
  std::vector<Task> tasks;
  for (const int view : SpreadViews(views, subject, options.depth_maps)) {
    Task task{view, {}};
    for (const int other : NeighboursOf(view, views, subject, {.count = options.neighbours}))
      task.neighbours.push_back(&views[static_cast<std::size_t>(other)]);
    if (!task.neighbours.empty()) tasks.push_back(std::move(task));
  }
  return tasks;
}

// Null: the processor itself.
std::unique_ptr<GlPlaneSweep> OpenGlFor(SweepDevice device) {
  if (device == SweepDevice::kProcessor) return nullptr;
  try {
    auto sweep = std::make_unique<GlPlaneSweep>();
    return device != SweepDevice::kGl && sweep->IsSoftware() ? nullptr : std::move(sweep);
  } catch (const Error& error) {
    if (device == SweepDevice::kGl) throw Error("{}, or do without: --renderer reference", error.what());
    spdlog::debug("pictures are compared by the processor: {}", error.what());
    return nullptr;
  }
}

double PixelDepthRadii(const std::vector<StereoView>& views, const std::vector<Task>& tasks,
                       const Subject& subject) {
  std::vector<double> radii;
  for (const Task& task : tasks) {
    const StereoView& view = views[static_cast<std::size_t>(task.view)];
    const double distance = (subject.center_in_world - view.center_in_world).norm();
    radii.push_back(DepthStepOfPixel(view, task.neighbours, distance) / subject.radius);
  }
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

std::vector<ViewDepth> DepthMaps(const std::vector<StereoView>& views, const std::vector<Task>& tasks,
                                 const Subject& subject, GlPlaneSweep* gl, Progress* progress) {
  std::vector<ViewDepth> maps(tasks.size());
  Mutex drawing;  // of `gl`
  const auto costs = [&](const Task& task, const StereoView& view, const InverseDepthRange& depths) {
    if (!gl) return MatchingCosts(view, task.neighbours, depths);
    const MutexLock lock(drawing);
    return gl->MatchingCosts(view, task.neighbours, depths);
  };
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } shown;
  cv::parallel_for_(
      cv::Range(0, static_cast<int>(tasks.size())),
      [&](const cv::Range& range) {
        for (int i = range.start; i < range.end; ++i) {
          const Task& task = tasks[static_cast<std::size_t>(i)];
          const StereoView& view = views[static_cast<std::size_t>(task.view)];
          const double distance = (subject.center_in_world - view.center_in_world).norm();
          const InverseDepthRange depths = FindRange(view, task.neighbours, distance);
          maps[static_cast<std::size_t>(i)] = {
              view, DepthOfLeastCost(costs(task, view, depths), view, depths).depth,
              (depths.most - depths.least) / (depths.planes - 1)};
          const MutexLock lock(shown.mutex);
          if (progress)
            progress->Show(0.1 + 0.8 * ++shown.done / static_cast<double>(tasks.size()), "depth maps");
        }
      },
      static_cast<double>(tasks.size()));
  return maps;
}

// As many points as the surface may have triangles for.
std::vector<FusedPoint> Points(const std::vector<ViewDepth>& maps,
                               const std::vector<std::vector<int>>& others, FusionOptions options,
                               int most_triangles) {
  std::vector<FusedPoint> points = FusePoints(maps, others, options);
  while (points.size() > static_cast<std::size_t>(most_triangles) / 2 && options.spacing_px < 64) {
    ++options.spacing_px;
    points = FusePoints(maps, others, options);
  }
  return points;
}

}  // namespace

ProxyMesh BuildProxy(const RenderScene& scene, const ProxyOptions& options, Progress* progress) {
  if (scene.views.size() < 2)
    throw Error("a mesh needs at least two views of the same thing; there is {}: capture or import more",
                Counted(scene.views.size(), "view"));
  ProxyMesh result;
  result.summary.views = static_cast<int>(scene.views.size());
  Stopwatch watch;
  const std::vector<StereoView> views = StereoViews(scene, options.size_px, progress);
  const std::vector<Task> tasks = TasksOf(views, scene.subject, options);
  if (tasks.empty())
    throw Error(
        "no two of the {} views look at the same thing from different places, so that nothing tells how far "
        "away it is: move the camera sideways between views",
        scene.views.size());
  result.summary.pixel_depth_radii = PixelDepthRadii(views, tasks, scene.subject);
  const std::unique_ptr<GlPlaneSweep> gl = OpenGlFor(options.device);
  result.summary.device = gl ? gl->device() : "processor";
  std::vector<ViewDepth> maps = DepthMaps(views, tasks, scene.subject, gl.get(), progress);
  result.summary.depth_maps = static_cast<int>(maps.size());
  result.summary.sweep_s = watch.LapSeconds();

  std::vector<StereoView> mapped;
  std::vector<Eigen::Vector3d> centers;
  for (const ViewDepth& map : maps) {
    mapped.push_back(map.view);
    centers.push_back(map.view.center_in_world);
  }
  std::vector<std::vector<int>> others;
  for (std::size_t i = 0; i < mapped.size(); ++i)
    others.push_back(NeighboursOf(static_cast<int>(i), mapped, scene.subject, {.count = 10}));
  FusionOptions fusion;
  fusion.agreeing_views = std::min(fusion.agreeing_views, std::max(1, static_cast<int>(maps.size()) - 1));
  KeepWhatAgrees(maps, others, fusion);
  double agreeing = 0, pixels = 0;
  for (const ViewDepth& map : maps) {
    agreeing += cv::countNonZero(map.depth);
    pixels += static_cast<double>(map.depth.total());
  }
  result.summary.agreeing_share = agreeing / pixels;
  const std::vector<FusedPoint> points = Points(maps, others, fusion, options.most_triangles);
  result.summary.points = points.size();
  result.summary.fusion_s = watch.LapSeconds();

  if (progress) progress->Show(0.92, "surface");
  result.mesh = CutSurface(points, centers).mesh;
  result.summary.surface_s = watch.LapSeconds();
  if (result.mesh.triangles.empty())
    throw Error(
        "the views agree on no surface ({} in {}): are the poses right, did the subject stay where it was, "
        "do "
        "neighbouring views see the same things?",
        Counted(points.size(), "point"), Counted(maps.size(), "depth map"));
  return result;
}

}  // namespace ulf::render
