#include "render/stereo/growing_geometry.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/base/at.h"
#include "core/base/host_time.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "render/stereo/view_selection.h"

namespace ulf::render {

constexpr int kNeighbours = 6;           // of a view in the sweep. Guessed.
constexpr int kNeighboursWaitedFor = 4;  // Guessed.
// Neighbours surround a view if the mean of the directions to them is shorter than this; 1: all on one side.
// Guessed.
constexpr double kMostOneSided = 0.7;
// A map is made anew if corrected poses move its points by more, in px of its image. Guessed.
constexpr double kStalePx = 1.0;

// Constants of RangeOfKnown():
constexpr int kGridX = 8, kGridY = 6;         // parts of the image
constexpr double kLeastParts = 0.7;           // share of the parts that known depths must reach. Guessed.
constexpr int kStepPx = 5;                    // step between the read depths of the known maps
constexpr double kKnownRangeLeftOut = 0.005;  // as DepthRangeOptions
constexpr double kKnownRangeMargin = 0.15, kMarginOfMost = 0.02;

using Eigen::Vector3d;

constexpr std::size_t kMapsAskedForRange = 4;  // nearest ones. Guessed.
// For MakeMissingMaps(); independent of the number of processors, because a map's range is that of earlier
// ones.
constexpr std::size_t kMapsAtOnce = 8;

std::optional<InverseDepthRange> RangeOfKnown(const StereoView& view,
                                              const std::vector<const StereoView*>& neighbours,
                                              const std::vector<const ViewDepth*>& known) {
  std::vector<double> inverse;
  std::vector<bool> reached(At(kGridX * kGridY), false);
  for (const ViewDepth* map : known)
    for (int y = kStepPx / 2; y < map->depth.rows; y += kStepPx)
      for (int x = kStepPx / 2; x < map->depth.cols; x += kStepPx) {
        const double depth = map->depth.at<float>(y, x);
        if (!(depth > 0)) continue;
        const Vector3d point = map->view.center_in_world + depth * map->view.RayInWorld(x, y);
        const Vector3d in_cam = view.cam_from_world * point;
        const auto img = view.Project(point);
        if (!img || !(in_cam.z() > 0)) continue;
        inverse.push_back(1 / in_cam.z());
        const int part_x = std::min(kGridX - 1, static_cast<int>(img->x() * kGridX / view.camera.width));
        const int part_y = std::min(kGridY - 1, static_cast<int>(img->y() * kGridY / view.camera.height));
        reached[At(part_y * kGridX + part_x)] = true;
      }
  const auto parts = static_cast<double>(std::ranges::count(reached, true));
  if (parts < kLeastParts * static_cast<double>(reached.size())) return std::nullopt;
  const double least = Quantile(inverse, kKnownRangeLeftOut),
               most = Quantile(inverse, 1 - kKnownRangeLeftOut);
  const double margin = kKnownRangeMargin * (most - least) + kMarginOfMost * most;
  const double farthest = least - margin;
  return PixelSpacedRange(view, neighbours, 1 / (most + margin),
                          1 / std::max(farthest, kMarginOfMost * most));
}

GrowingGeometry::GrowingGeometry(const GrowingGeometryOptions& options) : options_(options) {}

const GrowingGeometry::Entry* GrowingGeometry::Find(int id) const {
  const auto found = std::ranges::lower_bound(entries_, id, {}, &Entry::id);
  return found != entries_.end() && found->id == id ? &*found : nullptr;
}

void GrowingGeometry::AddView(int id, StereoView view) {
  RemoveView(id);
  Entry entry;
  entry.id = id;
  entry.view = std::move(view);
  entry.came = ++came_;
  entries_.insert(std::ranges::lower_bound(entries_, id, {}, &Entry::id), std::move(entry));
}

void GrowingGeometry::RemoveView(int id) {
  const auto found = std::ranges::find(entries_, id, &Entry::id);
  if (found == entries_.end()) return;
  revision_ += found->map.has_value();
  entries_.erase(found);
}

void GrowingGeometry::MoveViews(const std::map<int, Rigid3>& cam_from_world) {
  for (Entry& entry : entries_)
    if (const auto now = cam_from_world.find(entry.id); now != cam_from_world.end()) {
      entry.view.cam_from_world = now->second;
      entry.view.center_in_world = now->second.OriginInSource();
    }
  for (Entry& entry : entries_)
    if (entry.map) MoveMap(entry);
  ++revision_;
}

// Without its baselines the map follows its view, and is never scaled nor made anew.
bool GrowingGeometry::TakeMap(int id, const CameraModel& camera, const cv::Mat& depth, double plane_step) {
  const auto entry = std::ranges::find(entries_, id, &Entry::id);
  if (entry == entries_.end() || !(entry->view.camera == camera) ||
      depth.size() != cv::Size(camera.width, camera.height))
    return false;
  entry->map = ViewDepth{entry->view, depth, plane_step};
  entry->baselines.clear();
  ++revision_;
  return true;
}

void GrowingGeometry::MoveMap(Entry& entry) const {
  std::vector<double> scales;
  for (const Baseline& then : entry.baselines)
    if (const Entry* neighbour = Find(then.id)) {
      const double before = then.neighbour_from_view.OriginInSource().norm();
      const double now = (neighbour->view.center_in_world - entry.view.center_in_world).norm();
      if (before > 0) scales.push_back(now / before);
    }
  entry.map->view.cam_from_world = entry.view.cam_from_world;
  entry.map->view.center_in_world = entry.view.center_in_world;
  if (scales.empty() || !subject_) return;
  const double scale = Median(scales);
  const double distance = (entry.view.cam_from_world * subject_->center_in_world).norm();
  std::vector<double> moved_px;
  for (const Baseline& then : entry.baselines)
    if (const Entry* neighbour = Find(then.id)) {
      // The map's point at the middle of its image, in the neighbour's frame.
      const Rigid3 now = neighbour->view.cam_from_world * entry.view.cam_from_world.Inverse();
      const Vector3d was_there = then.neighbour_from_view * Vector3d(0, 0, distance / scale);
      const Vector3d is_there = now * Vector3d(0, 0, distance);
      moved_px.push_back(neighbour->view.camera.MeanFocalPx() * AngleBetween(was_there, is_there));
    }
  if (Median(moved_px) > kStalePx) {
    entry.map.reset();
    entry.baselines.clear();
    return;
  }
  constexpr double kSameScale = 1e-4;
  if (std::abs(scale - 1) < kSameScale) return;
  cv::Mat scaled;  // not in place: others may hold the old map
  entry.map->depth.convertTo(scaled, CV_32F, scale);
  entry.map->depth = scaled;
  entry.map->plane_step /= scale;
  for (Baseline& then : entry.baselines) then.neighbour_from_view.translation *= scale;
}

std::vector<StereoView> GrowingGeometry::Views() const {
  std::vector<StereoView> views;
  views.reserve(entries_.size());
  for (const Entry& entry : entries_) views.push_back(entry.view);
  return views;
}

int GrowingGeometry::maps() const {
  return static_cast<int>(
      std::ranges::count_if(entries_, [](const Entry& entry) { return entry.map.has_value(); }));
}

std::vector<ViewDepth> GrowingGeometry::Maps() const {
  std::vector<ViewDepth> maps;
  for (const Entry& entry : entries_)
    if (entry.map) maps.push_back(*entry.map);
  return maps;
}

std::map<int, ViewDepthMap> GrowingGeometry::MapsForRendering(const TriangleMesh& mesh) const {
  if (!subject_) return {};
  std::vector<int> view_ids;
  for (const Entry& entry : entries_)
    if (entry.map) view_ids.push_back(entry.id);
  return render::MapsForRendering(Maps(), view_ids, mesh, *subject_, options_.mesh);
}

std::map<int, Rigid3> GrowingGeometry::MapPoses() const {
  std::map<int, Rigid3> poses;
  for (const Entry& entry : entries_)
    if (entry.map) poses[entry.id] = entry.view.cam_from_world;
  return poses;
}

bool GrowingGeometry::HaveMovedSince(const std::map<int, Rigid3>& then, double most_px) const {
  return std::ranges::any_of(then, [&](const auto& id_and_pose) {
    const auto& [id, pose] = id_and_pose;
    const Entry* entry = Find(id);
    if (!entry || !entry->map) return true;
    const StereoView& view = entry->view;
    const double distance = subject_ ? (subject_->center_in_world - view.center_in_world).norm() : 1;
    return MovedPx(view.camera, pose, view.cam_from_world, distance) > most_px;
  });
}

double GrowingGeometry::FarFromMaps(const Entry& entry) const {
  const Vector3d direction = entry.view.center_in_world - subject_->center_in_world;
  const Vector3d axis = entry.view.cam_from_world.DirectionInSource(Vector3d::UnitZ());
  double nearest = std::numeric_limits<double>::infinity();
  for (const Entry& other : entries_) {
    if (!other.map) continue;
    // A view from the same place that looks elsewhere shows something else.
    const double turned = AngleBetween(axis, other.view.cam_from_world.DirectionInSource(Vector3d::UnitZ()));
    const double apart = AngleBetween(direction, other.view.center_in_world - subject_->center_in_world);
    nearest = std::min(nearest, std::max(apart, turned));
  }
  return nearest;
}

double GrowingGeometry::LeastApartNow() const {
  const double made = static_cast<double>(maps()) / options_.depth_maps;
  return options_.least_apart * (made >= 1 ? 3 : 1 + std::max(0.0, 2 * made - 1));
}

bool GrowingGeometry::StandsAmongNeighbours(const Entry& entry, const std::vector<StereoView>& views) const {
  if (came_ - entry.came >= static_cast<std::uint64_t>(options_.views_waited_for)) return true;
  const int index = static_cast<int>(&entry - entries_.data());
  const std::vector<int> neighbours = NeighboursOf(index, views, *subject_, kNeighbours);
  if (static_cast<int>(neighbours.size()) < kNeighboursWaitedFor) return false;
  Vector3d mean = Vector3d::Zero();
  for (const int neighbour : neighbours)
    mean += (views[At(neighbour)].center_in_world - entry.view.center_in_world).normalized() /
            static_cast<double>(neighbours.size());
  return mean.norm() < kMostOneSided;
}

int GrowingGeometry::Next(bool all_views_are_here) const {
  if (!subject_ || entries_.size() < 2) return -1;
  const double least_apart = LeastApartNow();
  std::vector<std::pair<double, int>> candidates;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.map || entry.tried == came_) continue;
    const double far = FarFromMaps(entry);
    if (far > least_apart) candidates.emplace_back(-far, static_cast<int>(i));
  }
  std::ranges::sort(candidates);  // the farthest first; on ties the smallest id
  const std::vector<StereoView> views = Views();
  for (const auto& [far, index] : candidates)
    if (all_views_are_here || StandsAmongNeighbours(entries_[At(index)], views)) return index;
  return -1;
}

