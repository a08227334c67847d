// What the viewer leaves behind: pictures, and keyframes that `ulf render --path` goes through
// (docs/rendering.md).
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "render/fields/aperture.h"
#include "render/viewer/viewer_camera.h"

namespace ulf::render {

inline constexpr char kKeyframeFile[] = "ulf_keyframes.json";
inline constexpr double kKeyframeSeconds = 2;  // from one to the next

// Behind those that the file holds; how many there are now. The size of the pictures is that of the first's
// window. Throws Error for a file that holds something else, and for an open aperture where the file's
// keyframes have none: with one, the focal plane takes the geometry's place all along the path.
std::size_t AppendKeyframe(const std::filesystem::path& file, const ViewerCamera& camera,
                           const cv::Size& screen, const std::optional<Aperture>& aperture);

// Under the first free number; says which.
std::filesystem::path SaveNumbered(const std::filesystem::path& folder, const cv::Mat& srgb8);
// As its ending says: .png, .jpg.
void SavePicture(const std::filesystem::path& file, const cv::Mat& srgb8);

}  // namespace ulf::render
