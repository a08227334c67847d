#include "render/viewer/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "render/viewer/mesh_view.h"
#include "render/viewer/viewer_files.h"
#include "render/viewer/viewer_words.h"

namespace ulf::render {
namespace {

constexpr std::size_t kFramesRemembered = 1000;
constexpr double kUntilMoreIsReadSeconds = 0.02;
constexpr int kFramesAhead = 10;
constexpr double kRestSeconds = 0.2;  // without a move

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

std::shared_ptr<const RenderScene> OverFirst(const RenderScene& scene, const ViewerOptions& options) {
  return WithProxy(scene, options.proxies.front().make());
}

}  // namespace

Viewer::Viewer(Surface& surface, std::shared_ptr<const RenderScene> scene, const ViewerOptions& options)
    : surface_(surface),
      scene_(std::move(scene)),
      options_(options),
      proxies_(options.proxies.size()),
      renderer_(std::make_unique<GlRenderer>(
          OverFirst(*scene_, options),
          RenderOptions{.field = options.field, .gpu_memory_mb = options.gpu_memory_mb, .complete = false},
          GlContextKind::kCurrent)),
      where_(*scene_),
      coarse_mesh_(scene_, 0),
      input_(StartOf(*scene_, options.field), static_cast<int>(options.proxies.size()), where_.Spacing()) {
  proxies_.front() = renderer_->scene().proxy;
  if (!options_.seconds) options_.seconds = SteadySeconds;
}

bool Viewer::Step(double patience_s) {
  const bool was_loading = frames_ > 0 && loading();
  if (was_loading) patience_s = std::min(patience_s, kUntilMoreIsReadSeconds);
  if (IsReduced()) patience_s = std::clamp(moved_s_ + kRestSeconds - options_.seconds(), 0.0, patience_s);
  const std::vector<InputEvent> events = surface_.TakeEvents(patience_s);
  for (const InputEvent& event : events) {
    if (std::holds_alternative<KeyPressed>(event) || std::holds_alternative<Typed>(event) ||
        std::holds_alternative<MouseButton>(event))
      Say("");
    input_.Handle(event, surface_.Size());
  }
  const cv::Size screen = surface_.Size();
  for (const ViewerRequest& request : input_.TakeRequests()) {
    if (request.what == ViewerRequest::kLeave) return false;
    if (!screen.empty()) Obey(request);
  }
  if (screen.empty()) return true;  // iconified
  const bool moves = shown_ && Moves(*shown_, input_.state());
  const bool rests = IsReduced() && !moves && options_.seconds() >= moved_s_ + kRestSeconds;
  if (stale_ || was_loading || rests || shown_ != input_.state() || shown_size_ != screen)
    Draw(moves || (IsReduced() && !rests));
  return true;
}

void Viewer::Obey(const ViewerRequest& request) {
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
    Say(error.what());  // a file that cannot be written is no reason to leave
  }
}

void Viewer::Say(const std::string& words) {
  if (words == said_) return;
  said_ = words;
  stale_ = true;
}

// ---- what has been switched

void Viewer::TakeProxy(std::size_t index) {
  auto& proxy = proxies_[index];
  try {
    if (!proxy) proxy = options_.proxies[index].make();
  } catch (const Error& error) {
    const auto used = std::find(proxies_.begin(), proxies_.end(), renderer_->scene().proxy);
    input_.TakeProxy(static_cast<int>(used - proxies_.begin()));
    return Say(error.what());
  }
  if (renderer_->scene().proxy != proxy) renderer_->SetProxy(proxy);
}

void Viewer::SwitchOver() {
  const ViewerState& now = state();
  TakeProxy(static_cast<std::size_t>(now.proxy));
  if (!shown_ || shown_->field != now.field) renderer_->SetField(now.field);
  renderer_->SetAperture(now.OpenAperture());
  renderer_->ShowField(now.shows_field);
  if (now.shows_mesh) {
    constexpr int kMostLevels = 2;  // more are more lines than picture
    const int level = std::min(renderer_->field().level, kMostLevels);
    const bool subdivided = renderer_->field().kind == FieldKind::kSubdivision && level > 0;
    if (!subdivided) fine_mesh_.reset();
    if (subdivided && (!fine_mesh_ || fine_level_ != level)) {
      fine_mesh_ = std::make_unique<MeshField>(scene_, level);
      fine_level_ = level;
    }
  }
}

