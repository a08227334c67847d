// The files in which other programs read Gaussians; for SPZ see spz_file.h.
//
// PLY: the layout of the trainers (graphdeco-inria/gaussian-splatting): binary little-endian, floats x y z nx
// ny nz f_dc_0..2 f_rest_0..8 opacity scale_0..2 rot_0..3; opacity before the logistic function, scales as
// logarithms, rot as w x y z, f_rest channel by channel (three harmonics of red, then green, then blue). Here
// nx ny nz is the surface's normal, which readers ignore.
//
// glTF 2.0 with KHR_gaussian_splatting as its release candidate of 2026 stands (KhronosGroup/glTF): points
// with the attributes KHR_gaussian_splatting:ROTATION, SCALE (standard deviations; logarithms in earlier
// drafts), OPACITY and SH_DEGREE_l_COEF_n, all floats; COLOR_0 for programs that show points alone. Numbers
// have glTF's axes, y up, because programs that turn a node do not turn harmonics; "extras" of the node hold
// the turn.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

#include "render/splats/gaussians.h"

namespace ulf::render {

std::string SplatPlyBytes(const Gaussians& gaussians);

// Throws Error if the file would be larger than the format's 4 GB.
std::string SplatGlbBytes(const Gaussians& gaussians, const Eigen::Vector3d& up_in_world,
                          const std::string& name, const std::string& units);

// Returns the same Gaussians in a turned world.
Gaussians Turned(const Gaussians& gaussians, const Eigen::Quaternionf& turned_from_world);

}  // namespace ulf::render
