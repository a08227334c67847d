// Makes geometry during a capture: as views are recorded, a thread of lowest priority makes their depth maps
// and, now and then, a mesh of them (render/stereo/growing_geometry.h). The thread keeps to a share of one
// processor. The mesh serves review and measurement while the capture goes on; at the end the maps that are
// still missing are made on all processors, and the mesh and the maps become the light field's.
//
// A capture waits for geometry only at its end, and a failure is reported and ends geometry alone. The thread
// runs only when a processor is idle (SCHED_IDLE), so that it may be preempted while it holds the lock: the
// caller tries the lock and never waits for it; changes that could not be passed wait for the next call.
//
// The end is bounded even where other programs keep all processors busy. Finish() makes the thread an
// ordinary one (if the kernel lets it: an unprivileged process needs RLIMIT_NICE for that), has it give up
// the map that it is making, waits a second for it, and then goes on without it: the thread only reads what
// Finish() copies. The destructor waits for the thread: for the rest of a step of a map, a tenth of a second
// of a processor, or of a mesh, a second or two, at the pace that the kernel grants it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"
#include "render/proxy/view_depth_map.h"
#include "render/stereo/growing_geometry.h"
#include "render/stereo/stereo_view.h"

namespace ulf::coverage {

// A mesh of the depth maps at some moment.
struct LiveMesh {
  Subject subject;  // in whose sphere it was made
  std::shared_ptr<const render::TriangleMesh> mesh;
  int maps = 0;  // how many it is made of
  // By render/proxy/subject_in_mesh; none: nothing stands apart, or Finish() made it.
  std::optional<Subject> subject_seen;
  int lens = 0;  // how often StartAgain() was called before
};

struct LiveGeometryState {
  int views = 0;                         // how many geometry knows
  int maps = 0;                          // how many are made
  double processor_s = 0;                // processor time of the thread so far
  std::shared_ptr<const LiveMesh> mesh;  // the newest; null: none yet
};

// A depth map of a view, made before.
struct KnownMap {
  int view_id = 0;
  CameraModel camera;     // of the map, without distortion
  cv::Mat depth;          // CV_32F, along the optical axis, world units; 0: none
  double plane_step = 0;  // ViewDepth::plane_step
};

struct FinishedGeometry {
  std::shared_ptr<const LiveMesh> mesh;  // null: the views agree on no surface, or there is no subject
  int maps = 0, missing_maps = 0;        // missing: there was no time for them
  // The mesh's depth maps under the views' last poses, for the renderer, by View::id; empty without a mesh.
  std::map<int, render::ViewDepthMap> maps_for_rendering;
  std::map<int, Rigid3> map_poses;  // these last poses, cam_from_world
  int written_maps = 0;             // how many WriteGeometry() (geometry_files.h) has written
  std::set<int> views_left_out;     // by View::id: there was no time even to look at them
  std::set<int> unreadable_views;   // by View::id: their pictures could not be read
  double seconds = 0;               // how long Finish() and the writing took
};

class LiveGeometry {
 public:
  // A correction that moves nothing by more, in pixels of geometry's pictures, changes no geometry. Guessed.
  static constexpr double kMoved_px = 0.5;
  struct Options {
    render::GrowingGeometryOptions growing;
    double processor_share = 0.4;  // of one processor, while the capture goes on. Guessed.
    int first_mesh_maps = 6;       // the first mesh is made of so many maps. Guessed.
    double more_maps = 1.35;       // a new mesh is made when there are so many times as many maps. Guessed.
    // A correction that moves a view by more than kMoved_px, or a view that was taken back, makes a new mesh
    // at once, but not sooner than this after the last one. Guessed.
    double between_meshes_s = 4;
    // So many pictures in memory may wait to be reduced; further views are left out. Guessed: 24 megapixels
    // take 72 MB.
    std::size_t most_waiting = 8;
    // The time at the end for missing maps and for waiting pictures, which get half of it at most. Guessed:
    // the whole then takes ten seconds.
    double finish_s = 6;
    bool gives_way = true;  // false: the thread has an ordinary priority, for tests that wait for it
    std::filesystem::path light_field;  // for messages: 'ulf proxy' of it makes what is missing here
    bool threaded = true;  // false: WorkNow() and Finish() make everything, and leave nothing out
  };
  // Reads a picture, 8-bit sRGB B G R, in the geometry's thread.
  using ReadPicture = std::function<cv::Mat()>;
  // Says where a picture is until it is reduced: one that is held in memory must not wait in any number.
  enum class Picture { kIsRead, kIsHeld };

