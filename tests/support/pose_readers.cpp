#include "tests/support/pose_readers.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/geometry/small_matrices.h"

namespace ulf::test {
namespace {

Eigen::Matrix3d ReadMatrix(std::istream& in) {
  Eigen::Matrix3d matrix;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) in >> matrix(row, column);
  return matrix;
}

// Numbers in files are rounded: the nearest rotation.
Eigen::Quaterniond RotationOf(const Eigen::Matrix3d& matrix, const std::string& where) {
  const SingularValues3 svd = SingularValuesOf(matrix);
  const Eigen::Matrix3d rotation = svd.u * svd.v.transpose();
  if (!((rotation - matrix).norm() < 1e-3) || rotation.determinant() < 0)
    throw std::runtime_error(where + ": not a rotation");
  return Eigen::Quaterniond(rotation);
}

}  // namespace

LightField LightFieldOf(const std::filesystem::path& folder, const std::vector<TrueView>& views) {
  LightField light_field;
  light_field.root = folder;
  for (const TrueView& from : views) {
    View view;
    view.id = static_cast<int>(light_field.views.size()) + 1;
    view.image_path = std::filesystem::relative(from.image, folder).string();
    view.camera = static_cast<int>(light_field.cameras.size());
    view.cam_from_world = from.cam_from_world;
    light_field.cameras.push_back(from.camera);
    light_field.views.push_back(view);
  }
  return light_field;
}

std::vector<TrueView> ReadMiddlebury(const std::filesystem::path& folder, const std::string& par_file) {
  std::ifstream file(folder / par_file);
  std::vector<TrueView> views;
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string name;
    if (!(in >> name) || !name.ends_with(".png")) continue;  // the first line of some copies is the count
    TrueView view;
    view.image = folder / name;
    const Eigen::Matrix3d k = ReadMatrix(in);
    const Eigen::Matrix3d rotation = ReadMatrix(in);
    Eigen::Vector3d t;
    if (!(in >> t.x() >> t.y() >> t.z())) throw std::runtime_error(par_file + ": a line is too short");
    view.camera = CameraModel::FromOpenCv(640, 480, k(0, 0), k(1, 1), k(0, 2), k(1, 2));
    view.cam_from_world = {RotationOf(rotation, name), t};
    if (rotation(0, 1) < 0) {
      view.camera.cx = view.camera.width - view.camera.cx;
      view.camera.cy = view.camera.height - view.camera.cy;
      const Rigid3 turned{Eigen::Quaterniond(0, 0, 0, 1), Eigen::Vector3d::Zero()};
      view.cam_from_world = turned * view.cam_from_world;
    }
    views.push_back(view);
  }
  if (views.empty()) throw std::runtime_error((folder / par_file).string() + ": no views");
  return views;
}

LightField MiddleburyLightField(const std::filesystem::path& folder, const std::string& par_file) {
  return LightFieldOf(folder, ReadMiddlebury(folder, par_file));
}

std::vector<TrueView> ReadStrecha(const std::filesystem::path& folder) {
  std::vector<TrueView> views;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "gt_cameras_half")) {
    std::ifstream in(entry.path());
    TrueView view;
    view.image = folder / "images" / entry.path().stem();
    const Eigen::Matrix3d k = ReadMatrix(in);
    Eigen::Vector3d zeros, center;
    in >> zeros.x() >> zeros.y() >> zeros.z();
    const Eigen::Matrix3d world_from_cam = ReadMatrix(in);
    in >> center.x() >> center.y() >> center.z() >> view.camera.width >> view.camera.height;
    if (!in) throw std::runtime_error(entry.path().string() + ": too short");
    view.camera.fx = k(0, 0);
    view.camera.fy = k(1, 1);
    view.camera.cx = k(0, 2);
    view.camera.cy = k(1, 2);
    view.cam_from_world = Rigid3{RotationOf(world_from_cam, entry.path().string()), center}.Inverse();
    views.push_back(view);
  }
  std::sort(views.begin(), views.end(),
            [](const TrueView& a, const TrueView& b) { return a.image < b.image; });
  return views;
}

}  // namespace ulf::test
