// Writes the texts of posed photographs for other programs, one part for each form of export.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/similarity3.h"
#include "core/light_field/exchange/writers/colmap_program.h"
#include "core/light_field/exchange/writers/unit_cube.h"
#include "core/light_field/light_field.h"

namespace ulf {

// A folder that COLMAP reads holds, beside images/ and masks/, the model in sparse/0: text or binary, with
// the rigs and frames of COLMAP 3.12 and later, which earlier versions do not open. Cameras and images have
// the numbers of the database that `commands` make, NumberedAsInDatabase() (colmap_model.h).
struct ColmapFolder {
  std::vector<std::pair<std::string, std::string>> files;  // path in the folder, contents
  // By which COLMAP measures points of its own under these poses: one word after another, for a shell.
  // feature_extractor runs once for each camera that took several photographs, for versions with rigs in one
  // thread, since several threads finish the photographs in any order. None for a single image.
  std::vector<std::string> commands;
  std::vector<std::string> doubts;  // sentences on lenses that were changed for COLMAP
};
// `out` is the place of the folder in the commands.
ColmapFolder ColmapFolderOf(const LightField& exported, bool binary, const std::filesystem::path& out,
                            const ColmapVersion& colmap);

// Returns cameras.xml. Agisoft Metashape imports cameras by File > Import > Import Cameras, "Agisoft XML".
// Conventions are those of set_readers.h: sensors with f, b1 = fx - fy, the principal point counted from the
// middle, p1 and p2 swapped against OpenCV; camera-to-chunk transforms with our axes. Frame sensors have k1
// k2 k3 p1 p2, fisheyes k1 to k4: no coefficient is lost. A camera's label is its photograph's stem.
std::string MetashapeXmlText(const LightField& exported);

// Throws Refusal, with the remedy, if RealityScan's form cannot represent one of the lenses (a fisheye).
void RequireRealityScanLenses(const LightField& light_field);

// Returns the file of one view of a light field that passed the check. RealityScan (once RealityCapture)
// reads an XMP file beside each photograph: STEM.xmp for STEM.jpg. Conventions are those of set_readers.h.
// Poses are locked and lenses exact, so that the program keeps both; views of one camera are one calibration
// group. Groups count from 0: the program's help ("Selected Input") calls every number but -1 a group.
std::string RealityScanXmpText(const CameraModel& camera, int camera_group, const Rigid3& cam_from_world);

// instant-ngp and NeRF's synthetic sets have transforms files with poses as in transforms.json
// (transforms_json.h), camera-to-world with OpenGL's axes.
//
// instant-ngp (NVlabs/instant-ngp, src/nerf_loader.cu) moves positions by "scale" and "offset" into its unit
// cube and renders "aabb_scale" such cubes; of OPENCV's distortion it knows k1 k2 p1 p2, of fisheyes
// ("is_fisheye") k1 to k4. It does not train with pixels that are not 0 in dynamic_mask_STEM.png.
//
// NeRF's synthetic sets (bmild/nerf, load_blender.py) have one pinhole camera for all, given by
// "camera_angle_x"; LichtFeld Studio asks for "camera_angle_y" where pictures are not square. Photographs are
// RGBA PNG, named without their ending. z is up, the subject is at the origin, and readers assume depths of 2
// to 6: the world is scaled so that cameras are about 4 from it.

// Returns the transforms.json without "mask_path", which instant-ngp does not know; its masks are inverted.
nlohmann::json InstantNgpDocument(const LightField& exported);

// Returns the transform from the light field's world to that of NeRF's synthetic sets.
Similarity3 NerfFromWorld(const LightField& light_field, const Subject& subject);

// Returns whether the view at this index of LightField::views belongs to the test part: every eighth does.
bool IsForTesting(std::size_t index);

// Returns the transforms file of the test or the training part. File names are relative to its folder.
std::string NerfSyntheticText(const LightField& exported, const Similarity3& nerf_from_world, bool testing);

// Returns sentences on what readers of NeRF's synthetic sets will not show as it is; empty if nothing.
std::vector<std::string> NerfSyntheticDoubts(const LightField& light_field, const Subject& subject,
                                             bool has_masks);

}  // namespace ulf