std::vector<const ViewDepth*> GrowingGeometry::KnownNear(const Entry& entry) const {
  std::vector<std::pair<double, const ViewDepth*>> near;
  for (const Entry& other : entries_)
    if (other.map && !other.map->depth.empty())
      near.emplace_back((other.view.center_in_world - entry.view.center_in_world).norm(), &*other.map);
  std::ranges::sort(near, {}, [](const auto& known) { return known.first; });
  std::vector<const ViewDepth*> maps;
  for (const auto& known : near)
    if (maps.size() < kMapsAskedForRange) maps.push_back(known.second);
  return maps;
}

GrowingGeometry::Made GrowingGeometry::Make(int index, const std::vector<StereoView>& views,
                                            const std::atomic<bool>* given_up) const {
  const Entry& entry = entries_[At(index)];
  Made made;
  std::vector<const StereoView*> neighbours;
  for (const int other : NeighboursOf(index, views, *subject_, kNeighbours)) {
    neighbours.push_back(&views[At(other)]);
    made.baselines.push_back(
        {entries_[At(other)].id, views[At(other)].cam_from_world * entry.view.cam_from_world.Inverse()});
  }
  if (neighbours.empty()) return made;
  const double distance = (subject_->center_in_world - entry.view.center_in_world).norm();
  const auto known = RangeOfKnown(entry.view, neighbours, KnownNear(entry));
  const InverseDepthRange range =
      known ? *known : FindRange(entry.view, neighbours, distance, {.given_up = given_up});
  made.map = ViewDepth{entry.view, SweepPlanes(entry.view, neighbours, range, {.given_up = given_up}).depth,
                       (range.most - range.least) / (range.planes - 1)};
  return made;
}

