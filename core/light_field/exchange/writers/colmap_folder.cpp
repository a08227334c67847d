#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/light_field/exchange/writers/set_writers.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/colmap_rigs.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// COLMAP takes a camera whose coefficients are all smaller than 1e-8 for a pinhole (Camera::IsUndistorted(),
// src/colmap/scene/camera.cc), a fisheye too, and its image_undistorter copies the photographs.
constexpr double kColmapZero = 1e-8, kNextToZero = 2 * kColmapZero;
constexpr int kOpenCvFisheye = 5;
constexpr std::size_t kFirstCoefficient = 4;

void MarkStraightFisheyes(ColmapReconstruction& model, std::vector<std::string>& doubts) {
  for (ColmapReconstruction::Camera& camera : model.cameras) {
    const auto first = camera.parameters.begin() + kFirstCoefficient;
    if (camera.model != kOpenCvFisheye ||
        std::any_of(first, camera.parameters.end(), [](double k) { return std::abs(k) > kColmapZero; }))
      continue;
    *first = kNextToZero;
    doubts.push_back(
        fmt::format("camera {} is a fisheye without distortion, which COLMAP's image_undistorter would leave "
                    "as it is: its k1 is written as {}, which moves no pixel by 0.01; {} makes it a pinhole",
                    camera.id, kNextToZero, Parameter("undistort")));
  }
}

std::string ListName(const ColmapReconstruction::Camera& camera) {
  return fmt::format("camera_{}.txt", camera.id);
}

bool IsOneCameraEach(const ColmapReconstruction& model) {
  return model.cameras.size() == model.images.size() &&
         std::ranges::all_of(model.cameras, [&](const ColmapReconstruction::Camera& camera) {
           return camera.model == model.cameras.front().model;
         });
}

std::string LensOptions(const ColmapReconstruction::Camera& camera) {
  return fmt::format(" --ImageReader.camera_model {} --ImageReader.camera_params {}", camera.name,
                     fmt::join(camera.parameters, ","));
}

std::vector<std::string> CommandsFor(const ColmapReconstruction& model, const fs::path& out, bool has_masks,
                                     const ColmapVersion& colmap) {
  constexpr std::size_t kLeastImages = 2;  // of point_triangulator
  if (model.images.size() < kLeastImages) return {};
  const auto word = [&](const std::string& name) { return ShellWord((out / name).string()); };
  const std::string database = word("database.db"), images = word("images");
  const std::string mask = has_masks ? " --ImageReader.mask_path " + word("masks") : "";
  std::vector<std::string> commands;
  // The lenses of a database only serve to verify matches, so that a similar one does.
  if (const bool is_one = model.cameras.size() == 1; is_one || IsOneCameraEach(model))
    commands.push_back(fmt::format(
        "colmap feature_extractor --database_path {} --image_path {}{} --ImageReader.single_camera{} 1{}{}",
        database, images, mask, is_one ? "" : "_per_image", LensOptions(model.cameras.front()),
        colmap.extractor));
  else
    for (const ColmapReconstruction::Camera& camera : model.cameras)
      commands.push_back(
          fmt::format("colmap feature_extractor --database_path {} --image_path {} --image_list_path {}{} "
                      "--ImageReader.single_camera 1{}{}",
                      database, images, word(ListName(camera)), mask, LensOptions(camera), colmap.extractor));
  commands.push_back(fmt::format("colmap exhaustive_matcher --database_path {}{}", database, colmap.matcher));
  commands.push_back("mkdir " + word("triangulated"));
  commands.push_back(fmt::format(
      "colmap point_triangulator --database_path {} --image_path {} --input_path {} --output_path {} "
      "--clear_points 1",
      database, images, word("sparse/0"), word("triangulated")));
  return commands;
}

}  // namespace

ColmapFolder ColmapFolderOf(const LightField& exported, bool binary, const fs::path& out,
                            const ColmapVersion& colmap) {
  ColmapFolder folder;
  ColmapReconstruction model = NumberedAsInDatabase(ToColmap(exported));
  MarkStraightFisheyes(model, folder.doubts);
  ColmapFiles files = binary ? ToColmapBinary(model) : ToColmapText(model);
  ColmapRigFiles rigs = ToColmapRigs(model, binary);
  const std::string sparse = "sparse/0/", ending = binary ? ".bin" : ".txt";
  folder.files = {{sparse + "cameras" + ending, std::move(files.cameras)},
                  {sparse + "images" + ending, std::move(files.images)},
                  {sparse + "points3D" + ending, std::move(files.points3d)},
                  {sparse + "rigs" + ending, std::move(rigs.rigs)},
                  {sparse + "frames" + ending, std::move(rigs.frames)}};
  if (model.cameras.size() > 1 && !IsOneCameraEach(model))
    for (const ColmapReconstruction::Camera& camera : model.cameras) {
      std::string names;
      for (const ColmapReconstruction::Image& image : model.images)
        if (image.camera == camera.id) names += image.name + "\n";
      folder.files.emplace_back(ListName(camera), std::move(names));
    }
  const bool has_masks =
      std::ranges::any_of(exported.views, [](const View& view) { return !view.mask_path.empty(); });
  folder.commands = CommandsFor(model, out, has_masks, colmap);
  return folder;
}

}  // namespace ulf
