#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "commands/light_field/contact_sheet.h"
#include "commands/options/subcommands.h"
#include "commands/reports/light_field_report.h"
#include "core/base/counted.h"
#include "core/base/output_path.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/operator/coverage_drawing.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/output/camera_path.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/evaluate.h"
#include "render/renderer/renderer.h"

namespace ulf::commands {
namespace {

struct SheetArgs {
  std::string dir;
  std::string live;
  std::string cap;
  std::string subject;
  std::string out = "contact_sheet.png";
};

// Loads the light field with the best proxy of its own.
std::shared_ptr<const render::RenderScene> SceneOf(const LightField& light_field,
                                                   const std::optional<Subject>& subject) {
  const auto scene = render::LoadScene(light_field, {.subject = subject});
  const std::string best = render::DefaultProxies(light_field.root).front();
  return render::WithProxy(*scene, render::OwnProxy(best, scene->subject, light_field.root));
}

// Returns the view nearest to the middle of all directions: its neighbours surround it, so leaving it out is
// fair.
int MiddleView(const render::RenderScene& scene) {
  const Eigen::Vector3d& center = scene.subject.center_in_world;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const render::SceneView& view : scene.views) middle += (view.center_in_world - center).normalized();
  const auto closeness = [&](const render::SceneView& view) {
    return (view.center_in_world - center).normalized().dot(middle);
  };
  return static_cast<int>(std::ranges::max_element(scene.views, {}, closeness) - scene.views.begin());
}

// Returns the subject with a margin, half as high again as wide so that two of it fill a panel.
cv::Rect AroundSubject(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject) {
  const Eigen::Vector3d center_in_cam = cam_from_world * subject.center_in_world;
  const auto img = camera.ImgFromCam(center_in_cam);
  if (!img) return {0, 0, camera.width, camera.height};
  constexpr double kMargin = 1.2, kHeight = 1.5, kLeastWidth = 0.1;
  const double half =
      std::max(kMargin * camera.fx * subject.radius / center_in_cam.norm(), kLeastWidth * camera.width);
  const cv::Rect around(
      cv::Point(static_cast<int>(img->x() - half), static_cast<int>(img->y() - kHeight * half)),
      cv::Point(static_cast<int>(img->x() + half), static_cast<int>(img->y() + kHeight * half)));
  return around & cv::Rect(0, 0, camera.width, camera.height);
}

SheetPanel RenderingBesideTruth(const render::RenderScene& scene) {
  if (scene.views.size() < 2)
    return {scene.views.front().Srgb8(), "only one view: none can be left out and compared"};
  const int left_out = MiddleView(scene);
  const render::SceneView& view = scene.views[static_cast<std::size_t>(left_out)];
  const CameraModel camera = view.camera.WithoutDistortion();
  const auto renderer =
      render::MakeRenderer(render::Without(scene, {left_out}), {.field = render::DefaultField(scene)});
  const cv::Mat rendered = Srgb8FromLinear(renderer->Render(camera, view.cam_from_world).linear);
  const render::UndistortedPhotograph photograph = render::Undistort(view);
  const render::Quality quality = render::CompareImages(rendered, photograph.srgb8, photograph.valid);
  const cv::Rect shown = AroundSubject(camera, view.cam_from_world, scene.subject);
  cv::Mat pair;
  const cv::Mat gap(shown.height, 6, CV_8UC3, cv::Scalar::all(255));
  cv::hconcat(std::vector<cv::Mat>{rendered(shown), gap, photograph.srgb8(shown)}, pair);
  return {pair,
          fmt::format("rendered without view {} ({}) | its photograph ({:.1f} dB, SSIM {:.3f}, full frame)",
                      view.id, scene.proxy->Name(), quality.psnr_db, quality.ssim)};
}

// Renders from half the distance, where a picture consists of many views (thesis, figure 5-1).
SheetPanel BlendingField(const std::shared_ptr<const render::RenderScene>& scene) {
  const render::RenderOptions options{.field = render::DefaultField(*scene), .show_field = true};
  const auto renderer = render::MakeRenderer(scene, options);
  const Rigid3 moved_in = render::DollyPath(*scene, 2).cam_from_world.back();
  const CameraModel camera = scene->views.front().camera.WithoutDistortion();
  return {Srgb8FromLinear(renderer->Render(camera, moved_in).linear),
          fmt::format("blending field from half the distance, a colour for each view ({})",
                      render::FieldName(renderer->field().kind))};
}

std::string Headline(const LightField& light_field, const LightFieldReport& report) {
  std::string text = light_field.root.filename().string() + ": " + Counted(report.views, "view");
  if (report.capture_s > 0) text += fmt::format(" in {:.0f} s", report.capture_s);
  if (report.angular_range_deg)
    text += fmt::format(", {:.0f} x {:.0f} degrees", report.angular_range_deg->x(),
                        report.angular_range_deg->y());
  if (report.mean_edge_deg) text += fmt::format(", {:.2f} degrees apart", *report.mean_edge_deg);
  if (report.covered)
    text += fmt::format(", {:.1f} % of {:g} x {:g} covered within {:g} px", 100 * *report.covered,
                        report.cap->Degrees().x(), report.cap->Degrees().y(), report.threshold_px);
  return text;
}

// It is little wider than its cell, so that its text stays readable.
constexpr int kMapWidth_px = 800;

int RunSheet(const SheetArgs& args) {
  RequireWritablePicture(args.out);
  const LightField light_field = ReadLightField(args.dir);
  ReportOptions asked;
  if (!args.cap.empty()) asked.cap = coverage::Cap::ParseDegrees(args.cap);
  if (!args.subject.empty()) asked.subject = ParseSubject(args.subject);
  const auto scene = SceneOf(light_field, asked.subject);
  const LightFieldReport report = Describe(light_field, asked);
  const coverage::CoverageMap map =
      coverage::CoverageOf(light_field, scene->subject, report.cap, report.threshold_px);

  std::vector<SheetPanel> panels;
  if (!args.live.empty()) panels.push_back({ReadImageFile(args.live), "live frame with the painted sphere"});
  panels.push_back({coverage::DrawCoverageMap(map, {.width = kMapWidth_px}), "coverage map"});
  panels.push_back(BlendingField(scene));
  panels.push_back(RenderingBesideTruth(*scene));
  const cv::Mat sheet = ComposeSheet(Headline(light_field, report), panels);
  WritePictureFile(args.out, sheet);
  fmt::print("{}\n", args.out);
  return kOk;
}

}  // namespace

void AddSheetCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "sheet",
      "One picture of a light field: coverage map, blending field, rendering beside a photograph", RunSheet);
  command->add_option("DIR", args->dir, "Light field")->required();
  command->add_option("--live", args->live,
                      "Picture of 'ulf capture --overlay' for the first panel (default: none)");
  command->add_option(
      "--cap", args->cap,
      "Cap to show, AZIMUTHxELEVATION in degrees such as 60x40 (default: the goal of the capture)");
  command->add_option("--subject", args->subject,
                      "Subject: x,y,z,radius in world units (default: the light field's)");
  command->add_option("-o,--output", args->out, "Picture to write")->capture_default_str();
  command->footer("Example: ulf sheet light_field --cap 60x40 -o contact_sheet.png");
}

}  // namespace ulf::commands
