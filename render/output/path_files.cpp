#include "render/output/path_files.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/base/json_text.h"
#include "core/geometry/angles.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/exchange/poses_of_set.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"
#include "render/output/keyframes.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using nlohmann::json;

constexpr double kUnitTolerance = 1e-2;  // of a unit quaternion's length: rounding of short decimals

// Returns the focal length in pixels of a field of view over `size_px` pixels.
double FocalPx(double fov_deg, int size_px) { return 0.5 * size_px / std::tan(Radians(0.5 * fov_deg)); }

CameraPath FromTum(const fs::path& path) {
  if (!std::ifstream(path))
    throw Error(
        "{}: no such camera path; give orbit, dolly, vertigo, spiral, rise, sweep or walk, a TUM file, a "
        "light "
        "field, or a JSON file of keyframes",
        path.string());
  CameraPath result;
  for (const TimedPose& pose : ReadTum(path)) result.cam_from_world.push_back(pose.cam_from_world);
  return result;
}

CameraPath FromSet(const fs::path& path) {
  const SetPoses poses = ReadPosesOfSet(path);
  CameraPath result{.cam_from_world = poses.cam_from_world, .cameras = {}, .apertures = {}};
  for (const CameraModel& camera : poses.cameras) result.cameras.push_back(camera.WithoutDistortion());
  return result;
}

json ReadJson(const fs::path& file) {
  return ParseJson(ReadWholeFile(file), file.string(), "mend that place, or write the path again");
}

// ---- nerfstudio ----

Eigen::MatrixXd MatrixOf(const JsonPlace& place, const char* key, Eigen::Index rows) {
  std::vector<double> numbers;
  const auto collect = [&](const auto& self, const json& value) -> void {
    if (value.is_array()) {
      for (const json& entry : value) self(self, entry);
    } else if (value.is_number() && std::isfinite(value.get<double>())) {
      numbers.push_back(value.get<double>());
    } else {
      throw Error("{}: '{}' holds {}, which is not a finite number", place.where, key,
                  JsonText(value).substr(0, 40));
    }
  };
  collect(collect, place.Raw(key));
  if (static_cast<Eigen::Index>(numbers.size()) != 4 * rows)
    throw Error("{}: '{}' must hold {} numbers, row by row, not {}", place.where, key, 4 * rows,
                numbers.size());
  return Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>>(numbers.data(), rows, 4);
}

// nerfstudio trains in a world that is rotated, moved and scaled relative to that of the data set.
struct NerfstudioWorld {
  Rigid3 data_from_trained;  // after division by the scale
  double scale = 1;          // the length of one unit of the data set in the trained world

  Rigid3 CamFromWorld(const Rigid3& cam_from_trained) const {
    Rigid3 trained_from_cam = cam_from_trained.Inverse();
    trained_from_cam.translation /= scale;
    return (data_from_trained * trained_from_cam).Inverse();
  }
};

Rigid3 RigidOf(const Eigen::MatrixXd& rows, const JsonPlace& place, const char* key) {
  return {NearestRotation(rows.leftCols(3), place.where, fmt::format("'{}'", key)), rows.col(3).head(3)};
}

NerfstudioWorld WorldOf(const fs::path& file, const fs::path& light_field) {
  NerfstudioWorld world;
  const fs::path transforms = file.parent_path() / "dataparser_transforms.json";
  if (!fs::is_regular_file(transforms)) {
    spdlog::warn(
        "{}: its poses are used as poses in the light field's world. nerfstudio rotates and scales the world "
        "in which it trains: to undo that, put the run's dataparser_transforms.json beside the path",
        file.string());
    return world;
  }
  const json document = ReadJson(transforms);
  const JsonPlace place{document, transforms.string()};
  world.scale = place.Positive("scale");
  const Rigid3 trained_from_original = RigidOf(MatrixOf(place, "transform", 3), place, "transform");
  // "transform" starts from the world before ns-process-data changed the set; the set's poses are in the
  // changed world.
  Rigid3 data_from_original;
  const fs::path set = fs::is_directory(light_field) ? light_field / "transforms.json" : light_field;
  if (fs::is_regular_file(set)) {
    const json set_document = ReadJson(set);
    const JsonPlace set_place{set_document, set.string()};
    if (set_place.Has("applied_transform"))
      data_from_original =
          RigidOf(MatrixOf(set_place, "applied_transform", 3), set_place, "applied_transform");
    if (set_place.Has("applied_scale")) {
      const double applied = set_place.Positive("applied_scale");
      world.scale /= applied;
      data_from_original.translation *= applied;
    }
  }
  world.data_from_trained = data_from_original * trained_from_original.Inverse();
  return world;
}

