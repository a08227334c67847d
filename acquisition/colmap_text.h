// COLMAP's text model: cameras.txt, images.txt, points3D.txt.
#pragma once

#include <string>

#include "acquisition/colmap_model.h"

namespace ulf {

struct ColmapFiles {
  std::string cameras;
  std::string images;
  std::string points3d;
};

// Places in images are written to a ten-thousandth of a pixel, all else exactly.
ColmapFiles ToColmapText(const ColmapReconstruction& model);

}  // namespace ulf
