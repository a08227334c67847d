// Draws the review's picture with the renderer (render/gl), over the mesh that geometry has made so far, as
// `ulf view` would draw the light field now. On request stripes mark where no view is near, as in the viewer:
// what is smeared without stripes is the method's limit, not a gap.
//
// The scene is read from the light field on disk, in a thread of its own, and again when views, poses, the
// subject or the mesh have changed. Until a new scene has its photographs the last one is drawn. All calls
// need the thread and the current OpenGL context of the display.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "coverage/session/capture_state.h"
#include "render/gl/gl_objects.h"
#include "render/gl/gl_renderer.h"
#include "render/viewer/moving_size.h"

namespace ulf::coverage {

// Draws a texture of a camera without distortion as a camera with distortion at the same place sees it.
class DistortedPicture {
 public:
  DistortedPicture();
  ~DistortedPicture();
  DistortedPicture(const DistortedPicture&) = delete;
  DistortedPicture& operator=(const DistortedPicture&) = delete;

  // Returns a camera without distortion that sees at least what `camera` sees, at its resolution. Its picture
  // is at most half as wide and high again on each side, also for a lens that bends more.
  static CameraModel Undistorted(const CameraModel& camera);
  // `texture`: of Undistorted(camera), its last row first. Returns a texture of `camera`, its top row first,
  // valid until the next call.
  unsigned Draw(unsigned texture, const CameraModel& camera);
  cv::Mat Read() const;  // what was drawn, 8-bit B, G, R

 private:
  render::GlProgram program_;
  render::GlBuffer vertices_;
  render::GlEmptyVertexArray no_attributes_;
  render::GlTarget result_;
};

class RenderedReview {
 public:
  // `fps`: where the renderer is slower, pictures get smaller, down to a quarter of the width, because
  // tracking needs the processors that a software renderer takes. Guessed.
  explicit RenderedReview(double fps = 10) : size_(fps) {}
  ~RenderedReview();  // waits for the scene that is being read

  // Call it when the review is closed: frees everything, and lets what has failed be tried again.
  void Close();
  // Call it before every picture while the review is open. `now_s`: seconds of any clock.
  void Follow(const CaptureState& state, double now_s);
  // Returns the picture of a camera, smaller where it moves and the renderer is slow; none if nothing of this
  // state can be drawn yet. A texture, its top row first, valid until the next call.
  std::optional<unsigned> Draw(const CameraModel& camera, const Rigid3& cam_from_world);
  cv::Mat Read() const { return distorted_->Read(); }  // after Draw() gave one
  // Returns whether the picture is drawn from this view, among others.
  bool Shows(int view_id) const;
  bool is_loading() const;  // the last picture lacked photographs, or is of an older state
  bool hatches_doubt() const { return hatches_doubt_; }  // whether stripes are drawn
  void SetHatchesDoubt(bool on) { hatches_doubt_ = on; }
  // Returns why the scene cannot be read or drawn, once each. Returns none when there is no new problem.
  std::optional<std::string> TakeProblem() { return std::exchange(problem_, std::nullopt); }

 private:
  struct ViewPose {
    Eigen::Matrix3d cam_from_world;  // rotation
    Eigen::Vector3d center_in_world;
    bool operator==(const ViewPose&) const = default;
  };
  // The light field's state that a scene shows.
  struct Wanted {
    std::map<int, ViewPose> views;  // by id
    CameraModel camera;             // of the views of this session
    int camera_index = 0;           // in the journal
    Subject subject;
    std::shared_ptr<const LiveMesh> mesh;
    bool operator==(const Wanted&) const = default;
  };
  struct Loaded {
    std::shared_ptr<const render::RenderScene> scene;  // null: no view is on disk yet
    std::string problem;                               // empty: none
  };
  struct Drawable {
    Wanted of;
    std::unique_ptr<render::GlRenderer> renderer;
  };
  static Wanted WantedBy(const CaptureState& state);
  static Loaded Load(const std::filesystem::path& light_field, const Wanted& wanted);
  void TakeLoaded();
  bool TryNext(const CameraModel& wide, const Rigid3& cam_from_world);
  unsigned Show(const CameraModel& camera, const CameraModel& wide);
  void Fail(const Wanted& of, const std::string& problem);

  bool hatches_doubt_ = false;
  Wanted wanted_;
  std::optional<Drawable> shown_, next_;  // next: until its photographs are there
  std::optional<Wanted> being_loaded_;
  std::optional<Wanted> failed_;  // the last that could not be read or drawn
  std::future<Loaded> loading_;
  double now_s_ = 0, loaded_at_s_ = -1e9, tried_next_at_s_ = -1e9, failed_at_s_ = -1e9;
  render::MovingSize size_;
  std::optional<Rigid3> drawn_from_;
  std::optional<std::string> problem_;
  std::string said_;
  std::unique_ptr<render::GlTarget> picture_;
  std::unique_ptr<DistortedPicture> distorted_;
};

}  // namespace ulf::coverage