CameraPath FromNerfstudio(const json& document, const fs::path& file, const PathRequest& request) {
  const JsonPlace top{document, file.string()};
  const std::string type = top.Text("camera_type", "perspective");
  if (type != "perspective")
    throw Error("{}: 'camera_type' is {}; only perspective can be rendered: export the path with that type",
                top.where, type);
  const int width = top.Integer("render_width"), height = top.Integer("render_height");
  if (width < 1 || height < 1)
    throw Error("{}: 'render_width' and 'render_height' must be positive, not {} and {}", top.where, width,
                height);
  if (top.Has("crop")) spdlog::warn("{}: 'crop' is not supported: the whole scene is rendered", top.where);
  const json& cameras = top.Raw("camera_path");
  if (!cameras.is_array()) throw Error("{}: 'camera_path' must be a list", top.where);
  const NerfstudioWorld world = WorldOf(file, request.light_field);
  CameraPath path;
  PoseRotations rotations;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const JsonPlace place{cameras[i], fmt::format("{}, camera_path {}", file.string(), i)};
    const Eigen::Matrix4d matrix = MatrixOf(place, "camera_to_world", 4);
    path.cam_from_world.push_back(
        world.CamFromWorld(CamFromOpenGl(matrix, place.where, "camera_to_world", rotations)));
    const double fov_deg = place.Number("fov");
    if (!(fov_deg > 0 && fov_deg < 180))
      throw Error("{}: 'fov' must lie between 0 and 180 degrees, not {}", place.where, fov_deg);
    path.cameras.push_back(CameraModel::Pinhole(width, height, FocalPx(fov_deg, height)));
  }
  std::vector<std::string> doubts;
  rotations.Tell(file.string(), doubts);
  for (const std::string& doubt : doubts) spdlog::warn("{}", doubt);
  return path;
}

// ---- Keyframes ----

PathKeyframe KeyframeOf(const JsonPlace& place, const CameraModel& camera, const Vector3d& up_in_world) {
  place.RequireOnly({"time", "eye", "target", "up", "rotation", "fov_deg", "focal_px", "aperture", "focus"});
  PathKeyframe key;
  key.time_s = place.Number("time");
  key.eye_in_world = Vector3FromJson(place, "eye");
  key.up_in_world = place.Has("up") ? Vector3FromJson(place, "up") : up_in_world;
  if (!(key.up_in_world.norm() > 0)) throw Error("{}: 'up' has no length", place.where);
  if (place.Has("target") == place.Has("rotation"))
    throw Error("{}: give either 'target' (a point to look at) or 'rotation' (qx qy qz qw)", place.where);
  if (place.Has("target")) {
    key.target_in_world = Vector3FromJson(place, "target");
    if (!((*key.target_in_world - key.eye_in_world).norm() > 0))
      throw Error("{}: 'eye' and 'target' are the same point; move one of them", place.where);
    const Vector3d forward = (*key.target_in_world - key.eye_in_world).normalized();
    constexpr double kLeastSine = 1e-6;
    if (place.Has("up") && !(forward.cross(key.up_in_world.normalized()).norm() > kLeastSine))
      throw Error("{}: 'up' points along the view, from 'eye' to 'target'; give another one", place.where);
  } else {
    const std::vector<double> q = place.Numbers("rotation", 4);
    key.world_from_cam = Quaterniond(q[3], q[0], q[1], q[2]);
    if (!(std::abs(key.world_from_cam.norm() - 1) < kUnitTolerance))
      throw Error("{}: 'rotation' must be a unit quaternion qx qy qz qw, not of length {:.3g}", place.where,
                  key.world_from_cam.norm());
  }
  key.focal_px = camera.fx;
  if (place.Has("focal_px") && place.Has("fov_deg"))
    throw Error("{}: give either 'focal_px' or 'fov_deg'", place.where);
  if (place.Has("focal_px")) key.focal_px = place.Positive("focal_px");
  if (place.Has("fov_deg")) {
    const double fov_deg = place.Number("fov_deg");
    if (!(fov_deg > 0 && fov_deg < 180))
      throw Error("{}: 'fov_deg' must lie between 0 and 180, not {}", place.where, fov_deg);
    key.focal_px = FocalPx(fov_deg, camera.width);
  }
  return key;
}

// Without "focus" the lens is focused on the target, or else on the subject's centre.
void ReadAperture(const JsonPlace& place, const Vector3d& subject_center, PathKeyframe& key) {
  key.aperture_radius = place.Number("aperture");
  if (!(key.aperture_radius >= 0))
    throw Error("{}: 'aperture' is a radius, 0 or more, not {}", place.where, key.aperture_radius);
  if (place.Has("focus")) {
    key.focus_depth = place.Positive("focus");
    return;
  }
  const Rigid3 cam_from_world = key.target_in_world
                                    ? LookAt(key.eye_in_world, *key.target_in_world, key.up_in_world)
                                    : Rigid3{key.world_from_cam.normalized(), key.eye_in_world}.Inverse();
  key.focus_depth =
      FocusDepth({.focus_in_world = key.target_in_world.value_or(subject_center)}, cam_from_world);
}

