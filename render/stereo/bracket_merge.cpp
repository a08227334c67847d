#include "render/stereo/bracket_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/geometry/pinhole.h"
#include "core/image/exposure_alignment.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "render/proxy/proxy_choice.h"
#include "render/scene/scene.h"

namespace ulf::render {
namespace {

constexpr double kTrustedRatio = 0.02;      // a smaller contradiction by the pictures is ignored. Guessed
constexpr double kMostContradiction = 0.5;  // stops. Guessed
// Assumed misalignment of an aligned exposure: tracked poses are right to 0.02 to 0.16 px (sim:lightbox,
// 5x2EV); the rest is geometry. Settled on seed 1 of sim:lightbox and sim:branch.
constexpr double kMisalignedPx = 0.2;

constexpr double kBlurAtEdges =
    0.25;  // uniform blur moves light at an edge by a quarter of its length, on average

// A developed raw file has passed a colour matrix, and so have most display-encoded pictures.
bool MixesColors(const View& photograph) {
  const std::filesystem::path path =
      photograph.master_path.empty() ? photograph.image_path : photograph.master_path;
  return IsRawFile(path) || photograph.master_transfer.value_or(TransferOfFile(path)) == Transfer::kSrgb;
}

// Returns the view's own first.
std::vector<ExposedLight> LightsOf(const LightField& light_field, const std::vector<View>& photographs) {
  std::vector<SensorPicture> pictures;
  for (const View& each : photographs)
    pictures.push_back({.image = ReadViewMaster(light_field, each),
                        .black_level = each.black_level,
                        .gain = each.gain,
                        .mixes_colors = MixesColors(each)});
  return ExposedLightsOf(pictures);
}

// Returns the ratio of the sensor's light for the same scene to the reference's.
double ToldRatio(const View& photograph, const View& reference) {
  double ratio = photograph.exposure_s * photograph.gain / (reference.exposure_s * reference.gain);
  if (photograph.f_number && reference.f_number)
    ratio *= std::pow(*reference.f_number / *photograph.f_number, 2);
  return ratio;
}

// Returns the length of the subject's path in the picture during the exposure: of a photograph in order of
// time, by the poses before and after it. Poses are from_view. It is 0 if times are unknown.
double BlurPx(const std::vector<View>& photographs, std::size_t index, const CameraModel& camera,
              const cv::Mat& depth) {
  const View& exposed = photographs[index];
  const View *before = &exposed, *after = &exposed;
  for (const View& each : photographs) {
    const double off_s = each.device_time_s - exposed.device_time_s;
    if (off_s < 0 && (before == &exposed || each.device_time_s > before->device_time_s)) before = &each;
    if (off_s > 0 && (after == &exposed || each.device_time_s < after->device_time_s)) after = &each;
  }
  const double between_s = after->device_time_s - before->device_time_s;
  if (!(between_s > 0)) return 0;
  const Rigid3 view_from_world = photographs.front().cam_from_world;
  const Rigid3 before_from_view = before->cam_from_world * view_from_world.Inverse(),
               after_from_view = after->cam_from_world * view_from_world.Inverse();
  std::vector<double> paths;
  constexpr int kGrid = 5;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const int x = (2 * (i % kGrid) + 1) * camera.width / (2 * kGrid),
              y = (2 * (i / kGrid) + 1) * camera.height / (2 * kGrid);
    const auto ray = camera.RayFromImg({x + 0.5, y + 0.5});
    if (!ray) continue;
    const Eigen::Vector3d point = depth.at<float>(y, x) * (*ray / ray->z());
    const auto from = camera.ImgFromCam(before_from_view * point),
               to = camera.ImgFromCam(after_from_view * point);
    if (from && to) paths.push_back((*to - *from).norm());
  }
  return Median(paths) * exposed.exposure_s / between_s;
}

cv::Mat OneWhere(const cv::Mat& mask) {
  cv::Mat ones;
  mask.convertTo(ones, CV_32F, 1.0 / 255);
  return HalfFromFloat(ones);
}

}  // namespace

std::shared_ptr<const Proxy> ProxyForBrackets(const LightField& light_field) {
  const Subject subject = SubjectOf(light_field);
  const std::vector<std::string> own = OwnProxies(light_field.root);
  return own.empty() ? std::make_shared<PlaneProxy>(subject)
                     : OwnProxy(own.back(), subject, light_field.root);
}

cv::Mat DepthOfView(const LightField& light_field, const View& view, const Proxy& proxy) {
  const CameraModel& camera = light_field.CameraOf(view);
  const CameraModel undistorted = camera.WithoutDistortion();
  cv::Mat depth = proxy.Depth(undistorted, view.cam_from_world);
  if (const auto lazy = proxy.DepthMapOf(view.id, camera, view.cam_from_world)) {
    const ViewDepthMap& map = lazy->Get();
    for (int y = 0; y < depth.rows; ++y)
      for (int x = 0; x < depth.cols; ++x) {
        const auto at = map.camera.ImgFromCam(PinholeRay(undistorted, x, y));
        if (!at || !map.camera.Contains(*at)) continue;
        const double inverse = map.InverseDepthAt(static_cast<int>(at->x()), static_cast<int>(at->y()));
        if (inverse > 0) depth.at<float>(y, x) = static_cast<float>(1 / inverse);
      }
  }
  return DepthInPicture(camera, undistorted, depth);
}

