// COLMAP's text model (sparse/0): cameras.txt, images.txt, points3D.txt. Its poses are world-to-camera with
// our axes, its pixel centres at integer + 0.5: both as ours. Image names are relative to the images folder.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "acquisition/journal.h"
#include "acquisition/light_field.h"

namespace ulf {

struct ColmapText {
  std::string cameras;
  std::string images;
  std::string points3d;
};

// `made_from`: the journal that the values are from. Names that would break a row are written as SafeName()
// has them.
ColmapText ToColmapText(const LightField& light_field,
                        const std::optional<JournalStamp>& made_from = std::nullopt);

// The name without white space and control characters, for rows whose fields are parted by spaces.
std::string SafeName(const std::string& name);

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

}  // namespace ulf
