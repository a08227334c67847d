// Texts of the files that other programs read as sets of posed photographs, one part for each form of export.
#pragma once

#include <string>
#include <vector>

#include "core/geometry/similarity3.h"
#include "core/light_field/exchange/writers/unit_cube.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Cameras for Agisoft Metashape: File > Import > Import Cameras, "Agisoft XML". Conventions as set_readers.h
// has them: sensors with f, b1 = fx - fy, the principal point counted from the middle, p1 and p2 the other
// way round than OpenCV's; camera-to-chunk transforms with our axes. Frame sensors have k1 k2 k3 p1 p2,
// fisheyes k1 to k4: nothing of a lens is lost. Cameras are labelled with their photograph's name without its
// ending.

std::string MetashapeXmlText(const LightField& exported);

// XMP files for RealityScan (once RealityCapture), one beside each photograph: STEM.xmp for STEM.jpg.
// Conventions as set_readers.h has them. Poses are locked and lenses exact, so that the program keeps both;
// views of one camera are one calibration group. Groups count from 0: its help ("Selected Input") calls every
// number but -1 a group.

// Throws Refusal, which names the way out, where the form has no words for one of the lenses (a fisheye).
void RequireRealityScanLenses(const LightField& light_field);

// Of a view of a light field that passed the check.
std::string RealityScanXmpText(const CameraModel& camera, int camera_group, const Rigid3& cam_from_world);

// The transforms files of instant-ngp and of NeRF's synthetic sets. Both have poses as transforms.json has
// them (transforms_json.h), camera-to-world with OpenGL's axes.
//
// instant-ngp (NVlabs/instant-ngp, src/nerf_loader.cu) moves positions by "scale" and "offset" into its unit
// cube and renders "aabb_scale" such cubes; of OPENCV's distortion it knows k1 k2 p1 p2, of fisheyes
// ("is_fisheye") k1 to k4. A pixel that is not 0 in dynamic_mask_STEM.png beside a photograph is not trained
// with.
//
// NeRF's synthetic sets (bmild/nerf, load_blender.py) are one pinhole camera for all, said by
// "camera_angle_x" alone; photographs are RGBA PNG, named without their ending. z is up, the subject stands
// at the origin, and readers have the depths that they look at, 2 to 6, in their source: the world is moved,
// turned and scaled until the cameras stand about 4 from the subject.

// The transforms.json; without "mask_path", which instant-ngp does not know and would have to be the other
// way round.
std::string InstantNgpText(const LightField& exported);

// From the light field's world to that of NeRF's synthetic sets.
Similarity3 NerfFromWorld(const LightField& light_field, const Subject& subject);

// Which of them a view belongs to: every eighth is for testing.
bool IsForTesting(std::size_t index);

// A transforms file of the views for which `is_part` is true. image_path are relative to the file's folder.
std::string NerfSyntheticText(const LightField& exported, const Similarity3& nerf_from_world, bool testing);

// What readers of NeRF's synthetic sets will not show as it is, in words; empty: nothing.
std::vector<std::string> NerfSyntheticDoubts(const LightField& light_field, const Subject& subject,
                                             bool has_masks);

}  // namespace ulf
