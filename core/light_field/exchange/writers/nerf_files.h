// The transforms files of instant-ngp and of NeRF's synthetic sets. Both have poses as transforms.json has them
// (transforms_json.h), camera-to-world with OpenGL's axes.
//
// instant-ngp (NVlabs/instant-ngp, src/nerf_loader.cu) moves positions by "scale" and "offset" into its unit cube and
// renders "aabb_scale" such cubes; of OPENCV's distortion it knows k1 k2 p1 p2, of fisheyes ("is_fisheye") k1 to k4. A
// pixel that is not 0 in dynamic_mask_STEM.png beside a photograph is not trained with.
//
// NeRF's synthetic sets (bmild/nerf, load_blender.py) are one pinhole camera for all, said by "camera_angle_x" alone;
// photographs are RGBA PNG, named without their ending. z is up, the subject stands at the origin, and readers have the
// depths that they look at, 2 to 6, in their source: the world is moved, turned and scaled until the cameras stand about 4
// from the subject.
#pragma once

#include <string>
#include <vector>

#include "core/geometry/similarity3.h"
#include "core/light_field/exchange/writers/unit_cube.h"
#include "core/light_field/light_field.h"

namespace ulf {

// The transforms.json; without "mask_path", which instant-ngp does not know and would have to be the other way round.
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
