#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/light_field/exchange/readers/npy_file.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr Eigen::Index kLlffColumns = 17;

struct LlffRow {
  Rigid3 cam_from_world;
  CameraModel camera;
  Eigen::Vector2d depths;
};

LlffRow RowOf(const Eigen::VectorXd& values, const std::string& where, PoseRotations& rotations) {
  if (!values.allFinite())
    throw Error("{}: holds a number that is not finite; run LLFF's imgs2poses again", where);
  const Eigen::Map<const Eigen::Matrix<double, 3, 5, Eigen::RowMajor>> matrix(values.data());
  Eigen::Matrix4d world_from_cam = Eigen::Matrix4d::Identity();  // right, up, back
  world_from_cam.topRows<3>() << matrix.col(1), -matrix.col(0), matrix.col(2), matrix.col(3);
  constexpr double kMostPx = 1 << 20;
  const Eigen::Vector3d size = matrix.col(4);
  if (!(size.x() >= 1 && size.y() >= 1 && size.x() <= kMostPx && size.y() <= kMostPx && size.z() > 0))
    throw Error("{}: height {}, width {} and focal length {} are no camera's", where, size.x(), size.y(),
                size.z());
  LlffRow row{CamFromOpenGl(world_from_cam, where, "3x5 matrix", rotations),
              CameraModel::Pinhole(static_cast<int>(std::lround(size.y())),
                                   static_cast<int>(std::lround(size.x())), size.z()),
              values.tail<2>()};
  if (!(row.depths.x() > 0 && row.depths.y() > row.depths.x()))
    throw Error("{}: its depths, {} to {}, are no range in front of the camera", where, row.depths.x(),
                row.depths.y());
  return row;
}

}  // namespace

PosedSet ReadLlffSet(const fs::path& source, const fs::path& chosen) {
  const fs::path file = fs::is_directory(source) ? source / kLlffFile : source;
  const Eigen::MatrixXd rows = ReadNpyMatrix(file);
  if (rows.cols() != kLlffColumns || rows.rows() < 1)
    throw Error("{}: an array of {}x{} numbers; LLFF's has a row of {} for each photograph", file.string(),
                rows.rows(), rows.cols(), kLlffColumns);
  PosedSet set;
  set.format = "LLFF";
  const SetImages images(file.parent_path(), chosen,
                         {"images", "images_2", "images_4", "images_8", "input", "photos"});
  std::vector<std::string> names = images.names();
  std::ranges::sort(names);
  if (static_cast<Eigen::Index>(names.size()) != rows.rows())
    throw Error(
        "{}: has {}, {} holds {}; put back what is missing, take out what was added, or choose another "
        "folder with {}",
        file.string(), Counted(static_cast<std::size_t>(rows.rows()), "pose"), images.folder().string(),
        Counted(names.size(), "photograph"), Parameter("images"));
  LightField& light_field = set.light_field;
  light_field.root = images.folder();
  PoseRotations rotations;
  const ToldOnFailure told(light_field.doubts);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string where = fmt::format("{}, row {} ({})", file.string(), i, names[i]);
    const LlffRow row = RowOf(rows.row(static_cast<Eigen::Index>(i)), where, rotations);
    const CameraModel camera = AtSizeOf(images.folder() / names[i], row.camera, where, light_field.doubts);
    AddView(names[i], camera, row.cam_from_world, images, light_field);
    set.depth_bounds.push_back(row.depths);
  }
  rotations.Tell(file.string(), light_field.doubts);
  return set;
}

}  // namespace ulf
