#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/light_field/exchange/readers/json_entries.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMvgCentre = 0.5;  // of the first pixel in ours; openMVG's is at 0
constexpr double kUndefinedId = 4294967295;

// Returns what a pointer leads to (cereal's JSON).
JsonPlace PointedTo(const JsonPlace& entry) {
  return entry.Inside("value").Inside("ptr_wrapper").Inside("data");
}

CameraModel ModelOfMvgIntrinsic(const JsonPlace& place, const std::string& type) {
  const auto refuse = [&] {
    throw Error(
        "{}: a camera of the type '{}' is not supported; undistort the photographs "
        "(openMVG_main_ExportUndistortedImages) with their poses",
        place.where, type);
  };
  if (!type.starts_with("pinhole") && type != "fisheye") refuse();
  const double focal_px = place.Positive("focal_length");
  const std::vector<double> point = place.Numbers("principal_point", 2);
  CameraModel camera{.width = place.Integer("width"),
                     .height = place.Integer("height"),
                     .fx = focal_px,
                     .fy = focal_px,
                     .cx = point[0] + kMvgCentre,
                     .cy = point[1] + kMvgCentre};
  auto& c = camera.coefficients;
  if (type == "pinhole_radial_k1") {
    c[0] = place.Numbers("disto_k1", 1)[0];
  } else if (type == "pinhole_radial_k3") {
    const std::vector<double> k = place.Numbers("disto_k3", 3);
    c = {k[0], k[1], 0, 0, k[2]};
  } else if (type == "pinhole_brown_t2") {
    const std::vector<double> k = place.Numbers("disto_t2", 5);  // k1 k2 k3 t1 t2; these are OpenCV's p1 p2
    c = {k[0], k[1], k[3], k[4], k[2]};
  } else if (type == "fisheye") {
    const std::vector<double> k = place.Numbers("fisheye", 4);
    c = {k[0], k[1], k[2], k[3], 0};
    camera.distortion = Distortion::kFisheye;
  } else if (type != "pinhole") {
    refuse();
  }
  if (type != "fisheye" && c != std::array<double, 5>{}) camera.distortion = Distortion::kRadialTangential;
  camera.Validate(place.where);
  return camera;
}

// The file names a type once and then refers to it by its number.
class MvgTypes {
 public:
  std::string Of(const JsonPlace& value) {
    constexpr std::uint32_t kIsNamed = 0x80000000u;
    const auto id = static_cast<std::uint32_t>(std::clamp(value.Number("polymorphic_id"), 0.0, kUndefinedId));
    if (value.Has("polymorphic_name")) names_[id & ~kIsNamed] = value.Text("polymorphic_name");
    const auto found = names_.find(id & ~kIsNamed);
    if (found == names_.end())
      throw Error("{}: the type {} has no name; export the set again", value.where, id);
    return found->second;
  }

 private:
  std::map<std::uint32_t, std::string> names_;
};

Rigid3 MvgPose(const JsonPlace& place) {
  const json& rows = place.Raw("rotation");
  if (!rows.is_array() || rows.size() != 3) throw Error("{}: 'rotation' must be three rows", place.where);
  Eigen::Matrix3d rotation;
  for (Eigen::Index row = 0; row < 3; ++row) {
    const json object{{"row", rows[static_cast<std::size_t>(row)]}};
    const std::vector<double> numbers =
        JsonPlace{object, fmt::format("{}, rotation {}", place.where, row)}.Numbers("row", 3);
    rotation.row(row) = Eigen::RowVector3d(numbers[0], numbers[1], numbers[2]);
  }
  const std::vector<double> center = place.Numbers("center", 3);
  Rigid3 cam_from_world;
  cam_from_world.rotation = NearestRotation(rotation, place.where, "'rotation'");
  cam_from_world.translation = -(cam_from_world.rotation * Eigen::Vector3d(center[0], center[1], center[2]));
  return cam_from_world;
}

