// Reads and writes transforms.json of nerfstudio and instant-ngp, with the values of ulf under the key "ulf".
//
// Their poses are camera-to-world in OpenGL's axes (x right, y up, z back); those of ulf are cam_from_world
// with y down and z forward. World coordinates are unchanged. Pixel centres are at integer + 0.5 in both.
// Intrinsics are at the top level or in every frame (transforms_camera.h). "mask_path" of frames, the masks
// of instant-ngp (dynamic_mask_STEM.png beside a photograph) and "ply_file_path" of the set are read too.
// Poses during a rolling shutter ("transform_matrix_start" and "_end") become the one in the middle of the
// picture. Sets for NeuS2 ("from_na") and of Mitsuba ("normal_mts_args") have other camera axes.
// LightField::doubts names other keys, unless they concern training.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "core/light_field/formats/posed_set.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"

namespace ulf {

inline constexpr const char* kTransformsFile = "transforms.json";

// Reads the file with its points. Image paths are relative to its folder (`/` or `\` between folders) and
// must not leave it. Frames without their photograph are left out, unless most are, or the file is of ulf.
// Frames are parsed one at a time, so that a file of a million frames needs no more memory than their views.
// Throws an Error that names file, frame and key for a value that is missing, of the wrong type, not finite
// or not a rotation.
LightField ReadTransformsJson(const std::filesystem::path& file);

// Does the same for a set by another program that is to be copied: cameras are scaled to photographs that
// were resized (AtSizeOf), and photographs may lie outside its folder and are searched by their names in it.
// If `images` is not empty, photographs are searched there by name (SetImages::Find); the light field's paths
// are then relative to it, and masters and exposures under "ulf" are ignored. With `may_be_poses_alone`
// any or all of the photographs may be missing. The photographs of `others`, files of the same set, are
// not taken for this one's.
LightField ReadTransformsSet(const std::filesystem::path& file, const std::filesystem::path& images = {},
                             bool may_be_poses_alone = false,
                             std::span<const std::filesystem::path> others = {});

// Reads the file only, not the images and points that it names; they need not exist. A frame without an id
// under "ulf" gets the number in its image's name, else its position in the list, from 1.
struct TransformsText {
  LightField light_field;
  std::optional<JournalStamp> made_from;  // none: by another program or an older version
  bool ours = false;                      // it has values under "ulf"
};
TransformsText ReadTransformsText(const std::filesystem::path& file);

// Reads poses and cameras only, in the file's order, numbered from 1. The files that it names need not exist;
// a camera whose size only its photograph would tell has the width 0.
LightField ReadTransformsPoses(const std::filesystem::path& file);

// Returns the content of a transforms.json. `made_from` is the stamp of the journal that holds the values.
nlohmann::json TransformsDocument(const LightField& light_field,
                                  const std::optional<JournalStamp>& made_from = std::nullopt);
// Returns that document as the text of a file.
std::string TransformsJsonText(const LightField& light_field,
                               const std::optional<JournalStamp>& made_from = std::nullopt);

// Returns the rows of "transform_matrix" (OpenGL's axes) for a camera-to-world matrix with our axes.
nlohmann::json OpenGlRows(const Eigen::Matrix4d& world_from_cam);

// Returns cam_from_world from a camera-to-world matrix with OpenGL's axes. Throws Error naming `where` and
// `key` as PoseRotations does.
Rigid3 CamFromOpenGl(const Eigen::Matrix4d& world_from_cam, const std::string& where, const char* key,
                     PoseRotations& rotations);

}  // namespace ulf
