#include "render/quality/evened_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/counted.h"
#include "core/light_field/folder/view_images.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/light_fit.h"
#include "render/scene/even_picture.h"
#include "render/scene/exposure_scales.h"

namespace ulf::render {
namespace {

std::string CorrectionsInWords(const LightField& light_field) {
  std::string words;
  if (!light_field.flat_fields.empty()) words += ", divided by the flat field";
  if (!light_field.color_profiles.empty()) words += ", in sRGB by the colour profile";
  return words;
}

// Only its triangles count.
Subject SubjectForFit(const LightField& light_field) {
  if (light_field.subject) return *light_field.subject;
  if (const auto found = SubjectFromAxes(light_field)) return *found;
  return {Eigen::Vector3d::Zero(), 1};
}

}  // namespace

EvenedLight::EvenedLight(const LightField& light_field) : light_field_(light_field) {
  const ExposureScales exposures = ScalesOf(light_field);
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    const View& view = light_field.views[i];
    SceneView& even = views_[view.id];
    even.camera = light_field.CameraOf(view);
    even.black = static_cast<float>(view.black_level);
    even.scale = exposures.scales[i];
  }
  unmatched_ = exposures.unmatched;
  const auto [least, most] = std::ranges::minmax_element(exposures.scales);
  if (exposures.scales.empty()) return;
  most_scale_ = *most;
  words_ = fmt::format("light: exposures of {:.1f} stops brought to the median", std::log2(*most / *least));
  if (!KnowsExposures(light_field)) FitOnMesh();
  words_ += CorrectionsInWords(light_field);
}

void EvenedLight::FitOnMesh() {
  words_ =
      "light: no exposure is known, and there is no mesh on which photographs can be compared, so their "
      "brightness stays; make one with: " +
      ProxyCommand(light_field_.root);
  if (!std::filesystem::exists(light_field_.root / kMeshProxyFile)) return;
  const Subject subject = SubjectForFit(light_field_);
  const auto scene = LoadScene(light_field_, {.subject = subject});
  const auto on_mesh = WithProxy(*scene, ProxyFromName("mesh", subject, light_field_.root));
  const LightFit fit = FitLight(*on_mesh);
  const auto evened = WithLight(*on_mesh, fit);
  for (const SceneView& fitted : evened->views) {
    SceneView& even = views_.at(fitted.id);
    even.correction = fitted.correction;
    most_scale_ = std::max(most_scale_, 1 / *std::ranges::min_element(fitted.correction.gain.val));
  }
  words_ = fit.Words();
}

cv::Mat EvenedLight::Of(const View& view) const {
  cv::Mat clipped;
  cv::Mat light = LinearFloat(ReadViewLight(light_field_, view, &clipped));
  const SceneView& even = views_.at(view.id);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      cv::Vec3f& pixel = light.at<cv::Vec3f>(y, x);
      pixel = OnCommonScale(even, pixel, {x + 0.5, y + 0.5});
    }
  pixels_ += light.total();
  const float scale = even.scale / *std::ranges::max_element(even.correction.gain.val);
  if (!clipped.empty() && most_scale_ > kMostExposureRatio * scale)
    full_ += static_cast<std::size_t>(cv::countNonZero(clipped));
  return light;
}

std::vector<std::string> EvenedLight::Words() const {
  std::vector<std::string> sentences{words_};
  if (!unmatched_.empty())
    sentences.push_back(
        fmt::format("the exposure of {} (the first is {}) is not known and cannot be "
                    "estimated: taken for the median",
                    Counted(unmatched_.size(), "view"), unmatched_.front()));
  const double share = static_cast<double>(full_) / static_cast<double>(std::max<std::size_t>(pixels_, 1));
  constexpr double kWorthSaying = 1e-4;
  if (share > kWorthSaying)
    sentences.push_back(
        fmt::format("{:.2g} % of the pixels were overexposed in photographs brighter than "
                    "others, and are too dark in even light",
                    100 * share));
  return sentences;
}

}  // namespace ulf::render
