// Reads and writes COLMAP's text and binary models.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/light_field/formats/colmap_model.h"
#include "core/light_field/journal_stamp.h"

namespace ulf {

// COLMAP's text model is cameras.txt, images.txt, points3D.txt.

struct ColmapFiles {
  std::string cameras;
  std::string images;
  std::string points3d;
};

// Image points are rounded to 1/10000 pixel, all other values are exact. `made_from` is the stamp of the
// values' journal.
ColmapFiles ToColmapText(const ColmapReconstruction& model,
                         const std::optional<JournalStamp>& made_from = std::nullopt);

// The content of images.txt.
struct ColmapPoses {
  struct Image {
    Rigid3 cam_from_world;
    int camera = 1;  // CAMERA_ID
    std::string name;
  };
  std::map<int, Image> images;  // by IMAGE_ID
  std::optional<JournalStamp> made_from;
};
// Throws Error that names file and line for an invalid file.
ColmapPoses ReadColmapPoses(const std::filesystem::path& images_txt);

// Reads DIR/cameras.txt, images.txt and, if it exists, points3D.txt. The cameras have COLMAP's model number.
// Throws Error that names file and line for an invalid file.
ColmapReconstruction ReadColmapText(const std::filesystem::path& dir);

// Returns cameras by CAMERA_ID. Throws Error that names file and line for an invalid file or a camera model
// that CameraModel does not support.
std::map<int, CameraModel> ReadColmapCameras(const std::filesystem::path& cameras_txt);

// COLMAP's binary model is cameras.bin, images.bin, points3D.bin. Readers prefer it to a text model in the
// same folder.

ColmapFiles ToColmapBinary(const ColmapReconstruction& model);

// Reads DIR/cameras.bin, images.bin and, if it exists, points3D.bin. Throws Error that names a file that is
// truncated, has wrong counts, or whose values make no camera or pose.
ColmapReconstruction ReadColmapBinary(const std::filesystem::path& dir);

}  // namespace ulf