// On what the proxy has there.
void Viewer::FocusOn(const Eigen::Vector2d& img) {
  const ViewerCamera& camera = state().camera;
  const Rigid3 cam_from_world = camera.CamFromWorld();
  input_.Focus(PointOnProxy(*renderer_->scene().proxy, camera.For(surface_.Size()), cam_from_world, img));
  if (state().aperture > 0) return;
  const double depth = FocusDepth({.focus_in_world = state().focus_in_world}, cam_from_world);
  Say(fmt::format("focus at {:.3g}: O opens the aperture", depth));
}

// ---- drawing

void Viewer::Draw(bool moves) {
  const double start_s = options_.seconds();
  if (moves && shown_ && Moves(*shown_, state())) moved_s_ = start_s;
  const cv::Size screen = surface_.Size();
  Paint(moves && options_.keeps_up ? moving_size_.For(screen) : screen);
  surface_.Present();
  const double end_s = options_.seconds();
  frame_ms_.push_back(1000 * (end_s - start_s));
  if (frame_ms_.size() > kFramesRemembered) frame_ms_.erase(frame_ms_.begin());
  last_frame_picture_ms_ = picture_ms_;
  moving_size_.Took(frame_ms_.back(), drawn_size_, screen);
  ++frames_;
  shown_ = state();
  shown_size_ = screen;
  stale_ = false;
}

void Viewer::Paint(const cv::Size& drawn_size) {
  const double start_s = options_.seconds();
  drawn_size_ = drawn_size;
  SwitchOver();
  const cv::Size screen = surface_.Size();
  const ViewerState now = state();
  const CameraModel camera = now.camera.For(screen);
  const Rigid3 cam_from_world = now.camera.CamFromWorld();
  if (shown_ && shown_->camera != now.camera) {
    const ViewerCamera ahead = Ahead(shown_->camera, now.camera, kFramesAhead);
    renderer_->Prefetch(ahead.For(screen), ahead.CamFromWorld());
  }
  renderer_->Draw(now.camera.For(drawn_size), cam_from_world);
  surface_.Bind();
  renderer_->Show({.exposure_stops = now.exposure_stops, .hatches_doubt = now.shows_doubt});
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
  if (now.aperture > 0 && now.shows_words) DrawFocus(camera, cam_from_world);
  const PlainPanels panels(painter_, screen, scale);
  if (now.shows_where) DrawWhere(screen, scale);
  if (now.shows_words) DrawWords(panels);
  if (now.shows_keys) {
    std::vector<TableRow> rows;
    for (const KeyHelp& help : kViewerKeys) rows.push_back({{}, help.keys, help.what});
    panels.Keys(rows);
  }
}

// Where the point is that stays in focus.
void Viewer::DrawFocus(const CameraModel& camera, const Rigid3& cam_from_world) {
  const auto img = camera.ImgFromCam(cam_from_world * state().focus_in_world);
  if (!img) return;
  const double arm = 9 * ScaleOf(surface_);
  const Overlay corner{
      Polyline{{*img + Eigen::Vector2d(-arm, 0), *img + Eigen::Vector2d(arm, 0)}, 1.5, ink::kCareful},
      Polyline{{*img + Eigen::Vector2d(0, -arm), *img + Eigen::Vector2d(0, arm)}, 1.5, ink::kCareful}};
  painter_.Draw(corner, {.picture = surface_.Size()});
}

void Viewer::DrawWhere(const cv::Size& screen, double scale) {
  constexpr double kPoints = 150, kMargin = 12, kUnderStatus = 30;
  Placement placement;
  placement.scale = scale;  // so that what is drawn keeps its size whatever the screen's density
  placement.picture = {kPoints, kPoints};
  placement.origin = {screen.width - scale * (kPoints + kMargin), scale * (kUnderStatus + kMargin)};
  painter_.Draw(where_.Draw(state().camera.eye_in_world, kPoints), placement);
}

void Viewer::DrawWords(const PlainPanels& panels) {
  const double frame_ms = frame_ms_.empty() ? 0 : frame_ms_.back();
  const CameraModel camera = state().camera.For(surface_.Size());
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
  const std::string warning = where_.Warning(state().camera.eye_in_world);
  if (!warning.empty()) panels.Instruction(warning, ink::kCareful);
  if (!said_.empty()) panels.Said(said_);
  panels.Hint("? keys");
}

// ---- files

void Viewer::SavePicture() {
  do Paint(surface_.Size());  // what a window has presented is nobody's
  while (loading());
  Say(SaveNumbered(options_.out, surface_.Read()).string());
}

void Viewer::SaveKeyframe() {
  const auto file = options_.out / kKeyframeFile;
  const std::size_t count = AppendKeyframe(file, state().camera, surface_.Size(), state().OpenAperture());
  Say(fmt::format("keyframe {}: ulf render --path {}", count, file.string()));
}

}  // namespace ulf::render
