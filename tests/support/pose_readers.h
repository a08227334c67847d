// Reads ground truth as others write it: Middlebury's par.txt (temple_ring) and Strecha's .camera files.
#pragma once

#include <filesystem>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"

namespace ulf::test {

struct TrueView {
  std::filesystem::path image;
  CameraModel camera;
  Rigid3 cam_from_world;
};

// A light field of these photographs, which stay where they are, below `folder`.
LightField LightFieldOf(const std::filesystem::path& folder, const std::vector<TrueView>& views);

// Reads a file with one line for each image: name, K by rows, R by rows, t of the projection K [R t], with
// the image's origin at the top left. There principal points count from integer pixel centres. The pictures
// of the copy that tests use are all the same way up, also those that the gantry took upside down (their x
// axis points against the others'): their cameras are turned with them.
std::vector<TrueView> ReadMiddlebury(const std::filesystem::path& folder, const std::string& par_file);
LightField MiddleburyLightField(const std::filesystem::path& folder, const std::string& par_file);

// Reads gt_cameras_half/NNNN.jpg.camera beside images/NNNN.jpg: K, a row of zeros, R camera to world, the
// camera's centre, image size. Pixel centres are at integer + 0.5.
std::vector<TrueView> ReadStrecha(const std::filesystem::path& folder);

}  // namespace ulf::test
