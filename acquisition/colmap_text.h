// COLMAP's text model (sparse/0): cameras.txt, images.txt, points3D.txt. Its poses are world-to-camera with
// our axes, its pixel centres at integer + 0.5: both as ours. Image names are relative to the images folder.
#pragma once

#include <string>

#include "acquisition/light_field.h"

namespace ulf {

struct ColmapText {
  std::string cameras;
  std::string images;
  std::string points3d;
};

ColmapText ToColmapText(const LightField& light_field);

}  // namespace ulf
