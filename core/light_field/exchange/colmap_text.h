// COLMAP's text model: cameras.txt, images.txt, points3D.txt.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/light_field/exchange/colmap_model.h"
#include "core/light_field/journal.h"

namespace ulf {

struct ColmapFiles {
  std::string cameras;
  std::string images;
  std::string points3d;
};

// Places in images are written to a ten-thousandth of a pixel, all else exactly. `made_from`: the journal
// that the values are from.
ColmapFiles ToColmapText(const ColmapReconstruction& model,
                         const std::optional<JournalStamp>& made_from = std::nullopt);

// What images.txt of such a model says.
struct ColmapPoses {
  struct Image {
    Rigid3 cam_from_world;
    int camera = 1;  // CAMERA_ID
    std::string name;
  };
  std::map<int, Image> images;  // by IMAGE_ID
  std::optional<JournalStamp> made_from;
};
// Throws Error naming file and line for what is no such file.
ColmapPoses ReadColmapPoses(const std::filesystem::path& images_txt);

// By CAMERA_ID. Throws Error naming file and line for what is no such file, or is of a model that CameraModel
// does not know.
std::map<int, CameraModel> ReadColmapCameras(const std::filesystem::path& cameras_txt);

}  // namespace ulf