  explicit LiveGeometry(const Options& options);
  ~LiveGeometry();
  LiveGeometry(const LiveGeometry&) = delete;
  LiveGeometry& operator=(const LiveGeometry&) = delete;

  // The following return at once. One thread calls them, and one of them at every frame, which passes on what
  // waits. Without a subject no mesh is made.
  void SetSubject(const Subject& subject);
  void AddView(int id, ReadPicture picture, const CameraModel& camera, const Rigid3& cam_from_world,
               Picture where = Picture::kIsRead);
  void RemoveView(int id);
  void MoveViews(const std::map<int, Rigid3>& cam_from_world);
  // Adds depth maps that an earlier session made of the added views under their poses; `read` runs in the
  // geometry's thread.
  void AddMaps(std::function<std::vector<KnownMap>()> read);
  // Call it when the lens has changed: drops all views with their maps and the mesh; the caller adds the
  // views again.
  void StartAgain();
  const LiveGeometryState& State();                // an older one while the thread holds the lock
  bool HasFailed() const { return failed_; }       // no mesh will come any more
  bool IsCorrected() const { return corrected_; }  // a view was removed or moved, or the lens has changed
  // Returns why there will be no geometry, or none of some views, once each; none if nothing new. The caller
  // reports it, because the failure was in another thread.
  std::optional<std::string> TakeProblem();

  // Makes the maps that are due, and a mesh, where there is no thread.
  void WorkNow();

  // Call it once, last: ends the thread, makes what is missing, the mesh of all, and the maps for rendering.
  FinishedGeometry Finish();

 private:
  using Clock = std::chrono::steady_clock;
  // Holds what geometry is made of.
  struct World {
    render::GrowingGeometry growing;
    std::optional<Subject> subject;
    int lens = 0;
  };
  using Change = std::function<void(World&)>;
  // A change that must be prepared, which may take long: a picture is read and reduced.
  struct PendingChange {
    std::optional<int> view;  // that it adds
    std::function<Change(render::StereoViewMaker&)> prepare;
  };
  struct Problem {
    std::optional<int> view;  // that is left out
    std::string words;
  };
  struct Meshed {
    std::shared_ptr<const LiveMesh> mesh;  // null: the maps agree on no surface
    std::map<int, Rigid3> poses;           // of its maps
  };
  enum class MeshFor { kNow, kEnd };

  void Do(PendingChange coming);
  void Do(Change change);
  void PassToThread();
  void AcceptChanges() ULF_REQUIRES(mutex_);
  Change Prepare(const PendingChange& coming, render::StereoViewMaker& maker);
  void Loop();
  bool Work();
  bool IsMeshDue() const;
  // Returns whether corrections require another mesh that is not due yet.
  bool WaitsForMesh() const;
  Meshed MakeMesh(const World& world, MeshFor what_for) const;
  bool KeepMesh(Meshed made);
  bool KeepMap(render::GrowingGeometry::NewMap map);
  void NoteWorld() ULF_REQUIRES(mutex_);
  // Ends the thread and waits for it, for so long at most.
  void EndThread(double most_s);
  void Fail(const std::string& what);
  void LeaveOut(int id, const std::string& why);

  const Options options_;

  // Used by the caller alone.
  std::deque<PendingChange> to_hand_over_;
  LiveGeometryState seen_;
  std::optional<Problem> problem_seen_;
  std::set<int> removed_;  // their pictures go, and may be gone before they are read
  std::deque<std::weak_ptr<const ReadPicture>> held_;  // pictures that wait, or did
  std::set<int> left_out_views_;
  std::map<int, Rigid3> first_poses_;  // with which the views came
  bool corrected_ = false;
  int lens_ = 0;

  // Used by the thread alone, which changes `world_` only while it holds the lock and is not over; Finish()
  // copies it then.
  World world_;
  render::StereoViewMaker maker_;
  std::optional<std::map<int, Rigid3>> poses_of_mesh_;  // none: no mesh has been made
  Clock::time_point next_mesh_;                         // not sooner
  std::atomic<bool> failed_ = false;
  std::atomic<bool> left_out_ = false;  // a view, and that was said
  std::atomic<bool> given_up_ = false;

  Mutex mutex_;
  ConditionVariable changed_;
  std::deque<PendingChange> changes_ ULF_GUARDED_BY(mutex_);
  bool over_ ULF_GUARDED_BY(mutex_) = false;
  bool ended_ ULF_GUARDED_BY(mutex_) = false;  // the thread
  LiveGeometryState state_ ULF_GUARDED_BY(mutex_);
  std::optional<Problem> problem_ ULF_GUARDED_BY(mutex_);
  std::set<int> unreadable_ ULF_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace ulf::coverage
