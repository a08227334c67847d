// Reads and writes COLMAP's models, as text (cameras.txt, images.txt, points3D.txt) or binary (.bin). Readers
// prefer a binary model to a text model in the same folder.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/light_field/formats/colmap_model.h"
#include "core/light_field/journal_stamp.h"

namespace ulf {

// The contents of the three files.
struct ColmapFiles {
  std::string cameras;
  std::string images;
  std::string points3d;
};

// Image points are rounded to 1/10000 pixel, errors to five digits; all other values are exact. `made_from`
// is the stamp of the journal that holds the values, noted in images.txt.
ColmapFiles ToColmapText(const ColmapReconstruction& model,
                         const std::optional<JournalStamp>& made_from = std::nullopt);

// The poses in images.txt.
struct ColmapPoses {
  struct Image {
    Rigid3 cam_from_world;
    int camera = 1;  // CAMERA_ID
    std::string name;
  };
  std::map<int, Image> images;            // by IMAGE_ID
  std::optional<JournalStamp> made_from;  // none: by another program
};
// The readers of text throw an Error that names file and line for an invalid file.
ColmapPoses ReadColmapPoses(const std::filesystem::path& images_txt);

// Reads the model in `dir`, whose points3D.txt may be missing. The cameras are as of ToColmapCamera().
ColmapReconstruction ReadColmapText(const std::filesystem::path& dir);

// Returns cameras by CAMERA_ID. Throws also for a camera model that ReadColmapCamera() does not know.
std::map<int, CameraModel> ReadColmapCameras(const std::filesystem::path& cameras_txt);

ColmapFiles ToColmapBinary(const ColmapReconstruction& model);

// Reads the model in `dir`, whose points3D.bin may be missing. Throws an Error that names a file that is
// truncated, has wrong counts, or whose values make no camera or pose.
ColmapReconstruction ReadColmapBinary(const std::filesystem::path& dir);

}  // namespace ulf
