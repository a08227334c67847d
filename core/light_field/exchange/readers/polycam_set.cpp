#include <fmt/format.h>

#include <algorithm>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/set_format.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

Rigid3 ScannedPose(const JsonPlace& camera) {
  Eigen::Matrix<double, 3, 4> world_from_cam;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      world_from_cam(row, column) = camera.Number(fmt::format("t_{}{}", row, column).c_str());
  const Eigen::DiagonalMatrix<double, 3> opengl_from_ours(1, -1, -1);
  return Rigid3{
      NearestRotation(world_from_cam.leftCols<3>() * opengl_from_ours, camera.where, "t_00 to t_22"),
      world_from_cam.col(3)}
      .Inverse();
}

CameraModel ScannedCamera(const JsonPlace& camera) {
  return {.width = camera.Integer("width"),
          .height = camera.Integer("height"),
          .fx = camera.Positive("fx"),
          .fy = camera.Positive("fy"),
          .cx = camera.Number("cx"),
          .cy = camera.Number("cy")};
}

}  // namespace

PosedSet ReadPolycamSet(const fs::path& cameras, const fs::path& chosen) {
  const bool corrected = cameras.filename() == kPolycamCorrected;
  const fs::path keyframes = fs::absolute(cameras).lexically_normal().parent_path();
  std::vector<std::string> names;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(cameras, unknown))
    if (Lowercase(entry.path().extension().string()) == ".json" && entry.is_regular_file(unknown))
      names.push_back(entry.path().filename().string());
  if (names.empty()) throw Error("{}: holds no camera (.json); export the raw data again", cameras.string());
  std::ranges::sort(names, NameOrder);

  PosedSet set;
  set.format = "Polycam";
  LightField& light_field = set.light_field;
  light_field.units = "metres";
  light_field.up_in_world = Eigen::Vector3d::UnitY();
  const SetImages images(keyframes, chosen, {corrected ? "corrected_images" : "images"});
  NamedViews named(cameras, images, set);
  for (const std::string& name : names) {
    const std::string where = (cameras / name).string();
    const nlohmann::json document =
        ParseJson(ReadWholeFile(cameras / name), where, "export the raw data again");
    const JsonPlace camera{document, where};
    const std::string path = named.Find(fs::path(name).stem().string(), where);
    if (!path.empty()) named.Add(path, ScannedCamera(camera), ScannedPose(camera), where);
  }
  named.RequireFound();
  if (!corrected)
    light_field.doubts.push_back(fmt::format(
        "{}: there are no corrected_cameras: poses are ARKit's, as measured during the scan, and the "
        "photographs' distortion is not known ('ulf refine' improves the poses)",
        keyframes.string()));
  if (fs::is_directory(keyframes / "depth", unknown))
    light_field.doubts.push_back(fmt::format("{}: depth maps are not used", (keyframes / "depth").string()));
  return set;
}

}  // namespace ulf
