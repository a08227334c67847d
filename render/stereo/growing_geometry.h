// Builds geometry of a light field during its capture: one depth map after another, as views come, from which
// a mesh can be made at any time (mesh_of_maps.h). The steps are those of `ulf proxy` (proxy_builder.h). A
// single map is made in the thread that asks for it, so that the owner decides when it may cost time. There
// is no lock; const functions may run at the same time.
//
// A view gets a depth map if it stands apart from the views that have one and enough neighbours are around
// it. Depths are kept in the view's own frame: when poses are corrected, a map moves with its view, is scaled
// with its baselines (a loop closure may change the scale), and is made anew after any other motion.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/angles.h"
#include "core/light_field/light_field.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/mesh_of_maps.h"
#include "render/stereo/plane_sweep.h"

namespace ulf::render {

// Finds the range of depths in a view's image from the depth maps of other views, for a sweep with
// `neighbours`. Returns none if `known` show too little of its image.
std::optional<InverseDepthRange> RangeOfKnown(const StereoView& view,
                                              const std::vector<const StereoView*>& neighbours,
                                              const std::vector<const ViewDepth*>& known);

struct GrowingGeometryOptions {
  int size_px = 320;    // longer side of the compared photographs. Guessed: it takes a sixth of 640's time.
  int depth_maps = 60;  // approximate number; as ProxyOptions::depth_maps
  // A view waits until neighbours stand around it, or until this many views have come after it: at the rim
  // none come on one side. Guessed.
  int views_waited_for = 15;
  // Least angle at the subject between two views with depth maps, radians. It grows from half of `depth_maps`
  // on, to twice that as the last of them is made, and is three times that afterwards. Guessed.
  double least_apart = Radians(3);
  MapsMeshOptions mesh = {.most_triangles = 150000};
};

class GrowingGeometry {
 public:
  explicit GrowingGeometry(const GrowingGeometryOptions& options = {});

  const GrowingGeometryOptions& options() const { return options_; }
  // Existing maps stay; the choice of the next views depends on it.
  void SetSubject(const Subject& subject) { subject_ = subject; }
  // `id` is View::id. `view` has options().size_px.
  void AddView(int id, StereoView view);
  void RemoveView(int id);
  void MoveViews(const std::map<int, Rigid3>& cam_from_world);
  // Gives the view a map that was made before, under its present pose, instead of making one. Returns false
  // for an unknown view, or one of another size.
  bool TakeMap(int id, const CameraModel& camera, const cv::Mat& depth, double plane_step);

  // Makes the most needed depth map. With `all_views_are_here` no view waits for neighbours. Returns false if
  // none is needed, or there is no subject.
  bool MakeNextMap(bool all_views_are_here);

  // Do the same in two steps, so that this object can be copied at any time: NextMap() takes long and changes
  // nothing, Keep() takes no time. Between them no view may be added or removed. NextMap() returns none if no
  // map is needed, or `given_up` became true.
  struct NewMap;
  std::optional<NewMap> NextMap(bool all_views_are_here, const std::atomic<bool>* given_up = nullptr) const;
  void Keep(NewMap map);

  // Makes the needed maps, on all processors, until none is left or `most_s` have passed. The same views give
  // the same maps, whatever the number of processors, if there is time for all.
  void MakeMissingMaps(double most_s);

  int views() const { return static_cast<int>(entries_.size()); }
  int maps() const;
  // Returns how many more MakeNextMap(true) would make.
  int MissingMaps() const;
  // Counts changes of the maps (made, moved or dropped): a mesh of an older revision is out of date.
  std::uint64_t revision() const { return revision_; }
  // Returns the maps in order of id; cheap, because the pixels are shared.
  std::vector<ViewDepth> Maps() const;
  // Returns the maps for the soft field, by View::id (mesh_of_maps.h). `mesh` is MeshOfMaps() of Maps().
  std::map<int, ViewDepthMap> MapsForRendering(const TriangleMesh& mesh) const;
  // Returns the poses of the views that have maps, by id.
  std::map<int, Rigid3> MapPoses() const;
  // Returns whether a mesh of the maps with the poses `then` no longer fits: a map was removed, or has moved
  // by more than `most_px` pixels of its image.
  bool HaveMovedSince(const std::map<int, Rigid3>& then, double most_px) const;

 private:
  // A neighbour's relative pose when the map was made.
  struct Baseline {
    int id = 0;
    Rigid3 neighbour_from_view;
  };
  struct Entry {
    int id = 0;
    StereoView view;
    std::optional<ViewDepth> map;
    std::vector<Baseline> baselines;  // to the map's neighbours
    std::uint64_t came = 0;           // number of views that had been added by then
    std::uint64_t tried = 0;          // number of views when no neighbour was found for a map
  };
  struct Made {
    std::optional<ViewDepth> map;  // none: the view has no neighbour
    std::vector<Baseline> baselines;
  };
  Made Make(int index, const std::vector<StereoView>& views,
            const std::atomic<bool>* given_up = nullptr) const;
  void Keep(Entry& entry, Made made);
  const Entry* Find(int id) const;
  std::vector<StereoView> Views() const;
  // Returns the angle between the view's direction and the nearest one with a map, radians.
  double FarFromMaps(const Entry& entry) const;
  double LeastApartNow() const;
  bool StandsAmongNeighbours(const Entry& entry, const std::vector<StereoView>& views) const;
  // Returns the index of the view whose map is most needed; -1 if none.
  int Next(bool all_views_are_here) const;
  std::vector<const ViewDepth*> KnownNear(const Entry& entry) const;
  void MoveMap(Entry& entry) const;

  GrowingGeometryOptions options_;
  std::optional<Subject> subject_;
  std::vector<Entry> entries_;  // by id
  std::uint64_t came_ = 0, revision_ = 0;
};

struct GrowingGeometry::NewMap {
  int index = 0;
  Made made;
};

}  // namespace ulf::render
