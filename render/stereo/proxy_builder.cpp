#include "render/stereo/proxy_builder.h"

#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/gl_plane_sweep.h"
#include "render/stereo/view_selection.h"

namespace ulf::render {
namespace {

// Shares of the displayed progress.
constexpr double kPhotographsShare = 0.1, kMapsShare = 0.8, kBeforeSurface = 0.92;

// Reports the progress of a loop in several threads: `share` of the whole, from `from` on.
class LoopProgress {
 public:
  LoopProgress(Progress* progress, const char* what, double from, double share, std::size_t count)
      : progress_(progress), what_(what), from_(from), step_(share / static_cast<double>(count)) {}
  void AddOne() {
    const MutexLock lock(mutex_);
    if (progress_) progress_->Show(from_ + step_ * ++done_, what_);
  }

 private:
  Progress* progress_;
  const char* what_;
  double from_, step_;
  Mutex mutex_;
  int done_ ULF_GUARDED_BY(mutex_) = 0;
};

std::vector<StereoView> StereoViews(const RenderScene& scene, int size_px, Progress* progress) {
  std::vector<StereoView> views(scene.views.size());
  LoopProgress shown(progress, "photographs", 0, kPhotographsShare, views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    views[i] = MakeStereoView(scene.views[i], size_px);
    shown.AddOne();
  });
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
    for (const int other : NeighboursOf(view, views, subject, options.neighbours))
      task.neighbours.push_back(&views[At(other)]);
    if (!task.neighbours.empty()) tasks.push_back(std::move(task));
  }
  return tasks;
}

// Returns null if the processor compares the photographs.
std::unique_ptr<GlPlaneSweep> MakeSweepOn(SweepDevice device) {
  if (device == SweepDevice::kProcessor) return nullptr;
  try {
    return std::make_unique<GlPlaneSweep>();
  } catch (const Error& error) {
    throw Error("{}, or use {} reference", error.what(), Parameter("renderer"));
  }
}

double PixelDepthRadii(const std::vector<StereoView>& views, const std::vector<Task>& tasks,
                       const Subject& subject) {
  std::vector<double> radii;
  for (const Task& task : tasks) {
    const StereoView& view = views[At(task.view)];
    radii.push_back(DepthStepOfPixel(view, task.neighbours, DistanceFrom(subject, view)) / subject.radius);
  }
  return Median(radii);
}

std::vector<ViewDepth> DepthMaps(const std::vector<StereoView>& views, const std::vector<Task>& tasks,
                                 const Subject& subject, GlPlaneSweep* gl, Progress* progress) {
  std::vector<ViewDepth> maps(tasks.size());
  LoopProgress shown(progress, "depth maps", kPhotographsShare, kMapsShare, tasks.size());
  const auto range_of = [&](const Task& task) {
    const StereoView& view = views[At(task.view)];
    return FindRange(view, task.neighbours, DistanceFrom(subject, view));
  };
  const auto keep = [&](std::size_t i, const InverseDepthRange& depths, cv::Mat depth) {
    maps[i] = {views[At(tasks[i].view)], std::move(depth),
               (depths.most - depths.least) / (depths.planes - 1)};
    shown.AddOne();
  };
  if (!gl) {
    ParallelFor(tasks.size(), [&](std::size_t i) {
      const InverseDepthRange depths = range_of(tasks[i]);
      keep(i, depths, SweepPlanes(views[At(tasks[i].view)], tasks[i].neighbours, depths).depth);
    });
    return maps;
  }
  // OpenGL runs in this thread alone: NVIDIA's driver frees twice its data of a pool's thread that ends after
  // main().
  std::vector<InverseDepthRange> ranges(tasks.size());
  ParallelFor(tasks.size(), [&](std::size_t i) { ranges[i] = range_of(tasks[i]); });
  constexpr int kMostVolumes = 8;  // in memory at a time
  const std::size_t at_once = At(std::clamp(cv::getNumThreads(), 1, kMostVolumes));
  for (std::size_t first = 0; first < tasks.size(); first += at_once) {
    std::vector<CostVolume> costs;
    for (std::size_t i = first; i < std::min(first + at_once, tasks.size()); ++i)
      costs.push_back(gl->MatchingCosts(views[At(tasks[i].view)], tasks[i].neighbours, ranges[i]));
    ParallelFor(costs.size(), [&](std::size_t n) {
      const std::size_t i = first + n;
      keep(i, ranges[i], DepthOfLeastCost(costs[n], views[At(tasks[i].view)], ranges[i]).depth);
    });
  }
  return maps;
}

