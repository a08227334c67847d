#include "coverage/operator/rendered_review.h"

#include <epoxy/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <exception>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/session/record/live_geometry.h"
#include "render/display/surface.h"
#include "render/fields/field_options.h"
#include "render/proxy/proxy.h"
#include "render/scene/scene.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr double kReviewMemory_mb = 256, kReviewGpuMemory_mb = 512;
constexpr int kReviewPhotograph_px = 640;  // longer side of the photographs that are drawn
constexpr double kReviewRefresh_s = 2;     // between two readings of the light field, at least
// So long after a scene could not be read or drawn, another is tried, if anything has changed since: where
// memory lacks, reading all photographs again helps nobody.
constexpr double kReviewRetry_s = 10;
constexpr double kReviewTryNext_s = 0.3;  // between two tries whether the next scene has its photographs

constexpr int kGridColumns = 24, kGridRows = 18;  // of the grid over the picture
constexpr const char* kShaderVersion = "#version 450 core\n";
constexpr const char* kGridVertex = R"(
layout(std430, binding = 0) readonly buffer Vertices { float value[]; };
out vec2 uv;
void main() {
  int at = gl_VertexID * 4;
  gl_Position = vec4(value[at], value[at + 1], 0.0, 1.0);
  uv = vec2(value[at + 2], value[at + 3]);
}
)";
constexpr const char* kGridFragment = R"(
layout(binding = 0) uniform sampler2D picture;
in vec2 uv;
out vec4 color;
void main() { color = vec4(texture(picture, uv).rgb, 1.0); }
)";

}  // namespace

// ---- DistortedPicture

DistortedPicture::DistortedPicture() : result_(GL_RGBA8) {
  const std::string head = kShaderVersion;
  program_.Build("the review's distortion", head + kGridVertex, head + kGridFragment);
}

DistortedPicture::~DistortedPicture() {
  program_.Release();
  vertices_.Release();
  no_attributes_.Release();
  result_.Release();
}

CameraModel DistortedPicture::Undistorted(const CameraModel& camera) {
  // Returns where the border's rays meet the image plane, in pixels of a camera without distortion.
  Eigen::Vector2d low(0, 0), high(camera.width, camera.height);
  const auto include = [&](double x, double y) {
    const auto ray = camera.RayFromImg({x, y});
    if (!ray || !(ray->z() > 0)) return;
    const Eigen::Vector2d img(camera.fx * ray->x() / ray->z() + camera.cx,
                              camera.fy * ray->y() / ray->z() + camera.cy);
    // A lens that bends more would need a picture many times as large.
    const Eigen::Vector2d size(camera.width, camera.height);
    low = low.cwiseMin(img).cwiseMax(-0.5 * size);
    high = high.cwiseMax(img).cwiseMin(1.5 * size);
  };
  for (int i = 0; i <= kGridColumns; ++i)
    for (const double y : {0.0, static_cast<double>(camera.height)})
      include(static_cast<double>(camera.width) * i / kGridColumns, y);
  for (int i = 0; i <= kGridRows; ++i)
    for (const double x : {0.0, static_cast<double>(camera.width)})
      include(x, static_cast<double>(camera.height) * i / kGridRows);
  low = low.array().floor();
  high = high.array().ceil();
  CameraModel wide = camera.WithoutDistortion();
  wide.cx -= low.x();
  wide.cy -= low.y();
  wide.width = static_cast<int>(high.x() - low.x());
  wide.height = static_cast<int>(high.y() - low.y());
  return wide;
}

