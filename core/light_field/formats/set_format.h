// The formats of sets of posed photographs, and the places of their files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ulf {

inline constexpr char kNerfSyntheticFile[] = "transforms_train.json";
inline constexpr char kLlffFile[] = "poses_bounds.npy";
inline constexpr char kTumListFile[] = "rgb.txt";
inline constexpr char kTumPosesFile[] = "groundtruth.txt";
inline constexpr char kPolycamCorrected[] = "corrected_cameras";

// The order is that of the search: formats with more information come first.
enum class SetFormat {
  kUlf,            // a light field: journal.jsonl
  kTransforms,     // nerfstudio, instant-ngp: transforms.json
  kNerfSynthetic,  // transforms_train.json
  kColmap,         // cameras and images, .bin or .txt, here or in sparse/0 and such (ColmapModelsIn)
  kLlff,           // poses_bounds.npy
  kBundler,        // bundle.out
  kMetashape,      // cameras .xml
  kRealityScan,    // .xmp beside the photographs, or .csv
  kMeshroom,       // cameras.sfm
  kOpenSfm,        // reconstruction.json
  kOpenMvg,        // sfm_data.json
  kVisualSfm,      // .nvm
  kGaussian,       // cameras.json of gaussian-splatting
  kPolycam,        // keyframes/corrected_cameras or keyframes/cameras
  kTum,            // rgb.txt and groundtruth.txt
  kEuroc,          // mav0/cam0/sensor.yaml
  kKitti           // calib.txt and image_2 or image_0
};
// Returns the name on the command line: "nerfstudio", "nerf-synthetic", "colmap", ...
const char* Name(SetFormat format);
// Returns none for "auto". Throws a Refusal that lists the names for an unknown one.
std::optional<SetFormat> SetFormatFromName(const std::string& name);

// Returns the formats in which `source`, a folder or a file, holds a set, in the order of SetFormat.
std::vector<SetFormat> FormatsIn(const std::filesystem::path& source);

// Returns the file or folder that the format's reader takes; empty if `source` holds no such set.
std::filesystem::path PlaceOf(SetFormat format, const std::filesystem::path& source);

// Returns the other files of the kind in the folder of a set's file, which may be other states of the set.
std::vector<std::filesystem::path> RivalsOf(const std::filesystem::path& place);

// Returns the folder of a COLMAP model: `source`, or the first in it of N, N/sparse and the folder itself of
// sparse, colmap/sparse, colmap, dense/sparse, dense, distorted/sparse, undistorted/sparse and `source`, N
// being a number. Where COLMAP could not join all photographs, N are 0, 1, ..., and all are returned in their
// order. None if there is no model.
std::vector<std::filesystem::path> ColmapModelsIn(const std::filesystem::path& source);

// Returns whether the folder holds a part of a COLMAP model ("images", ...) with an ending ("bin", "txt").
bool HoldsColmapPart(const std::filesystem::path& folder, const std::string& part, const char* ending);

}  // namespace ulf
