// A set of photographs with poses by another program. The readers of all formats (set_readers.h) return one,
// and Import() makes a light field of it.
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
  // Paths of photographs, masters and masks are relative to `root` and may leave it ("../masks/a.png").
  // `doubts` says what a reader left out or replaced. Points have their tracks if the format has them.
  LightField light_field;
  std::string format;  // for people, such as "COLMAP, binary"
  // The nearest and the farthest depth along each view's axis, world units; empty if the format has none.
  std::vector<Eigen::Vector2d> depth_bounds;
  // The background (B, G, R, 0 to 1) over which published results blend pictures with alpha, if defined.
  std::optional<cv::Vec3d> background;
  bool counts_unposed = false;  // `doubts` says how many photographs beside the views have no pose
};

// Finds the photographs of a set that names them without their folder.
class SetImages {
 public:
  // `chosen` is the folder that the user gave; if empty, the first of `folders` (relative to `base`, or
  // absolute) that holds photographs is taken. Throws Error with the remedy if none does.
  SetImages(const std::filesystem::path& base, const std::filesystem::path& chosen,
            const std::vector<std::filesystem::path>& folders);

  const std::filesystem::path& folder() const { return folder_; }
  // Returns all photographs in the folder itself, without its subfolders, in NameOrder().
  const std::vector<std::string>& names() const { return names_; }
  // Returns the photograph of this name in the folder, relative to it, or "". Tries the whole name, then the
  // name without its first folders; then with an ending added, in upper or lower case, and with another
  // ending. Folders are separated by `/` or, by programs on Windows, by `\`. Not thread-safe.
  std::string Find(const std::string& name) const;
  // Returns masks/NAME.png, masks/STEM.png or masks/STEM_mask.png beside the folder (beside images_4 in
  // masks_4 first) or in it, or NAME.mask.png or STEM.mask.png in it, relative to it; empty if there is none.
  std::string MaskOf(const std::string& name) const;

 private:
  const std::vector<std::string>& NamesBelow(const std::filesystem::path& folder) const;

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  mutable std::map<std::filesystem::path, std::vector<std::string>> names_below_;  // cache, filled on demand
};

// Returns the remedy for a set whose photographs are not found, for messages.
std::string ImagesRemedy();

// Returns the camera for photographs that may have been resized: `camera` itself if it has the size of the
// file `image` (or a raw file can be cropped to it), otherwise scaled to that size, which is noted in
// `doubts` once for a size. Throws an Error that begins with `where` for another aspect ratio (more than a
// pixel off), and Error for a file that cannot be read.
CameraModel AtSizeOf(const std::filesystem::path& image, const CameraModel& camera, const std::string& where,
                     std::vector<std::string>& doubts);

// Adds the camera to `cameras` unless an equal one is there; returns its index.
int IndexOfCamera(const CameraModel& camera, std::vector<CameraModel>& cameras);

// Adds a view of this photograph (relative to the folder of `images`), with its mask, under the next id.
View& AddView(const std::string& image_path, const CameraModel& camera, const Rigid3& cam_from_world,
              const SetImages& images, LightField& light_field);

// Adds to the set's doubts that so many cameras or photographs (`noun`) without a pose were left out, unless
// there are none.
void NoteUnposed(std::size_t count, const char* noun, const std::string& why, PosedSet& set);

// Returns the rotation nearest to `matrix`. Throws an Error that begins with `where` and names `what` unless
// the matrix is a rotation within 1e-3 (orthonormal, determinant 1).
Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix, const std::string& where,
                                   const std::string& what);

}  // namespace ulf
