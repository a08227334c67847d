// Measures where an image shows a map point, to a fraction of a pixel: warps the point's reference patch as
// the predicted pose shows it and aligns it with the image (inverse compositional, Baker and Matthews 2004;
// as in Forster et al. 2014). Gain and offset of the brightness are free, so automatic exposure does not
// matter. All observations of a point are measured against one picture of it; corners that are detected anew
// in every frame wander by half a pixel.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/features/features.h"

namespace ulf::tracking {

// The surroundings of a point on a pyramid level of its reference view, the keyframe that it is cut from.
// Pixel (row, column) lies at (column, row) - (kSide - 1) / 2 from the point, in that level's pixels.
struct ReferencePatch {
  static constexpr int kSide = 24;
  std::array<std::uint8_t, kSide * kSide> pixels{};
  int level = 0;
};

// Cuts the patch around an image point. Returns none if it would leave the image.
std::optional<ReferencePatch> CutPatch(const Pyramid& pyramid, const Eigen::Vector2d& img, int level);

// The columns are the displacements in the world that move the point's image in its reference view by one
// pixel of the patch's level in x and in y, on a surface that faces that view. AxesOf() returns none if the
// point does not project there.
using PatchAxes = Eigen::Matrix<double, 3, 2>;
std::optional<PatchAxes> AxesOf(const CameraModel& camera, const Rigid3& reference_from_world,
                                const Eigen::Vector3d& point_in_world, int level);

struct PatchAlignmentOptions {
  double max_shift = 2.5;         // level pixels; a patch that moves farther is another thing. Guessed
  double min_correlation = 0.85;  // normalised; a patch that looks less alike is refused. Guessed
};

struct PatchAlignment {
  Eigen::Vector2d img;     // of the point, level 0 pixels
  int level = 0;           // on which it was measured
  double correlation = 0;  // normalised, of the aligned patches
};

// Measures the point, from `expected_img` on; `cam_from_world` predicts the warp. Returns none if the patch
// cannot be warped, has too little texture, leaves the image, moves too far, does not settle or look alike.
std::optional<PatchAlignment> AlignPatch(const CameraModel& camera, const ReferencePatch& patch,
                                         const PatchAxes& axes, const Eigen::Vector3d& point_in_world,
                                         const Rigid3& cam_from_world, const Pyramid& pyramid,
                                         const Eigen::Vector2d& expected_img,
                                         const PatchAlignmentOptions& options = {});

}  // namespace ulf::tracking
