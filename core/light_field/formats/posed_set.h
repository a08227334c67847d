// Photographs with poses by another program, as its files have them: what the readers of all formats return
// and what Import() turns into a light field.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

struct PosedSet {
  // Paths of photographs, masters and masks count from `root` and may lead out of it ("../masks/a.png"). What
  // a reader left out or replaced is in `doubts`. Points have their tracks where the format has them.
  LightField light_field;
  std::string format;  // for people, such as "COLMAP, binary"
  // The nearest and the farthest depth along each view's axis, world units; empty where the format has none.
  std::vector<Eigen::Vector2d> depth_bounds;
  // B, G, R, 0 to 1: what those who publish results lay pictures with alpha over; none: nothing is agreed on.
  std::optional<cv::Vec3d> background;
};

// Where the photographs of a set lie that names them without their folder.
class SetImages {
 public:
  // `chosen`: the folder that the user gave, else empty: the first of `folders` (relative to `base`, or
  // absolute) that holds photographs. Throws Error that names the folders that were tried and the way out
  // (the parameter `images`).
  SetImages(const std::filesystem::path& base, const std::filesystem::path& chosen,
            const std::vector<std::filesystem::path>& folders);

  const std::filesystem::path& folder() const { return folder_; }
  // All photographs in the folder itself, by name as people count (a2.jpg before a10.jpg), relative to it.
  const std::vector<std::string>& names() const { return names_; }
  // The photograph of this name, relative to the folder and in it: under the whole name, else under what is
  // left of it without its first folders; where there is none, the one that has an ending besides, else the
  // one in upper or lower case, else the one with another ending. Folders are separated by `/` or, by
  // programs on Windows, by `\`. Empty: there is none. Not in several threads at once.
  std::string Find(const std::string& name) const;
  // masks/NAME.png, masks/STEM.png or masks/STEM_mask.png beside the folder (beside images_4 in masks_4
  // first) or in it, or NAME.mask.png or STEM.mask.png in it, relative to it; empty: there is none.
  std::string MaskOf(const std::string& name) const;

 private:
  const std::vector<std::string>& NamesBelow(const std::filesystem::path& folder) const;

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  mutable std::map<std::filesystem::path, std::vector<std::string>> names_below_;  // as they were asked for
};

// The remedy where the photographs of a set are not found, for messages.
std::string SayWhereTheyLie();

// The camera of photographs whose size differs from `camera`'s because they were resized: scaled to `image`'s
// size, with a line for `doubts` (once for a size). Throws Error that begins with `where` for another aspect
// ratio (more than a pixel off), and for a file that cannot be read.
CameraModel AtSizeOf(const std::filesystem::path& image, const CameraModel& camera, const std::string& where,
                     std::vector<std::string>& doubts);

// Adds the camera to `cameras` unless an equal one is there; returns its index.
int IndexOfCamera(const CameraModel& camera, std::vector<CameraModel>& cameras);

// The rotation nearest to `matrix`. Throws Error that begins with `where` and names `what` unless the matrix
// is one within 1e-3 (orthonormal, determinant 1).
Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix, const std::string& where,
                                   const std::string& what);

}  // namespace ulf
