// The interactive viewer on a surface: the light field from wherever the person stands, drawn when something
// has changed and not otherwise.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/display/painter.h"
#include "render/display/surface.h"
#include "render/fields/mesh_field.h"
#include "render/gl/gl_renderer.h"
#include "render/viewer/moving_size.h"
#include "render/viewer/viewer_state.h"
#include "render/viewer/viewpoint_gizmo.h"

namespace ulf::render {

// A proxy that is made when it is first wanted.
struct OfferedProxy {
  std::string name;
  std::function<std::shared_ptr<const Proxy>()> make;
};

struct ViewerOptions {
  FieldOptions field;
  std::vector<OfferedProxy> proxies;     // not empty; the first is shown
  std::filesystem::path out = ".";       // where pictures and keyframes go
  double gpu_memory_mb = 0;              // RenderOptions::gpu_memory_mb
  double sensor_width_mm = 36;           // that an f-number is told for
  bool keeps_up = true;                  // while the camera moves it is drawn as large as keeps up with that
  std::function<double()> seconds = {};  // a clock; null: the steady one
};

class Viewer {
 public:
  // The surface's context is current, and stays so.
  Viewer(Surface& surface, std::shared_ptr<const RenderScene> scene, const ViewerOptions& options);

  // Takes what has been pressed, waits up to `patience_s` for it, and draws what has changed, what has been
  // read of photographs that the last picture lacked, or what was drawn smaller while the camera moved and
  // now rests. False once the person leaves.
  bool Step(double patience_s);

  const ViewerState& state() const { return input_.state(); }
  void Place(const ViewerCamera& camera) { input_.Place(camera); }
  void Open(const Aperture& aperture) { input_.Open(aperture); }
  bool loading() const { return renderer_->loading(); }
  const GlRenderer& renderer() const { return *renderer_; }
  int frames() const { return frames_; }
  const cv::Size& drawn_size() const { return drawn_size_; }         // of the light field in the last frame
  const std::vector<double>& frame_ms() const { return frame_ms_; }  // of the last ones

 private:
  void Obey(const ViewerRequest& request);
  void SwitchOver();
  void FocusOn(const Eigen::Vector2d& img);
  void TakeProxy(std::size_t index);
  bool IsReduced() const { return frames_ > 0 && drawn_size_ != shown_size_; }
  void Draw(bool moves);
  void Paint(const cv::Size& drawn_size);  // onto the surface, without showing it
  void DrawOverlays(const CameraModel& camera, const Rigid3& cam_from_world);
  void DrawWords(const PlainPanels& panels);
  void DrawFocus(const CameraModel& camera, const Rigid3& cam_from_world);
  void DrawWhere(const cv::Size& screen, double scale);
  void Say(const std::string& words);
  void SavePicture();
  void SaveKeyframe();

  Surface& surface_;
  std::shared_ptr<const RenderScene> scene_;  // its proxy is not looked at
  ViewerOptions options_;
  std::vector<std::shared_ptr<const Proxy>> proxies_;  // null: not made yet
  std::unique_ptr<GlRenderer> renderer_;
  Painter painter_;
  ViewpointGizmo where_;
  MeshField coarse_mesh_;
  std::unique_ptr<MeshField> fine_mesh_;
  int fine_level_ = 0;
  ViewerInput input_;

  std::optional<ViewerState> shown_;  // on the screen
  cv::Size shown_size_;
  bool stale_ = true;
  std::string said_;  // until something is pressed
  MovingSize moving_size_;
  cv::Size drawn_size_;
  double moved_s_ = 0;  // when the camera has moved last
  int frames_ = 0;
  double picture_ms_ = 0;             // of the frame that is being drawn
  double last_frame_picture_ms_ = 0;  // of the one that frame_ms_ ends with
  std::vector<double> frame_ms_;
};

}  // namespace ulf::render