unsigned DistortedPicture::Draw(unsigned texture, const CameraModel& camera) {
  const CameraModel wide = Undistorted(camera);
  std::vector<float> vertices;
  const auto add = [&](int column, int row) {
    const double across = static_cast<double>(column) / kGridColumns,
                 down = static_cast<double>(row) / kGridRows;
    const auto ray = camera.RayFromImg({camera.width * across, camera.height * down});
    Eigen::Vector2d uv(-1, -1);
    if (ray && ray->z() > 0)
      uv = {(wide.fx * ray->x() / ray->z() + wide.cx) / wide.width,
            1 - (wide.fy * ray->y() / ray->z() + wide.cy) / wide.height};
    for (const double value : {2 * across - 1, 2 * down - 1, uv.x(), uv.y()})
      vertices.push_back(static_cast<float>(value));
  };
  for (int row = 0; row < kGridRows; ++row)
    for (int column = 0; column < kGridColumns; ++column) {
      add(column, row), add(column + 1, row), add(column, row + 1);
      add(column + 1, row), add(column + 1, row + 1), add(column, row + 1);
    }
  result_.Resize(camera.width, camera.height);
  for (const unsigned target : {texture, result_.texture()}) {
    glTextureParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  no_attributes_.Bind();
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  result_.Bind();
  program_.Use();
  vertices_.Upload(vertices);
  vertices_.BindStorage(0);
  glBindTextureUnit(0, texture);
  glDrawArrays(GL_TRIANGLES, 0, 6 * kGridColumns * kGridRows);
  glBindVertexArray(0);
  render::CheckGl("drawing the review");
  return result_.texture();
}

cv::Mat DistortedPicture::Read() const {
  cv::Mat picture;
  cv::cvtColor(result_.Read(), picture, cv::COLOR_BGRA2BGR);
  picture.convertTo(picture, CV_8UC3, 255);
  return picture;
}

// ---- RenderedReview

RenderedReview::~RenderedReview() {
  if (picture_) picture_->Release();
}

RenderedReview::Wanted RenderedReview::WantedBy(const CaptureState& state) {
  Wanted wanted{.views = {},
                .camera = state.recorded_camera,
                .camera_index = state.recorded_camera_index,
                .subject = *state.subject,
                .mesh = state.mesh};
  for (std::size_t i = 0; i < state.view_ids.size(); ++i) {
    const CriterionView& view = state.coverage->views()[i];
    wanted.views.insert({state.view_ids[i], {view.cam_from_world, view.center_in_world}});
  }
  return wanted;
}

RenderedReview::Loaded RenderedReview::Load(const std::filesystem::path& light_field, const Wanted& wanted) {
  try {
    LightField on_disk = ReadLightField(light_field);
    std::erase_if(on_disk.views, [&](const View& view) {
      return !wanted.views.contains(view.id) || !std::filesystem::exists(light_field / view.image_path);
    });
    if (on_disk.views.empty()) return {};
    // The journal may be behind a correction.
    on_disk.cameras.at(static_cast<std::size_t>(wanted.camera_index)) = wanted.camera;
    for (View& view : on_disk.views) {
      const ViewPose& pose = wanted.views.at(view.id);
      view.cam_from_world = {Eigen::Quaterniond(pose.cam_from_world),
                             -(pose.cam_from_world * pose.center_in_world)};
    }
    const auto scene = render::LoadScene(on_disk, {.subject = wanted.subject,
                                                   .size_limit_px = kReviewPhotograph_px,
                                                   .memory_limit_mb = kReviewMemory_mb,
                                                   .form = render::PhotographForm::kEightBits});
    std::shared_ptr<const render::Proxy> proxy = scene->proxy;
    if (wanted.mesh) proxy = std::make_shared<render::MeshProxy>(wanted.subject, wanted.mesh->mesh);
    return {render::WithProxy(*scene, std::move(proxy)), {}};
  } catch (const std::exception& error) {
    return {nullptr, error.what()};
  }
}

void RenderedReview::Close() {
  shown_.reset();
  next_.reset();
  drawn_from_.reset();
  failed_.reset();
  loaded_at_s_ = -1e9;
}

void RenderedReview::Follow(const CaptureState& state, double now_s) {
  if (!state.subject || !state.coverage || state.view_ids.empty() || state.light_field.empty()) return;
  now_s_ = now_s;
  wanted_ = WantedBy(state);
  // What was taken back is not shown any more.
  for (std::optional<Drawable>* drawable : {&shown_, &next_})
    if (*drawable &&
        std::ranges::any_of((*drawable)->renderer->scene().views,
                            [&](const render::SceneView& view) { return !wanted_.views.contains(view.id); }))
      drawable->reset();
  const bool is_new = !(shown_ && shown_->of == wanted_) && !(next_ && next_->of == wanted_);
  if (!is_new || being_loaded_ || now_s - loaded_at_s_ < kReviewRefresh_s) return;
  if (failed_ && (*failed_ == wanted_ || now_s - failed_at_s_ < kReviewRetry_s)) return;
  loaded_at_s_ = now_s;
  being_loaded_ = wanted_;
  loading_ = std::async(std::launch::async, Load, state.light_field, wanted_);
}

void RenderedReview::TakeLoaded() {
  if (!being_loaded_ || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const Loaded loaded = loading_.get();
  Wanted of = *std::exchange(being_loaded_, std::nullopt);
  if (!loaded.problem.empty()) Fail(of, loaded.problem);
  if (!loaded.scene) return;
  // Views that are not on disk yet: the scene is of fewer, and is read again.
  std::erase_if(of.views, [&](const auto& view) {
    return std::ranges::none_of(loaded.scene->views,
                                [&](const render::SceneView& there) { return there.id == view.first; });
  });
  next_ = Drawable{std::move(of), std::make_unique<render::GlRenderer>(
                                      loaded.scene,
                                      render::RenderOptions{.field = render::DefaultField(*loaded.scene),
                                                            .gpu_memory_mb = kReviewGpuMemory_mb,
                                                            .complete = false},
                                      render::GlContextKind::kCurrent)};
}

bool RenderedReview::Shows(int view_id) const {
  return shown_ && std::ranges::any_of(shown_->renderer->scene().views,
                                       [&](const render::SceneView& view) { return view.id == view_id; });
}

bool RenderedReview::is_loading() const {
  return !shown_ || shown_->renderer->loading() || !(shown_->of == wanted_);
}

std::optional<unsigned> RenderedReview::Draw(const CameraModel& camera, const Rigid3& cam_from_world) {
  try {
    TakeLoaded();
    const auto start = std::chrono::steady_clock::now();
    const cv::Size whole(camera.width, camera.height);
    const bool rests = drawn_from_ && drawn_from_->rotation.coeffs() == cam_from_world.rotation.coeffs() &&
                       drawn_from_->translation == cam_from_world.translation;
    drawn_from_ = cam_from_world;
    const cv::Size size = rests ? whole : size_.SizeFor(whole);
    const CameraModel drawn = camera.ScaledTo(size.width, size.height);
    const CameraModel wide = DistortedPicture::Undistorted(drawn);
    if (!TryNext(wide, cam_from_world)) {
      if (!shown_) return std::nullopt;
      shown_->renderer->Draw(wide, cam_from_world);
    }
    const unsigned picture = Show(drawn, wide);
    size_.AddFrame(1000 * SecondsSince(start), size, whole);
    return picture;
  } catch (const render::SurfaceGone&) {
    throw;
  } catch (const std::exception& error) {  // too little memory, for example: the display itself goes on
    shown_.reset();
    next_.reset();
    Fail(wanted_, error.what());
  }
  return std::nullopt;
}

// Now and then: whether the next scene has its photographs, and has been drawn and takes the place of the
// other.
bool RenderedReview::TryNext(const CameraModel& wide, const Rigid3& cam_from_world) {
  if (!next_ || (shown_ && now_s_ - tried_next_at_s_ < kReviewTryNext_s)) return false;
  tried_next_at_s_ = now_s_;
  next_->renderer->Draw(wide, cam_from_world);
  if (shown_ && next_->renderer->loading()) return false;
  shown_ = std::exchange(next_, std::nullopt);
  return true;
}

// Returns what was drawn last, as the camera sees it.
unsigned RenderedReview::Show(const CameraModel& camera, const CameraModel& wide) {
  if (!picture_) {
    distorted_ = std::make_unique<DistortedPicture>();
    picture_ = std::make_unique<render::GlTarget>(GL_RGBA8);
  }
  picture_->Resize(wide.width, wide.height);
  picture_->Bind();
  shown_->renderer->Show({.exposure_stops = 0, .hatches_doubt = hatches_doubt_});
  return distorted_->Draw(picture_->texture(), camera);
}

void RenderedReview::Fail(const Wanted& of, const std::string& problem) {
  failed_ = of;
  failed_at_s_ = now_s_;
  if (std::exchange(said_, problem) != problem) problem_ = "review: " + problem;
}

}  // namespace ulf::coverage
