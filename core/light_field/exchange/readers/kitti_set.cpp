#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using KittiMatrix = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

// Returns the twelve numbers of a matrix; throws an Error with `where`.
KittiMatrix KittiNumbers(const std::string& text, const std::string& where) {
  std::istringstream words(text);
  KittiMatrix matrix;
  std::string word;
  for (Eigen::Index i = 0; i < matrix.size(); ++i)
    if (!(words >> word) || !ParseNumber(word, matrix.data()[i]) || !std::isfinite(matrix.data()[i]))
      throw Error("{}: expected the 12 numbers of a 3x4 matrix, row by row", where);
  if (words >> word) throw Error("{}: goes on after the 12 numbers of a 3x4 matrix", where);
  return matrix;
}

// Returns the projection of a camera (0 to 3) from the first camera's frame to its pixels.
KittiMatrix ProjectionOf(const fs::path& calib, int camera) {
  std::ifstream stream = OpenTextFile(calib);
  const std::string key = fmt::format("P{}:", camera);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number)
    if (line.starts_with(key))
      return KittiNumbers(line.substr(key.size()), fmt::format("{}, line {}", calib.string(), number));
  throw Error(
      "{}: has no line '{}' with the projection of the photographs' camera; take the calib.txt of the "
      "sequence",
      calib.string(), key);
}

// Returns poses.txt in the folder, or the file that the benchmark has for sequences/NN elsewhere.
fs::path PosesOfSequence(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder / "calib.txt").lexically_normal();
  const fs::path name = whole.parent_path().filename().string() + ".txt";
  std::error_code unknown;
  for (const fs::path& file :
       {folder / "poses.txt", folder / name, folder / "poses" / name, folder / ".." / ".." / "poses" / name})
    if (fs::is_regular_file(file, unknown)) return file.lexically_normal();
  throw Error(
      "{}: no poses: neither poses.txt is in it nor {} in ../../poses; the benchmark has them for sequences "
      "00 "
      "to 10 alone",
      folder.string(), name.string());
}

// Returns the number that is a file's name, of ten digits in KITTI's raw data; none for others.
std::optional<std::size_t> NumberOfFrame(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  if (stem.empty() || stem.size() > 18 || stem.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return std::stoul(stem);
}

std::vector<double> TimesOfSequence(const fs::path& folder) {
  std::vector<double> times_s;
  std::ifstream stream(folder / "times.txt");
  for (std::string word; stream >> word;)
    if (double time_s = 0; ParseNumber(word, time_s) && std::isfinite(time_s)) times_s.push_back(time_s);
  return times_s;
}

}  // namespace

PosedSet ReadKittiSet(const fs::path& folder, const fs::path& chosen) {
  const fs::path poses_file = PosesOfSequence(folder);
  const SetImages images(folder, chosen, {"image_2", "image_0"});
  const std::string of_camera = images.folder().filename().string();
  constexpr std::string_view kFolder = "image_";
  const bool is_named = of_camera.size() == kFolder.size() + 1 && of_camera.starts_with(kFolder) &&
                        of_camera.back() >= '0' && of_camera.back() <= '3';
  const int number = is_named ? of_camera.back() - '0' : 0;
  const KittiMatrix projection = ProjectionOf(folder / "calib.txt", number);
  const Eigen::Matrix3d intrinsics = projection.leftCols<3>();
  const double f_x = intrinsics(0, 0), f_y = intrinsics(1, 1);
  const std::string where_calib = fmt::format("{}, P{}", (folder / "calib.txt").string(), number);
  if (!(f_x > 0 && f_y > 0) || intrinsics.row(2) != Eigen::RowVector3d(0, 0, 1) || intrinsics(0, 1) != 0 ||
      intrinsics(1, 0) != 0)
    throw Error("{}: is no projection of a rectified camera", where_calib);
  const Eigen::Vector3d cam_from_first = intrinsics.inverse() * projection.col(3);

  PosedSet set;
  set.format = "KITTI odometry";
  LightField& light_field = set.light_field;
  light_field.units = "metres";
  std::vector<Rigid3> first_from_world;
  std::ifstream stream = OpenTextFile(poses_file);
  for (std::string line; std::getline(stream, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = fmt::format("{}, line {}", poses_file.string(), first_from_world.size() + 1);
    const KittiMatrix pose = KittiNumbers(line, where);
    first_from_world.push_back(
        Rigid3{NearestRotation(pose.leftCols<3>(), where, "the matrix"), pose.col(3)}.Inverse());
  }
  const std::vector<double> times_s = TimesOfSequence(folder);
  NamedViews named(poses_file, images, set);
  std::size_t unposed = 0;
  for (const std::string& name : images.names()) {
    const auto frame = NumberOfFrame(name);
    if (!frame || *frame >= first_from_world.size()) {
      ++unposed;
      continue;
    }
    const std::string path = named.Find(name, poses_file.string());
    if (path.empty()) continue;
    const cv::Size size = ReadImageSize((images.folder() / path).string());
    const CameraModel camera =
        CameraModel::FromOpenCv(size.width, size.height, f_x, f_y, intrinsics(0, 2), intrinsics(1, 2));
    RequireMeasuredSize(camera, where_calib);
    Rigid3 cam_from_world = first_from_world[*frame];
    cam_from_world.translation += cam_from_first;
    named.Add(path, camera, cam_from_world, fmt::format("{}, line {}", poses_file.string(), *frame + 1));
    if (*frame < times_s.size()) light_field.views.back().device_time_s = times_s[*frame];
  }
  if (light_field.views.empty())
    throw Error("{}: none of the photographs in {} has a pose: their names must be the numbers of the {}",
                poses_file.string(), images.folder().string(), Counted(first_from_world.size(), "line"));
  NoteUnposed(unposed, "photograph", fmt::format("no pose in {}", poses_file.string()), set);
  if (light_field.views.size() < first_from_world.size())
    light_field.doubts.push_back(fmt::format(
        "{} of {} left out: no photograph in {}", first_from_world.size() - light_field.views.size(),
        Counted(first_from_world.size(), "pose"), images.folder().string()));
  return set;
}

}  // namespace ulf
