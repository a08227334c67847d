// The interactive viewer on a surface. It shows the light field from a camera that the user moves, and draws
// only when something has changed. Step() is called in a loop, in the surface's thread.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/display/painter.h"
#include "render/display/surface.h"
#include "render/fields/field_options.h"
#include "render/fields/mesh_field.h"
#include "render/gl/gl_renderer.h"
#include "render/viewer/moving_size.h"
#include "render/viewer/viewer_state.h"
#include "render/viewer/viewpoint_gizmo.h"

namespace ulf::render {

// A proxy that is made when the user first selects it. If `make` throws Error, the viewer shows its words.
struct OfferedProxy {
  std::string name;
  std::function<std::shared_ptr<const Proxy>()> make;
};

struct ViewerOptions {
  FieldOptions field;
  std::vector<OfferedProxy> proxies;  // not empty; the first is shown first
  // The scene of the views' masks (SceneOptions::of_masks) if the scene is cut out; otherwise null.
  std::shared_ptr<const RenderScene> masks = {};
  std::filesystem::path out = ".";       // folder for pictures and keyframes
  double gpu_memory_mb = 0;              // RenderOptions::gpu_memory_mb
  double sensor_width_mm = 36;           // for f-numbers
  bool reduces_motion = true;            // draw smaller while the camera moves (MovingSize)
  std::function<double()> seconds = {};  // a clock; null: std::chrono::steady_clock
};

class Viewer {
 public:
  // The surface must outlive the viewer. Throws Error without OpenGL 4.5, and as the first proxy does.
  Viewer(Surface& surface, std::shared_ptr<const RenderScene> scene, const ViewerOptions& options);

  // Handles input, for which it waits up to `patience_s`, and draws if something has changed, if the last
  // picture lacked photographs, or if it was reduced and the camera rests now. Returns false when the user
  // quits. Throws SurfaceGone.
  bool Step(double patience_s);

  const ViewerState& state() const { return input_.state(); }
  void Place(const ViewerCamera& camera) { input_.Place(camera); }  // replaces the camera
  void Open(const Aperture& aperture) { input_.Open(aperture); }    // opens and focuses the lens
  bool loading() const { return renderer_->loading() || (masks_ && masks_->loading()); }
  const GlRenderer& renderer() const { return *renderer_; }
  int frames() const { return frames_; }
  const cv::Size& drawn_size() const { return drawn_size_; }         // of the light field in the last frame
  const std::vector<double>& frame_ms() const { return frame_ms_; }  // of up to 1000 last frames

 private:
  // Applies a function to the renderer, and to that of the masks.
  template <typename Does>
  void ToRenderers(Does&& does) {
    does(*renderer_);
    if (masks_) does(*masks_);
  }
  void Execute(const ViewerRequest& request);
  void ApplyState();
  void FocusOn(const Eigen::Vector2d& img);
  void SelectProxy(std::size_t index);
  bool IsReduced() const { return frames_ > 0 && drawn_size_ != shown_size_; }
  void Draw(bool moves);
  void Paint(const cv::Size& drawn_size);  // onto the surface, without showing it
  void DrawOverlays(const CameraModel& camera, const Rigid3& cam_from_world);
  void DrawTexts(const PlainPanels& panels);
  void DrawFocus(const CameraModel& camera, const Rigid3& cam_from_world);
  void DrawGizmo(const cv::Size& screen, double scale);
  void ShowNotice(const std::string& notice);
  void SavePicture();
  void SaveKeyframe();

  Surface& surface_;
  std::shared_ptr<const RenderScene> scene_;  // its own proxy is not used
  ViewerOptions options_;
  std::vector<std::shared_ptr<const Proxy>> proxies_;  // null: not made yet
  std::unique_ptr<GlRenderer> renderer_;
  std::unique_ptr<GlRenderer> masks_;  // for the masks; null if nothing is cut out
  Painter painter_;
  ViewpointGizmo gizmo_;
  MeshField coarse_mesh_;
  std::unique_ptr<MeshField> fine_mesh_;
  int fine_level_ = 0;
  ViewerInput input_;

  std::optional<ViewerState> shown_;  // the state of the picture on the screen
  cv::Size shown_size_;
  bool stale_ = true;
  std::string notice_;  // until the next key or button
  MovingSize moving_size_;
  cv::Size drawn_size_;
  double moved_s_ = 0;  // time of the camera's last movement
  int frames_ = 0;
  double picture_ms_ = 0;             // of the frame that is being drawn
  double last_frame_picture_ms_ = 0;  // of the last frame in frame_ms_
  std::vector<double> frame_ms_;
};

}  // namespace ulf::render
