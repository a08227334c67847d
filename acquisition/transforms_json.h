// transforms.json as nerfstudio and instant-ngp have it, with ours under the key "ulf".
//
// Their poses are camera-to-world in OpenGL's axes (x right, y up, z back); ours are cam_from_world with y
// down and z forward. World coordinates are left as they are. Pixel centres are at integer + 0.5 in both.
// Intrinsics stand at the top or in every frame: fl_x fl_y cx cy w h, camera_angle_x/y, k1..k4 p1 p2,
// camera_model, is_fisheye.
#pragma once

#include <filesystem>
#include <string>

#include "acquisition/light_field.h"

namespace ulf {

// Reads FILE; image paths are taken relative to its folder, must exist and must not leave it. Throws Error
// naming the file, the frame and the key for anything missing, mistyped, not finite or not a rotation.
LightField ReadTransformsJson(const std::filesystem::path& file);

std::string TransformsJsonText(const LightField& light_field);

// Throws Error naming `where` and `key` unless the matrix is a rotation and a translation.
void RequireRotation(const Eigen::Matrix4d& matrix, const std::string& where, const char* key);
// Our pose of a camera whose matrix to the world has OpenGL's axes; the same check.
Rigid3 CamFromOpenGl(const Eigen::Matrix4d& world_from_cam, const std::string& where, const char* key);

// `relative` inside `root` after symbolic links, as a '/'-separated path relative to it; throws Error when it
// leaves.
std::string PathInside(const std::filesystem::path& root, const std::string& relative,
                       const std::string& where);

}  // namespace ulf