void GrowingGeometry::Keep(Entry& entry, Made made) {
  if (!made.map) entry.tried = came_;
  revision_ += made.map.has_value();
  entry.map = std::move(made.map);
  entry.baselines = std::move(made.baselines);
}

std::optional<GrowingGeometry::NewMap> GrowingGeometry::NextMap(bool all_views_are_here,
                                                                const std::atomic<bool>* given_up) const {
  const int index = Next(all_views_are_here);
  if (index < 0) return std::nullopt;
  NewMap map{index, Make(index, Views(), given_up)};
  if (given_up && given_up->load()) return std::nullopt;
  return map;
}

void GrowingGeometry::Keep(NewMap map) { Keep(entries_[At(map.index)], std::move(map.made)); }

bool GrowingGeometry::MakeNextMap(bool all_views_are_here) {
  std::optional<NewMap> map = NextMap(all_views_are_here);
  if (map) Keep(std::move(*map));
  return map.has_value();
}

void GrowingGeometry::MakeMissingMaps(double most_s) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<StereoView> views = Views();
  while (SecondsSince(start) < most_s) {
    std::vector<int> indices;
    for (int index = Next(true); index >= 0 && indices.size() < kMapsAtOnce; index = Next(true)) {
      entries_[At(index)].map = ViewDepth{views[At(index)], {}, 0};  // so that the next one is not beside it
      indices.push_back(index);
    }
    if (indices.empty()) return;
    std::vector<Made> made(indices.size());
    ParallelFor(indices.size(), [&](std::size_t i) { made[i] = Make(indices[i], views); });
    for (std::size_t i = 0; i < indices.size(); ++i) Keep(entries_[At(indices[i])], std::move(made[i]));
  }
}

int GrowingGeometry::MissingMaps() const {
  if (!subject_ || entries_.size() < 2) return 0;
  int missing = 0;
  // Assumes that each of them had been made: those too near to one another then are not missing.
  GrowingGeometry rest(*this);
  for (int index = rest.Next(true); index >= 0; index = rest.Next(true)) {
    rest.entries_[At(index)].map = ViewDepth{rest.entries_[At(index)].view, {}, 0};
    ++missing;
  }
  return missing;
}

}  // namespace ulf::render
