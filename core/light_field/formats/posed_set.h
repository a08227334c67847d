// A set of photographs with poses by another program. The readers of all formats (set_readers.h) return one,
// and Import() makes a light field of it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
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

// Stands for the folder of a set's photographs where its poses are wanted alone: SetImages then finds every
// photograph under the name that it has in the set, and AtSizeOf() leaves its camera.
inline const std::filesystem::path kNoPhotographs = "/dev/null";

// Finds the photographs of a set that names them without their folder.
class SetImages {
 public:
  // `chosen` is the folder that the user gave; if empty, the first of `folders` (relative to `base`, or
  // absolute) that holds photographs is taken. Throws Error with the remedy if none does.
  SetImages(const std::filesystem::path& base, const std::filesystem::path& chosen,
            const std::vector<std::filesystem::path>& folders);
  // Takes this folder, whatever it holds.
  explicit SetImages(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  // Returns all photographs in the folder itself, without its subfolders, in NameOrder().
  const std::vector<std::string>& names() const { return names_; }
  // Says how the set names its photographs. Find() then leaves each photograph to the names that fit its path
  // best: right/1.jpg is not taken for left/1.jpg, which is missing, nor images/1.png for masks/1.png.
  void Reserve(const std::vector<std::string>& names);
  // Returns the photograph of this name in the folder, relative to it, or "". Tries the whole name, then the
  // name without its first folders; then with an ending added, in upper or lower case, and with another
  // ending; then all folders below, of which the one whose path ends most like `name` is taken. Throws Error
  // if several do alike. Folders are separated by `/` or, by programs on Windows, by `\`. Not thread-safe.
  std::string Find(const std::string& name) const;
  // Does so without looking into folders that `name` does not end with.
  std::string FindByEnd(const std::string& name) const;
  // Returns masks/NAME.png, masks/STEM.png or masks/STEM_mask.png beside the folder (beside images_4 in
  // masks_4 first) or in it, or NAME.mask.png or STEM.mask.png in it, in upper or lower case, relative to it;
  // empty if there is none.
  std::string MaskOf(const std::string& name) const;

 private:
  const std::vector<std::string>& NamesBelow(const std::filesystem::path& folder) const;
  std::string FindBelow(const std::string& name) const;
  std::string FileOfAnyCase(const std::filesystem::path& file) const;
  bool IsReservedForAnother(const std::string& path, const std::string& name) const;

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::map<std::string, std::set<std::string>> reserved_;  // the names that fit a photograph best, by path
  mutable std::map<std::filesystem::path, std::vector<std::string>> names_below_;  // cache, filled on demand
  mutable std::optional<std::multimap<std::string, std::string>> all_below_;       // the same; paths by name
  // The same: by folder, the names of files by these in lower case.
  mutable std::map<std::filesystem::path, std::map<std::string, std::filesystem::path>> files_there_;
};

// Returns whether both the photograph that was found and the name that it has in the set have folders, of
// which the last differ.
bool IsInAnotherFolder(const std::string& path, const std::string& name);

// Returns dynamic_mask_STEM.png beside the photograph, whose pixels that are not black are not to be used
// (instant-ngp), or "" if there is none. Both paths are relative to `root`.
std::string DynamicMaskOf(const std::filesystem::path& root, const std::string& image_path);

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

// Adds a view of this photograph (relative to the folder of `images`), with its mask (MaskOf() or
// DynamicMaskOf()), under the next id.
View& AddView(const std::string& image_path, const CameraModel& camera, const Rigid3& cam_from_world,
              const SetImages& images, LightField& light_field);

// Adds to the set's doubts that so many cameras or photographs (`noun`) without a pose were left out, unless
// there are none.
void NoteUnposed(std::size_t count, const char* noun, const std::string& why, PosedSet& set);

// Reads the rotations of a set's poses, of which some programs write matrices that are none exactly: with a
// scale, or with few decimals.
class PoseRotations {
 public:
  // Returns the rotation nearest to `matrix`, whose length it takes out. Throws an Error that begins with
  // `where` and names `what` if the matrix is mirrored, or farther from a rotation than two decimals explain.
  Eigen::Quaterniond Read(const Eigen::Matrix3d& matrix, const std::string& where, const std::string& what);
  // Returns the length of the last matrix, 1 for a rotation.
  double scale() const { return scale_; }
  // Adds to `doubts` how many matrices changed, and by how much, if any did so visibly.
  void Tell(const std::string& file, std::vector<std::string>& doubts) const;

 private:
  double scale_ = 1;
  std::size_t changed_ = 0;
  double least_scale_ = 1, most_scale_ = 1, most_turn_ = 0;
};

// Does so for one matrix, without telling; also throws for a scale, because it would be one of the world.
Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix, const std::string& where,
                                   const std::string& what);

// Warns of what a reader has found so far, if an exception ends it before somebody else could.
class ToldOnFailure {
 public:
  explicit ToldOnFailure(const std::vector<std::string>& doubts);
  ToldOnFailure(const ToldOnFailure&) = delete;
  ToldOnFailure& operator=(const ToldOnFailure&) = delete;
  ~ToldOnFailure();

 private:
  const std::vector<std::string>& doubts_;
  int exceptions_;
};

// Throws an Error that begins with `where` and names `what` unless the row of a pose's matrix is 0 0 0 1, to
// single precision.
void RequireLastRow(const Eigen::RowVector4d& row, const std::string& where, const std::string& what);

}  // namespace ulf
