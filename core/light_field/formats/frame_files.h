// Finds the photographs and masks that the frames of a transforms.json name, and keeps their paths within a
// folder. `given` is the path as the file has it; errors begin with `where`, the place in the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/json_fields.h"
#include "core/light_field/formats/posed_set.h"

namespace ulf {

// Returns the path, '/'-separated, normalised and relative to `root`. Throws Error if it leaves `root`, by
// itself or by a symbolic link.
std::string PathInside(const std::filesystem::path& root, const std::string& relative,
                       const std::string& where);

// Says where the photographs and masks of frames are.
struct FrameFiles {
  bool are_read = true;                  // if false, paths are taken as they are written
  bool are_poses_wanted = false;         // and nothing else: views keep their order, cameras may lack a size
  bool may_be_poses_alone = false;       // any or all of the photographs may be missing
  std::filesystem::path root = {};       // the folder that frames' paths are relative to
  std::optional<SetImages> images = {};  // if set, the photographs' folder instead of `root`
  // If not empty, the set is copied: photographs may be resized, which scales their cameras, and may lie
  // anywhere. Those that are not where the file says are searched in these folders (`root` and its parent).
  std::vector<SetImages> around = {};

  bool is_copied() const { return !around.empty(); }
};

// Returns the photograph's path relative to the folder in which photographs are searched, or "" if it does
// not exist: nerfstudio writes paths with their ending, Blender's original NeRF sets without, and a raw file
// may lie there instead of its JPEG. Throws Error if the path leaves `root`, unless the set is copied.
std::string PathOfPhotograph(const FrameFiles& files, const std::string& given, const std::string& where);

// Returns the photograph that the frame names in the set's own folder, although those of another folder are
// read: its size is that of the intrinsics. Empty if it does not exist.
std::filesystem::path MeasuredPhotograph(const FrameFiles& files, const std::string& given,
                                         const std::string& where);

// Returns the path of any other file that the set names, relative to `root`, or "" if it is missing. Throws
// Error if the name leaves `root` and the set is not copied.
std::string FileOfSet(const FrameFiles& files, const std::string& given, const std::string& where);

// Counts photographs that frames of a file name and that do not exist.
class MissingPhotographs {
 public:
  explicit MissingPhotographs(std::string file) : file_(std::move(file)) {}
  void Add(const std::string& where, const std::string& given) {
    if (count_++ == 0) first_where_ = where, first_ = given;
  }
  bool none() const { return count_ == 0; }
  // Says in `doubts` how many frames are left out. Throws Error with their number and the first of them
  // if they are more than the `there` that are not, unless any may be missing, or if none may be missing
  // (`all_needed`: a light field of ulf).
  void Tell(const FrameFiles& files, std::size_t there, bool all_needed,
            std::vector<std::string>& doubts) const;

 private:
  std::string file_;
  std::size_t count_ = 0;
  std::string first_where_, first_;
};

// Returns the set's own mask, relative to the photographs' folder. Throws if it is missing, or leaves `root`
// and the set is not copied.
std::string MaskOfSet(const FrameFiles& files, const std::string& given, const std::string& where);

// Returns the mask of a frame, or "". A mask beside photographs in another folder has precedence: it has
// their size. Throws as MaskOfSet() does.
std::string PathOfMask(const FrameFiles& files, const JsonPlace& frame, const std::string& photograph);

}  // namespace ulf