CameraPath FromKeyframes(const json& document, const fs::path& file, const PathRequest& request,
                         const RenderScene& scene) {
  const JsonPlace top{document, file.string()};
  CameraModel camera = request.camera;
  if (top.Has("width") || top.Has("height")) {
    const int width = top.Integer("width"), height = top.Integer("height");
    if (width < 1 || height < 1)
      throw Error("{}: 'width' and 'height' must be positive, not {} and {}", top.where, width, height);
    camera = CameraModel::Pinhole(width, height, camera.fx * width / camera.width);
  }
  top.RequireOnly({"width", "height", "keyframes"});
  const json& entries = top.Raw("keyframes");
  if (!entries.is_array()) throw Error("{}: 'keyframes' must be a list", top.where);
  std::vector<PathKeyframe> keyframes;
  const bool with_apertures = !entries.empty() && entries[0].contains("aperture");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const JsonPlace place{entries[i], fmt::format("{}, keyframe {}", file.string(), i)};
    if (place.Has("focal_px") && !top.Has("width"))
      throw Error(
          "{}: 'focal_px' counts pixels of a picture: give 'width' and 'height' at the top, or 'fov_deg'",
          place.where);
    keyframes.push_back(KeyframeOf(place, camera, scene.up_in_world));
    if (place.Has("aperture") != with_apertures)
      throw Error("{}: either all keyframes have an 'aperture', or none", place.where);
    if (with_apertures) ReadAperture(place, scene.subject.center_in_world, keyframes.back());
    if (!with_apertures && place.Has("focus"))
      throw Error("{}: 'focus' needs an 'aperture': without one everything is in focus", place.where);
    if (i > 0 && !(keyframes[i].time_s > keyframes[i - 1].time_s))
      throw Error("{}: 'time' must be later than the keyframe before ({} s), not {}", place.where,
                  keyframes[i - 1].time_s, keyframes[i].time_s);
  }
  CameraPath path;
  if (keyframes.empty()) return path;
  constexpr double kMostFrames = 1e6;  // more mean that times have the wrong unit
  const double spanned = std::round((keyframes.back().time_s - keyframes.front().time_s) * request.fps) + 1;
  if (request.frames == 0 && spanned > kMostFrames)
    throw Error("{}: the keyframes' times come to {:.0f} pictures at {} a second; 'time' is in seconds",
                file.string(), spanned, request.fps);
  std::vector<KeyframedPose> poses;
  try {
    poses = InterpolateKeyframes(keyframes, request.frames > 0 ? request.frames : static_cast<int>(spanned));
  } catch (const Error& error) {
    throw Error("{}: {}", file.string(), error.what());
  }
  for (const KeyframedPose& pose : poses) {
    path.cam_from_world.push_back(pose.cam_from_world);
    CameraModel& zoomed = path.cameras.emplace_back(camera);
    zoomed.fx = pose.focal_px;
    zoomed.fy = pose.focal_px * camera.fy / camera.fx;
    if (with_apertures)
      path.apertures.push_back(
          {.radius = pose.aperture_radius,
           .focus_in_world = pose.cam_from_world.Inverse() * Vector3d(pose.focus_depth * Vector3d::UnitZ())});
  }
  return path;
}

// Returns whether it is a set's folder or file. JSON that is nobody's else may be a path, too.
bool IsSet(const fs::path& path) {
  if (std::error_code unknown; fs::is_directory(path, unknown)) return true;
  const std::vector<SetFormat> formats = FormatsIn(path);
  return !formats.empty() && formats.front() != SetFormat::kTransforms;
}

}  // namespace

CameraPath PathFromFile(const fs::path& file, const PathRequest& request, const RenderScene& scene) {
  const auto read = [&] {
    std::error_code unknown;
    if (IsSet(file)) return FromSet(file);
    if (file.extension() != ".json" || !fs::is_regular_file(file, unknown)) return FromTum(file);
    const json document = ReadJson(file);
    if (document.contains("camera_path")) return FromNerfstudio(document, file, request);
    if (document.contains("keyframes")) return FromKeyframes(document, file, request, scene);
    if (document.contains("frames")) return FromSet(file);
    throw Error(
        "{}: holds neither 'keyframes' nor 'camera_path' (nerfstudio's camera path) nor 'frames' "
        "(transforms.json); see docs/rendering.md",
        file.string());
  };
  CameraPath path = read();
  if (path.cam_from_world.empty()) throw Error("{}: the camera path holds no pose", file.string());
  return path;
}

CameraPath MakePath(const PathRequest& request, const RenderScene& scene) {
  constexpr int kUsualFrames = 120;
  const int frames = request.frames > 0 ? request.frames : kUsualFrames;
  if (request.path == "orbit") return OrbitPath(scene, frames);
  if (request.path == "dolly") return DollyPath(scene, frames);
  if (request.path == "vertigo") return VertigoPath(scene, frames, request.camera);
  if (request.path == "spiral") return SpiralPath(scene, frames);
  if (request.path == "rise") return RisePath(scene, frames);
  if (request.path == "sweep") return SweepPath(scene, frames);
  if (request.path == "walk") return WalkPath(scene, frames);
  return PathFromFile(request.path, request, scene);
}

}  // namespace ulf::render