MergedView MergeExposuresOf(const LightField& light_field, const View& view, const Proxy& proxy,
                            const BracketMergeOptions& options) {
  if (!(view.exposure_s > 0))
    throw Refusal(
        light_field.root.string(), "",
        fmt::format("the exposure time of view {} is not known, and its exposures cannot be merged", view.id),
        "");
  const CameraModel& camera = light_field.CameraOf(view);
  MergedView result;
  std::vector<View> photographs{view};
  for (const ViewExposure& each : view.exposures) photographs.push_back(PhotographOf(view, each));
  const std::vector<ExposedLight> lights = LightsOf(light_field, photographs);
  std::vector<AlignedExposure> exposures{WithoutAlignment(lights.front(), 1)};
  const cv::Mat depth = options.align ? DepthOfView(light_field, view, proxy) : cv::Mat();
  for (std::size_t i = 1; i < photographs.size(); ++i) {
    const ViewExposure& each = view.exposures[i - 1];
    const double told = ToldRatio(photographs[i], view);
    AlignedExposure aligned = options.align
                                  ? AlignExposure(lights[i], camera, depth, each.exposure_from_view, told)
                                  : WithoutAlignment(lights[i], told);
    const double measured = MeasuredRatio(aligned, exposures.front());
    if (measured > 0 && std::abs(std::log2(measured / told)) > kMostContradiction) {
      result.left_out.push_back(fmt::format(
          "view {}: its exposure of {:g} s has {:.2f} times the light that its time tells; it is left out",
          view.id, each.exposure_s, measured / told));
      continue;
    }
    if (measured > 0 && std::abs(measured / told - 1) > kTrustedRatio) aligned.ratio = measured;
    if (options.align) {
      const double blur_px = BlurPx(photographs, i, camera, depth);
      aligned.misaligned_px = std::hypot(kMisalignedPx, kBlurAtEdges * blur_px);
      result.most_blur_px = std::max(result.most_blur_px, blur_px);
    }
    result.shortest = std::min(result.shortest, aligned.ratio);
    result.longest = std::max(result.longest, aligned.ratio);
    exposures.push_back(std::move(aligned));
  }
  result.exposures = static_cast<int>(exposures.size());
  result.merged = MergeExposures(exposures);
  return result;
}

std::string MergedExr(const View& view, const MergedView& merged) {
  const cv::Mat& light = merged.merged.light;
  const cv::Mat clipped = OneWhere(merged.merged.clipped), ghosts = OneWhere(merged.merged.ghosts);
  return ExrBytes(
      {{"R", light, 2},
       {"G", light, 1},
       {"B", light, 0},
       {kClippedChannel, clipped},
       {kGhostsChannel, ghosts}},
      ExrCompression::kZip, HasRec709Colors(view) ? ExrColors(kRec709) : std::nullopt,
      {{"ulfOne", fmt::format("full scale of {:g} s at a gain of {:g}", view.exposure_s, view.gain)},
       {"ulfExposures", fmt::format("{} from {:.4g} to {:.4g} times that", merged.exposures, merged.shortest,
                                    merged.longest)},
       {"ulfGhosts", fmt::format("{:.4f} of the pixels", merged.merged.ghost_share)}});
}

BracketReport MergeBrackets(const std::filesystem::path& dir) {
  BracketReport report;
  // Checked before the writer reads every photograph.
  if (std::ranges::all_of(ReadLightField(dir).views, [](const View& view) { return view.exposures.empty(); }))
    return report;
  LightFieldWriter writer = LightFieldWriter::Resume(dir);
  const LightField light_field = writer.Contents();
  std::vector<View> views;
  for (const View& view : light_field.views)
    if (!view.exposures.empty()) views.push_back(view);
  if (views.empty()) return report;
  const auto proxy = ProxyForBrackets(light_field);
  report.geometry = proxy->Name();
  Progress progress("merge");
  std::vector<double> ghosts;
  for (std::size_t i = 0; i < views.size(); ++i) {
    progress.Show(static_cast<double>(i) / static_cast<double>(views.size()));
    const MergedView merged = MergeExposuresOf(light_field, views[i], *proxy);
    for (const std::string& words : merged.left_out) progress.Say(words);
    report.left_out += merged.left_out.size();
    if (merged.exposures < 2) continue;
    const double share = merged.merged.ghost_share;
    writer.SetMerged(views[i].id, MergedExr(views[i], merged), merged.exposures, share);
    ++report.views;
    report.exposures += static_cast<std::size_t>(merged.exposures);
    report.stops = std::max(report.stops, std::log2(merged.longest / merged.shortest));
    report.clipped_most =
        std::max(report.clipped_most, cv::countNonZero(merged.merged.clipped) /
                                          static_cast<double>(merged.merged.clipped.total()));
    if (merged.most_blur_px > report.blur_most_px) report.blur_most_view = views[i].id;
    report.blur_most_px = std::max(report.blur_most_px, merged.most_blur_px);
    if (ghosts.empty() || share > report.ghosts_most) report.ghosts_most_view = views[i].id;
    report.ghosts_most = std::max(report.ghosts_most, share);
    ghosts.push_back(share);
  }
  if (!ghosts.empty()) report.ghosts_median = Median(ghosts);
  writer.Close(light_field.capture_s, light_field.reasons);
  return report;
}

}  // namespace ulf::render
