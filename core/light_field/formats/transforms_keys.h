// The keys of a transforms.json that are not of its cameras' lenses (transforms_camera.h).
#pragma once

#include <algorithm>
#include <iterator>
#include <string_view>

namespace ulf {

// These keys are read, or only trainers need them; all others are reported as not used.
inline constexpr std::string_view kTransformsKeys[] = {"aabb",
                                                       "aabb_scale",
                                                       "applied_scale",
                                                       "applied_transform",
                                                       "auto_scale_poses_override",
                                                       "enable_depth_loading",
                                                       "enable_ray_loading",
                                                       "frames",
                                                       "from_na",
                                                       "importance_sampling",
                                                       "integer_depth_scale",
                                                       "n_extra_learnable_dims",
                                                       "name",
                                                       "normal_mts_args",
                                                       "offset",
                                                       "orientation_override",
                                                       "ply_file_path",
                                                       "render_aabb",
                                                       "rolling_shutter",
                                                       "scale",
                                                       "sharpen",
                                                       "sharpness_discard_threshold",
                                                       "test_filenames",
                                                       "train_filenames",
                                                       "ulf",
                                                       "up",
                                                       "val_filenames"};
inline constexpr std::string_view kFrameKeys[] = {"colmap_im_id",
                                                  "file_path",
                                                  "mask_path",
                                                  "rolling_shutter",
                                                  "rotation",
                                                  "sharpness",
                                                  "transform_matrix",
                                                  "transform_matrix_end",
                                                  "transform_matrix_start",
                                                  "ulf"};

template <std::size_t N>
bool Among(const std::string_view (&keys)[N], std::string_view key) {
  return std::ranges::find(keys, key) != std::end(keys);
}

}  // namespace ulf
