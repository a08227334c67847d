// Finds the photographs and masks that the frames of a transforms.json name, and keeps their paths within a
// folder. `given` is the path as the file has it; errors begin with `where`, the place in the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "core/base/json_fields.h"
#include "core/light_field/formats/posed_set.h"

namespace ulf {

// Returns the path, '/'-separated, normalised and relative to `root`. Throws Error if it leaves `root`, by
// itself or by a symbolic link.
std::string PathInside(const std::filesystem::path& root, const std::string& relative,
                       const std::string& where);

// Returns the file's path relative to `root`, or "" if it is missing. Throws Error if the name leaves `root`.
std::string FileWithin(const std::filesystem::path& root, const std::string& given, const std::string& where);

// Says where the photographs and masks of frames are.
struct FrameFiles {
  bool are_read = true;                  // if false, paths are taken as they are written
  bool may_be_resized = false;           // photographs may be resized; then their cameras are scaled
  std::filesystem::path root = {};       // the folder that frames' paths are relative to
  std::optional<SetImages> images = {};  // if set, the photographs' folder instead of `root`
};

// Returns the photograph's path relative to the folder in which photographs are searched, or "" if it does
// not exist: nerfstudio writes paths with their ending, Blender's original NeRF sets without, and a raw file
// may lie there instead of its JPEG. Throws Error if the path leaves `root`.
std::string PathOfPhotograph(const FrameFiles& files, const std::string& given, const std::string& where);

// Returns the photograph that the frame names in the set's own folder, although those of another folder are
// read: its size is that of the intrinsics. Empty if it does not exist.
std::filesystem::path MeasuredPhotograph(const FrameFiles& files, const std::string& given,
                                         const std::string& where);

// Counts photographs that frames name and that do not exist.
class MissingPhotographs {
 public:
  void Add(const std::string& where, const std::string& given) {
    if (count_++ == 0) first_where_ = where, first_ = given;
  }
  // Throws Error with the number and the first of them.
  void RequireNone(const FrameFiles& files) const;

 private:
  std::size_t count_ = 0;
  std::string first_where_, first_;
};

// Returns the set's own mask, relative to the photographs' folder. Throws if it is missing or leaves `root`.
std::string MaskOfSet(const FrameFiles& files, const std::string& given, const std::string& where);

// Returns the mask of a frame, or "". A mask beside photographs in another folder has precedence: it has
// their size. Throws as MaskOfSet() does.
std::string PathOfMask(const FrameFiles& files, const JsonPlace& frame, const std::string& photograph);

}  // namespace ulf
