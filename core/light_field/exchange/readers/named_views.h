// Makes views of the photographs that a set's file names: finds them whatever folders their names begin with,
// counts those that are missing, and refuses what contradicts itself.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// Returns where photographs of these names may lie, for SetImages: the folder that those share which exist as
// they are named (absolute, or relative to `base`); then images, photos, input and `base` itself, and images
// beside it and beside the two folders above. Names from Windows may have `\` between folders.
std::vector<std::filesystem::path> FoldersOfNames(const std::filesystem::path& base,
                                                  const std::vector<std::string>& names);

// Says how many points whose position is not finite were left out.
void NotePointsNowhere(std::size_t count, LightField& light_field);

// Fills a set. It keeps references to its arguments.
class NamedViews {
 public:
  // `file` has the poses, in messages. `images` is the photographs' folder, which becomes the set's root.
  NamedViews(const std::filesystem::path& file, const SetImages& images, PosedSet& set);

  // Returns the photograph, relative to the root; if there is none, counts it and returns "". Throws an Error
  // that begins with `where` if another name has led to the same photograph.
  std::string Find(const std::string& name, const std::string& where);

  // Adds the view of a photograph that Find() has returned, and returns its id. Throws an Error that begins
  // with `where` for a pose or a camera that is not finite, and for another aspect than the camera's.
  int Add(const std::string& path, const CameraModel& camera, const Rigid3& cam_from_world,
          const std::string& where);

  // Notes how many photographs are missing. Throws Error if these are more than were found.
  void RequireFound();

 private:
  const std::string file_;
  const SetImages& images_;
  PosedSet& set_;
  std::map<std::string, std::string> names_;  // by photograph
  std::size_t missing_ = 0;
  std::string first_missing_;
};

// Throws an Error that begins with `where` if the principal point is far from the middle of the photograph:
// for formats that do not say of which size the photographs were that were measured.
void RequireMeasuredSize(const CameraModel& camera, const std::string& where);

// Adds what a view has seen of a point, unless the point has an observation of that view.
void AddObservation(int view_id, const Eigen::Vector2d& in_img, ScenePoint& point);

}  // namespace ulf
