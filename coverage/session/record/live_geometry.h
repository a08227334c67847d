// Geometry while shooting: as views are recorded, a thread that gives way to everything else makes their depth
// maps and, now and then, a mesh of them (render/stereo/growing_geometry.h). It keeps to a share of one
// processor. The mesh serves review and measurement while the capture goes on; at the end the maps that are
// still missing are made on all processors, and the mesh becomes the light field's.
//
// A capture never waits for it, but at its end; what fails here is said and fails alone. The thread runs only
// when a processor has nothing else to do (SCHED_IDLE), so that it may be kept from running while it holds the
// lock: whoever owns this class tries the lock and never waits for it; what could not be handed over waits for
// the next call.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"
#include "render/stereo/growing_geometry.h"
#include "render/stereo/stereo_view.h"

namespace ulf::coverage {

// The mesh of the maps that were there at some moment.
struct LiveMesh {
  Subject subject;
  std::shared_ptr<const render::TriangleMesh> mesh;
  int maps = 0;
  std::optional<Subject> subject_seen;  // render/proxy/subject_in_mesh; none: nothing stands apart
};

struct LiveGeometryState {
  int views = 0;                         // that geometry knows
  int maps = 0;                          // that are made
  double processor_s = 0;                // that it has taken
  std::shared_ptr<const LiveMesh> mesh;  // the newest; null: none yet
};

struct FinishedGeometry {
  std::shared_ptr<const LiveMesh> mesh;  // null: the views agree on no surface, or there is no subject
  int maps = 0, missing_maps = 0;        // missing: there was no time for them
  double seconds = 0;
};

class LiveGeometry {
 public:
  struct Options {
    render::GrowingGeometryOptions growing;
    double processor_share = 0.4;  // of one processor, while the capture goes on. Guessed.
    int first_mesh_maps = 6;       // that make the first mesh. Guessed.
    double more_maps = 1.35;       // a new mesh when there are so many times as many maps. Guessed.
    // About, of meshes while the capture goes on: they are drawn at every frame (coverage/measured). Guessed.
    int live_triangles = 30000;
    double finish_s = 6;   // for missing maps at the end. Guessed: the whole then takes ten seconds.
    bool threaded = true;  // false: nothing is made before Finish(), or by WorkNow()
  };
  // A picture as geometry wants it, 8-bit sRGB; read in the geometry's thread.
  using ReadPicture = std::function<cv::Mat()>;

  explicit LiveGeometry(const Options& options);
  ~LiveGeometry();  // waits for the map that is being made
  LiveGeometry(const LiveGeometry&) = delete;
  LiveGeometry& operator=(const LiveGeometry&) = delete;

  // These return at once. For one thread, which calls one of them at every frame.
  void SetSubject(const Subject& subject);
  void AddView(int id, ReadPicture picture, const CameraModel& camera, const Rigid3& cam_from_world);
  void RemoveView(int id);
  void MoveViews(const std::map<int, Rigid3>& cam_from_world);
  const LiveGeometryState& State();  // the newest that could be had
  // Why there will be no geometry, once; none: nothing new. For the caller to say: the failure was in another thread.
  std::optional<std::string> TakeProblem();

  // Without a thread: makes the maps that are due, and a mesh.
  void WorkNow();

  // Ends the thread, makes what is missing and the mesh of all.
  FinishedGeometry Finish();

 private:
  void Do(std::function<void()> change);
  void HandOver();
  void TakeOver() ULF_REQUIRES(mutex_);
  void Loop();
  void Work();
  enum class MeshFor { kNow, kEnd };
  void MakeMesh(MeshFor what_for);
  void Fail(const std::string& what);
  void LeaveOut(int id, const std::string& why);

  const Options options_;

  // The caller's own.
  std::deque<std::function<void()>> to_hand_over_;
  LiveGeometryState seen_;
  std::optional<std::string> problem_seen_;

  // The thread's own, and after Finish() has ended it the caller's.
  render::GrowingGeometry growing_;
  render::StereoViewMaker maker_;
  std::optional<Subject> subject_;
  int maps_of_mesh_ = 0;
  std::uint64_t revision_of_mesh_ = 0;
  bool failed_ = false;
  bool left_out_ = false;  // a view, and that was said

  Mutex mutex_;
  ConditionVariable changed_;
  std::deque<std::function<void()>> changes_ ULF_GUARDED_BY(mutex_);
  bool over_ ULF_GUARDED_BY(mutex_) = false;
  LiveGeometryState state_ ULF_GUARDED_BY(mutex_);
  std::optional<std::string> problem_ ULF_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace ulf::coverage