void ReadMvgPoints(const JsonPlace& top, const std::map<double, int>& view_ids, LightField& light_field) {
  std::size_t nowhere = 0;
  for (const JsonPlace& entry : EntriesOf(top, "structure")) {
    const JsonPlace value = entry.Inside("value");
    if (value.HoldsNotFinite("X")) {
      ++nowhere;
      continue;
    }
    const std::vector<double> position = value.Numbers("X", 3);
    ScenePoint& point = light_field.points.emplace_back();
    point.position_in_world = {position[0], position[1], position[2]};
    for (const JsonPlace& seen : EntriesOf(value, "observations")) {
      const auto view = view_ids.find(seen.Number("key"));
      if (view == view_ids.end()) continue;
      const std::vector<double> x = seen.Inside("value").Numbers("x", 2);
      AddObservation(view->second, {x[0] + kMvgCentre, x[1] + kMvgCentre}, point);
    }
  }
  NotePointsNowhere(nowhere, light_field);
  light_field.misplaced_observations = MeasurePoints(light_field);
}

}  // namespace

PosedSet ReadOpenMvgSet(const fs::path& file, const fs::path& chosen) {
  const json document = ParseJson(ReadWholeFile(file), file.string(), "export it again");
  const JsonPlace top{document, file.string()};
  PosedSet set;
  set.format = "openMVG";
  LightField& light_field = set.light_field;
  const std::vector<JsonPlace> views = EntriesOf(top, "views");
  const fs::path root = top.Text("root_path", "");
  std::vector<std::string> names;
  for (const JsonPlace& view : views) {
    const JsonPlace data = PointedTo(view);
    names.push_back((root / data.Text("local_path", "") / data.Text("filename")).generic_string());
  }
  std::map<double, Rigid3> poses;
  for (const JsonPlace& entry : EntriesOf(top, "extrinsics"))
    poses.emplace(entry.Number("key"), MvgPose(entry.Inside("value")));
  if (poses.empty())
    throw Error(
        "{}: 'extrinsics' is empty; take the sfm_data.json of the reconstruction "
        "(openMVG_main_ConvertSfM_DataFormat makes it of sfm_data.bin)",
        file.string());
  std::map<double, CameraModel> models;
  MvgTypes types;
  for (const JsonPlace& entry : EntriesOf(top, "intrinsics")) {
    const std::string type = types.Of(entry.Inside("value"));
    models.emplace(entry.Number("key"), ModelOfMvgIntrinsic(PointedTo(entry), type));
  }
  const fs::path base = fs::absolute(file).lexically_normal().parent_path();
  SetImages images(base, chosen, FoldersOfNames(base, names));
  images.Reserve(names);

  NamedViews named(file, images, set);
  std::map<double, int> view_ids;
  std::size_t unposed = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const JsonPlace data = PointedTo(views[i]);
    const std::string where = fmt::format("{} ({})", views[i].where, names[i]);
    const auto pose = poses.find(data.Number("id_pose", kUndefinedId));
    const double intrinsic = data.Number("id_intrinsic", kUndefinedId);
    if (pose == poses.end() || intrinsic == kUndefinedId) {
      ++unposed;
      continue;
    }
    const std::string path = named.Find(names[i], where);
    if (path.empty()) continue;
    const auto model = models.find(intrinsic);
    if (model == models.end())
      throw Error("{}: there are no intrinsics {}; export the set again", where, intrinsic);
    view_ids[data.Number("id_view")] = named.Add(path, model->second, pose->second, where);
  }
  named.RequireFound();
  if (light_field.views.empty())
    throw Error("{}: none of its {} views has a pose; take the sfm_data.json of the reconstruction",
                file.string(), views.size());
  NoteUnposed(unposed, "view", "without a pose", set);
  ReadMvgPoints(top, view_ids, light_field);
  return set;
}

}  // namespace ulf
