#include "render/viewer/viewer_files.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/base/json_text.h"
#include "core/geometry/angles.h"
#include "core/geometry/camera_json.h"
#include "core/image/files/picture_file.h"

namespace ulf::render {
namespace {

using nlohmann::json;

json ReadKeyframes(const std::filesystem::path& file) {
  json document =
      ParseJson(ReadWholeFile(file), file.string(),
                "no keyframe is added to it: mend it, move it away, or give another folder with " +
                    Parameter("output"));
  if (!document.is_object() || !document.contains("keyframes") || !document["keyframes"].is_array())
    throw Error("{}: holds no list of keyframes; move it away or give another folder with {}", file.string(),
                Parameter("output"));
  return document;
}

}  // namespace

std::size_t AppendKeyframe(const std::filesystem::path& file, const ViewerCamera& camera,
                           const cv::Size& screen, const std::optional<Aperture>& aperture) {
  json document{{"width", screen.width}, {"height", screen.height}, {"keyframes", json::array()}};
  if (std::filesystem::exists(file)) document = ReadKeyframes(file);
  json& keyframes = document["keyframes"];
  double time_s = 0;
  if (!keyframes.empty())
    time_s =
        JsonPlace{keyframes.back(), file.string() + ", the last keyframe"}.Number("time") + kKeyframeSeconds;
  const double fov_rad = 2 * std::atan(0.5 * screen.width / camera.ModelFor(screen).fx);
  const bool has_apertures = keyframes.empty() ? aperture.has_value() : keyframes[0].contains("aperture");
  if (aperture && !has_apertures)
    throw Error("{}: its keyframes have no aperture; close it (X), or move the file away", file.string());
  json keyframe{{"time", time_s},
                {"eye", Vector3ToJson(camera.eye_in_world)},
                {"target", Vector3ToJson(camera.target_in_world)},
                {"up", Vector3ToJson(camera.up_in_world)},
                {"fov_deg", Degrees(fov_rad)}};
  if (has_apertures) {
    const Aperture closed{.radius = 0, .focus_in_world = camera.target_in_world};
    keyframe["aperture"] = aperture.value_or(closed).radius;
    keyframe["focus"] = FocusDepth(aperture.value_or(closed), camera.CamFromWorld());
  }
  keyframes.push_back(std::move(keyframe));
  WriteFileAtomically(file, JsonText(document, 1) + "\n");
  return keyframes.size();
}

std::filesystem::path SaveNumbered(const std::filesystem::path& folder, const cv::Mat& srgb8) {
  std::filesystem::path file;
  for (int n = 0; file.empty() || std::filesystem::exists(file); ++n)
    file = folder / fmt::format("ulf_view_{:03}.png", n);
  WritePictureFile(file.string(), srgb8);
  return file;
}

}  // namespace ulf::render