// The common beginning of both steps; the tasks point into the views.
struct Beginning {
  std::vector<StereoView> views;
  std::vector<Task> tasks;
};

Beginning Begin(const RenderScene& scene, const ProxyOptions& options, Progress* progress) {
  if (scene.views.size() < 2)
    throw Error("a mesh needs at least two views of the same thing; there is {}: capture or import more",
                Counted(scene.views.size(), "view"));
  Beginning begun{StereoViews(scene, options.size_px, progress), {}};
  begun.tasks = TasksOf(begun.views, scene.subject, options);
  if (begun.tasks.empty()) {
    const Eigen::Vector3d& first = begun.views.front().center_in_world;
    double apart = 0;
    for (const StereoView& view : begun.views) apart = std::max(apart, (view.center_in_world - first).norm());
    throw Error(
        "no two of the {} views look at the subject from different places, so that no distance can be found: "
        "they stand at most {:.3g} from the first view, which is {:.3g} away from the subject. Where the "
        "subject is elsewhere, give its place ({} x,y,z,radius); else move the camera sideways between "
        "views",
        scene.views.size(), apart, (scene.subject.center_in_world - first).norm(), Parameter("subject"));
  }
  return begun;
}

std::vector<ViewDepth> MapsOfTasks(const SweptMapFiles& swept, const RenderScene& scene,
                                   const Beginning& begun) {
  std::vector<ViewDepth> maps;
  for (const Task& task : begun.tasks) {
    const StereoView& view = begun.views[At(task.view)];
    SweptMap map = swept.Read(scene.views[At(task.view)].id, view.grey.size());
    maps.push_back({view, std::move(map.depth), map.plane_step});
  }
  return maps;
}

// Sweeps, or uses the maps that were swept before.
ProxyMesh Build(const RenderScene& scene, const ProxyOptions& options, const SweptMapFiles* swept,
                Progress* progress) {
  ProxyMesh result;
  result.summary.views = static_cast<int>(scene.views.size());
  Stopwatch watch;
  const Beginning begun = Begin(scene, options, progress);
  result.summary.pixel_depth_radii = PixelDepthRadii(begun.views, begun.tasks, scene.subject);
  std::vector<ViewDepth> maps;
  if (swept) {
    maps = MapsOfTasks(*swept, scene, begun);
    result.summary.device = "earlier";
  } else {
    const std::unique_ptr<GlPlaneSweep> gl = MakeSweepOn(options.device);
    result.summary.device = gl ? gl->device() : "processor";
    maps = DepthMaps(begun.views, begun.tasks, scene.subject, gl.get(), progress);
  }
  result.summary.depth_maps = static_cast<int>(maps.size());
  result.summary.sweep_s = watch.LapSeconds();

  if (progress) progress->Show(kBeforeSurface, "surface");
  std::vector<ViewDepth> kept;
  if (options.keep_maps) kept = maps;
  MapsMesh surface = MeshOfMaps(std::move(maps), scene.subject, options.mesh);
  result.mesh = std::move(surface.mesh);
  result.summary.agreeing_share = surface.agreeing_share;
  result.summary.points = surface.points;
  result.summary.fusion_s = surface.fusion_s;
  result.summary.surface_s = surface.surface_s;
  if (result.mesh.triangles.empty())
    throw Error(
        "the views agree on no surface ({} in {}): are the poses right, did the subject stay in place, do "
        "neighbouring views see the same things?",
        Counted(surface.points, "point"), Counted(result.summary.depth_maps, "depth map"));
  if (options.keep_maps) {
    std::vector<int> view_ids;
    for (const Task& task : begun.tasks) view_ids.push_back(scene.views[At(task.view)].id);
    result.maps = MapsForRendering(std::move(kept), view_ids, result.mesh, scene.subject, options.mesh);
  }
  return result;
}

}  // namespace

