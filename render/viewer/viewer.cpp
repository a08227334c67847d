#include "render/viewer/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "render/viewer/mesh_view.h"
#include "render/viewer/viewer_files.h"

namespace ulf::render {
namespace {

// The camera rests when it has not moved for this time, and is drawn at full size. Guessed.
constexpr double kRest_s = 0.2;
constexpr double kReread_s =
    0.02;  // while photographs are missing, a picture is drawn at least this often. Guessed.
// Photographs are prefetched for the camera after this many movements like the last one. Guessed.
constexpr int kMovementsAhead = 10;

constexpr std::size_t kFramesRemembered = 1000;  // for the median in the report

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool Moves(const ViewerState& before, const ViewerState& now) {
  return before.camera != now.camera || before.aperture != now.aperture ||
         before.focus_in_world != now.focus_in_world;
}

ViewerState StartOf(const RenderScene& scene, const FieldOptions& field) {
  ViewerState state;
  state.camera = StartingCamera(scene);
  state.field = field;
  state.focus_in_world = scene.subject.center_in_world;
  return state;
}

std::shared_ptr<const RenderScene> WithFirstProxy(const RenderScene& scene, const ViewerOptions& options) {
  return WithProxy(scene, options.proxies.front().make());
}

}  // namespace

Viewer::Viewer(Surface& surface, std::shared_ptr<const RenderScene> scene, const ViewerOptions& options)
    : surface_(surface),
      scene_(std::move(scene)),
      options_(options),
      proxies_(options.proxies.size()),
      renderer_(std::make_unique<GlRenderer>(
          WithFirstProxy(*scene_, options),
          RenderOptions{.field = options.field, .gpu_memory_mb = options.gpu_memory_mb, .complete = false},
          GlContextKind::kCurrent)),
      gizmo_(*scene_),
      coarse_mesh_(scene_, 0),
      input_(StartOf(*scene_, options.field), static_cast<int>(options.proxies.size()), gizmo_.Spacing()) {
  proxies_.front() = renderer_->scene().proxy;
  if (options_.masks)
    masks_ = std::make_unique<GlRenderer>(
        WithProxy(*options_.masks, proxies_.front()),
        RenderOptions{.field = options.field, .gpu_memory_mb = options.gpu_memory_mb, .complete = false},
        GlContextKind::kCurrent);
  if (!options_.seconds) options_.seconds = SteadySeconds;
}

bool Viewer::Step(double patience_s) {
  const bool was_loading = frames_ > 0 && loading();
  if (was_loading) patience_s = std::min(patience_s, kReread_s);
  if (IsReduced()) patience_s = std::clamp(moved_s_ + kRest_s - options_.seconds(), 0.0, patience_s);
  const std::vector<InputEvent> events = surface_.TakeEvents(patience_s);
  for (const InputEvent& event : events) {
    if (std::holds_alternative<KeyPressed>(event) || std::holds_alternative<Typed>(event) ||
        std::holds_alternative<MouseButton>(event))
      ShowNotice("");
    input_.Handle(event, surface_.Size());
  }
  const cv::Size screen = surface_.Size();
  for (const ViewerRequest& request : input_.TakeRequests()) {
    if (request.what == ViewerRequest::kLeave) return false;
    if (!screen.empty()) Execute(request);
  }
  if (screen.empty()) return true;  // iconified
  const bool moves = shown_ && Moves(*shown_, input_.state());
  const bool rests = IsReduced() && !moves && options_.seconds() >= moved_s_ + kRest_s;
  if (stale_ || was_loading || rests || shown_ != input_.state() || shown_size_ != screen)
    Draw(moves || (IsReduced() && !rests));
  return true;
}

void Viewer::Execute(const ViewerRequest& request) {
  try {
    switch (request.what) {
      case ViewerRequest::kLeave:
        return;
      case ViewerRequest::kFullScreen:
        return surface_.ToggleFullScreen();
      case ViewerRequest::kNearestView:
        return input_.Place(AtNearestView(state().camera, *scene_));
      case ViewerRequest::kFocus:
        return FocusOn(request.img);
      case ViewerRequest::kScreenshot:
        return SavePicture();
      case ViewerRequest::kKeyframe:
        return SaveKeyframe();
    }
  } catch (const SurfaceGone&) {
    throw;
  } catch (const Error& error) {
    ShowNotice(error.what());
  }
}

void Viewer::ShowNotice(const std::string& notice) {
  if (notice == notice_) return;
  notice_ = notice;
  stale_ = true;
}

// ---- State

void Viewer::SelectProxy(std::size_t index) {
  auto& proxy = proxies_[index];
  try {
    if (!proxy) proxy = options_.proxies[index].make();
  } catch (const Error& error) {
    const auto used = std::ranges::find(proxies_, renderer_->scene().proxy);
    input_.SelectProxy(static_cast<int>(used - proxies_.begin()));
    return ShowNotice(error.what());
  }
  if (renderer_->scene().proxy != proxy) ToRenderers([&](GlRenderer& renderer) { renderer.SetProxy(proxy); });
}

void Viewer::ApplyState() {
  const ViewerState& now = state();
  SelectProxy(static_cast<std::size_t>(now.proxy));
  if (!shown_ || shown_->field != now.field)
    ToRenderers([&](GlRenderer& renderer) { renderer.SetField(now.field); });
  ToRenderers([&](GlRenderer& renderer) { renderer.SetAperture(now.OpenAperture()); });
  renderer_->ShowField(now.shows_field);
  if (now.shows_mesh) {
    constexpr int kMostLevels = 2;  // more levels cover the picture with lines. Guessed.
    const int level = std::min(renderer_->field().level, kMostLevels);
    const bool subdivided = renderer_->field().kind == FieldKind::kSubdivision && level > 0;
    if (!subdivided) fine_mesh_.reset();
    if (subdivided && (!fine_mesh_ || fine_level_ != level)) {
      fine_mesh_ = std::make_unique<MeshField>(scene_, level);
      fine_level_ = level;
    }
  }
}

// Focuses on the proxy's point at `img`.
void Viewer::FocusOn(const Eigen::Vector2d& img) {
  const ViewerCamera& camera = state().camera;
  const Rigid3 cam_from_world = camera.CamFromWorld();
  input_.Focus(
      PointOnProxy(*renderer_->scene().proxy, camera.ModelFor(surface_.Size()), cam_from_world, img));
  if (state().aperture > 0) return;
  const double depth = FocusDepth({.focus_in_world = state().focus_in_world}, cam_from_world);
  ShowNotice(fmt::format("focus at {:.3g}: O opens the aperture", depth));
}

// ---- Drawing

void Viewer::Draw(bool moves) {
  const double start_s = options_.seconds();
  if (moves && shown_ && Moves(*shown_, state())) moved_s_ = start_s;
  const cv::Size screen = surface_.Size();
  Paint(moves && options_.reduces_motion ? moving_size_.SizeFor(screen) : screen);
  surface_.Present();
  const double end_s = options_.seconds();
  frame_ms_.push_back(1000 * (end_s - start_s));
  if (frame_ms_.size() > kFramesRemembered) frame_ms_.erase(frame_ms_.begin());
  last_frame_picture_ms_ = picture_ms_;
  moving_size_.AddFrame(frame_ms_.back(), drawn_size_, screen);
  ++frames_;
  shown_ = state();
  shown_size_ = screen;
  stale_ = false;
}

void Viewer::Paint(const cv::Size& drawn_size) {
  const double start_s = options_.seconds();
  drawn_size_ = drawn_size;
  ApplyState();
  const cv::Size screen = surface_.Size();
  const ViewerState now = state();
  const CameraModel camera = now.camera.ModelFor(screen);
  const Rigid3 cam_from_world = now.camera.CamFromWorld();
  if (shown_ && shown_->camera != now.camera) {
    const ViewerCamera ahead = Extrapolated(shown_->camera, now.camera, kMovementsAhead);
    ToRenderers(
        [&](GlRenderer& renderer) { renderer.Prefetch(ahead.ModelFor(screen), ahead.CamFromWorld()); });
  }
  ToRenderers([&](GlRenderer& renderer) { renderer.Draw(now.camera.ModelFor(drawn_size), cam_from_world); });
  surface_.Bind();
  renderer_->Show({.exposure_stops = now.exposure_stops,
                   .hatches_doubt = now.shows_doubt,
                   .of_masks = now.shows_field ? nullptr : masks_.get()});
  picture_ms_ = 1000 * (options_.seconds() - start_s);
  painter_.Begin(screen, ScaleOf(surface_));
  DrawOverlays(camera, cam_from_world);
  painter_.End();
}

void Viewer::DrawOverlays(const CameraModel& camera, const Rigid3& cam_from_world) {
  const ViewerState& now = state();
  const cv::Size screen = surface_.Size();
  const double scale = ScaleOf(surface_);
  if (now.shows_mesh)
    painter_.Draw(MeshView(coarse_mesh_, fine_mesh_.get(), *scene_, camera, cam_from_world),
                  {.picture = screen});
  if (now.aperture > 0 && now.shows_texts) DrawFocus(camera, cam_from_world);
  const PlainPanels panels(painter_, screen, scale);
  if (now.shows_gizmo) DrawGizmo(screen, scale);
  if (now.shows_texts) DrawTexts(panels);
  if (now.shows_keys) {
    std::vector<TableRow> rows;
    for (const KeyHelp& help : kViewerKeys) rows.push_back({{}, help.keys, help.what});
    panels.Keys(rows);
  }
}

// Draws a cross at the point that stays in focus.
void Viewer::DrawFocus(const CameraModel& camera, const Rigid3& cam_from_world) {
  const auto img = camera.ImgFromCam(cam_from_world * state().focus_in_world);
  if (!img) return;
  const double arm = 9 * ScaleOf(surface_);
  const Overlay corner{
      Polyline{{*img + Eigen::Vector2d(-arm, 0), *img + Eigen::Vector2d(arm, 0)}, 1.5, ink::kCareful},
      Polyline{{*img + Eigen::Vector2d(0, -arm), *img + Eigen::Vector2d(0, arm)}, 1.5, ink::kCareful}};
  painter_.Draw(corner, {.picture = surface_.Size()});
}

void Viewer::DrawGizmo(const cv::Size& screen, double scale) {
  constexpr double kPoints = 150, kMargin = 12, kUnderStatus = 30;
  Placement placement;
  placement.scale = scale;  // so that its size does not depend on the screen's density
  placement.picture = {kPoints, kPoints};
  placement.origin = {screen.width - scale * (kPoints + kMargin), scale * (kUnderStatus + kMargin)};
  painter_.Draw(gizmo_.Draw(state().camera.eye_in_world, kPoints), placement);
}

void Viewer::DrawTexts(const PlainPanels& panels) {
  const double frame_ms = frame_ms_.empty() ? 0 : frame_ms_.back();
  const CameraModel camera = state().camera.ModelFor(surface_.Size());
  std::optional<double> f_number;
  if (scene_->in_metres && state().aperture > 0)
    f_number = FNumber(state().aperture, camera.fx, camera.width, options_.sensor_width_mm);
  panels.Status(StatusLine(state(), {.views = scene_->views.size(),
                                     .field = renderer_->field(),
                                     .proxy = renderer_->scene().proxy->Name(),
                                     .focus_depth = FocusDepth({.focus_in_world = state().focus_in_world},
                                                               state().camera.CamFromWorld()),
                                     .f_number = f_number,
                                     .loading = loading(),
                                     .drawn_size = drawn_size_ == surface_.Size() ? cv::Size() : drawn_size_,
                                     .frame_ms = frame_ms,
                                     .picture_ms = last_frame_picture_ms_}));
  const std::string warning = gizmo_.Warning(state().camera.eye_in_world);
  if (!warning.empty()) panels.Instruction(warning, ink::kCareful);
  if (!notice_.empty()) panels.Notice(notice_);
  panels.Hint("? keys");
}

// ---- Files

void Viewer::SavePicture() {
  do Paint(surface_.Size());  // the pixels of a window are undefined after Present()
  while (loading());
  ShowNotice(SaveNumbered(options_.out, surface_.Read()).string());
}

void Viewer::SaveKeyframe() {
  const auto file = options_.out / kKeyframeFile;
  const std::size_t count = AppendKeyframe(file, state().camera, surface_.Size(), state().OpenAperture());
  ShowNotice(fmt::format("keyframe {}: ulf render --path {}", count, file.string()));
}

}  // namespace ulf::render
