// Writes the viewer's files: pictures, and keyframes as `ulf render` reads them (docs/rendering.md).
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "render/fields/aperture.h"
#include "render/viewer/viewer_camera.h"

namespace ulf::render {

inline constexpr char kKeyframeFile[] = "ulf_keyframes.json";
inline constexpr double kKeyframeSeconds = 2;  // from one keyframe to the next

// Appends a keyframe to the file and returns how many it has now. The size of the pictures is that of the
// window at the first keyframe. Throws Error for a file that is no list of keyframes, and for an aperture if
// the file's keyframes have none: a path has a focal plane along its whole length or nowhere.
std::size_t AppendKeyframe(const std::filesystem::path& file, const ViewerCamera& camera,
                           const cv::Size& screen, const std::optional<Aperture>& aperture);

// Writes the picture under the first free number and returns the file.
std::filesystem::path SaveNumbered(const std::filesystem::path& folder, const cv::Mat& srgb8);

}  // namespace ulf::render