ProxyMesh BuildProxy(const RenderScene& scene, const ProxyOptions& options, Progress* progress) {
  return Build(scene, options, nullptr, progress);
}

ProxyMesh BuildProxyOf(const SweptMapFiles& maps, const RenderScene& scene, const ProxyOptions& options,
                       Progress* progress) {
  return Build(scene, options, &maps, progress);
}

SweptMaps SweepShare(const RenderScene& scene, const ProxyOptions& options, const MapShare& share,
                     Progress* progress) {
  const Beginning begun = Begin(scene, options, progress);
  std::vector<Task> tasks;
  for (std::size_t i = At(share.index); i < begun.tasks.size(); i += At(share.of))
    tasks.push_back(begun.tasks[i]);
  SweptMaps swept;
  if (tasks.empty()) return swept;
  const std::unique_ptr<GlPlaneSweep> gl = MakeSweepOn(options.device);
  const std::vector<ViewDepth> maps = DepthMaps(begun.views, tasks, scene.subject, gl.get(), progress);
  for (std::size_t i = 0; i < maps.size(); ++i)
    swept[scene.views[At(tasks[i].view)].id] = {maps[i].depth, maps[i].plane_step};
  return swept;
}

std::uint64_t SweepDigest(const RenderScene& scene, const ProxyOptions& options) {
  std::vector<std::uint64_t> photographs(scene.views.size());
  ParallelFor(photographs.size(),
              [&](std::size_t i) { photographs[i] = scene.views[i].photograph->ContentDigest(); });
  Digest digest;
  digest.Add(std::as_bytes(std::span(photographs)));
  for (const SceneView& view : scene.views) {
    digest.Add(static_cast<double>(view.id));
    digest.Add(view.cam_from_world);
    digest.Add(view.camera);
  }
  for (int axis = 0; axis < 3; ++axis) digest.Add(scene.subject.center_in_world[axis]);
  digest.Add(scene.subject.radius);
  for (const int option :
       {options.size_px, options.depth_maps, options.neighbours, options.device == SweepDevice::kGl ? 1 : 0})
    digest.Add(static_cast<double>(option));
  return digest.Value();
}

std::shared_ptr<const RenderScene> LoadForGeometry(const LightField& light_field, const SceneOptions& options,
                                                   int size_px) {
  const bool masked =
      std::ranges::any_of(light_field.views, [&](const View& view) { return HasMask(light_field, view); });
  SceneOptions small = options;
  small.size_limit_px = size_px;
  small.form = masked ? PhotographForm::kLinear : PhotographForm::kEightBits;
  return LoadScene(light_field, small);
}

void RequireViewsForMesh(const LightField& light_field, const std::filesystem::path& dir,
                         std::size_t left_out) {
  const std::size_t views = light_field.views.size();
  if (views < 2 + left_out)
    throw Error("{}: a mesh needs at least two views; there {} {}, {} left out; capture or import more",
                dir.string(), views == 1 ? "is" : "are", views, left_out);
}

void WriteMeshProxy(const std::filesystem::path& dir) {
  const LightField light_field = ReadLightField(dir);
  RequireViewsForMesh(light_field, dir, 0);
  ProxyOptions options;
  const auto scene = LoadForGeometry(light_field, {}, options.size_px);
  Progress progress("proxy");
  options.keep_maps = true;
  const ProxyMesh proxy = BuildProxy(*scene, options, &progress);
  WriteGeometryFiles(light_field, MeshPlyBytes(proxy.mesh, OriginComments("ulf proxy", light_field)),
                     proxy.maps, FormerGeometry::kKept);
}

}  // namespace ulf::render
