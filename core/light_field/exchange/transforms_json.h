// transforms.json as nerfstudio and instant-ngp have it, with ours under the key "ulf".
//
// Their poses are camera-to-world in OpenGL's axes (x right, y up, z back); ours are cam_from_world with y
// down and z forward. World coordinates are left as they are. Pixel centres are at integer + 0.5 in both.
// Intrinsics stand at the top or in every frame: fl_x fl_y cx cy w h, camera_angle_x/y, k1..k4 p1 p2,
// camera_model, is_fisheye. Of each frame "mask_path" is taken, too, and of the set "ply_file_path". What the
// file says beyond that stands in LightField::doubts, by key.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/light_field/journal.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Reads FILE with its points; image paths are taken relative to its folder, must exist and must not leave it.
// Frames are read one at a time: a file of a million needs no more memory than their views. Throws Error
// naming the file, the frame and the key for anything missing, mistyped, not finite or not a rotation.
LightField ReadTransformsJson(const std::filesystem::path& file);

// What FILE says and nothing of the files that it names: neither need they exist nor are points read. Frames
// without an id under "ulf" get the number that their image is named by, else their place in the list.
struct TransformsText {
  LightField light_field;
  std::optional<JournalStamp> made_from;  // none: written by another program or an older version
  bool ours = false;                      // it has values under "ulf"
};
TransformsText ReadTransformsText(const std::filesystem::path& file);

// `made_from`: the journal that the values are from.
std::string TransformsJsonText(const LightField& light_field,
                               const std::optional<JournalStamp>& made_from = std::nullopt);

// Throws Error naming `where` and `key` unless the matrix is a rotation and a translation.
void RequireRotation(const Eigen::Matrix4d& matrix, const std::string& where, const char* key);
// Our pose of a camera whose matrix to the world has OpenGL's axes; the same check.
Rigid3 CamFromOpenGl(const Eigen::Matrix4d& world_from_cam, const std::string& where, const char* key);

// `relative` inside `root` after symbolic links, as a '/'-separated path relative to it; throws Error when it
// leaves.
std::string PathInside(const std::filesystem::path& root, const std::string& relative,
                       const std::string& where);

}  // namespace ulf
