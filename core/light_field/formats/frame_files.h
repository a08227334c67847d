// Finds the photographs and masks that the frames of a transforms.json name, and keeps their paths within a
// folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "core/base/json_fields.h"
#include "core/light_field/formats/posed_set.h"

namespace ulf {

// Resolves symbolic links of `root`/`relative`; returns a '/'-separated path relative to `root`. Throws Error
// if it is outside `root`.
std::string PathInside(const std::filesystem::path& root, const std::string& relative,
                       const std::string& where);

// Returns the file's path relative to `root`, or "" if missing. Throws Error if the name leaves `root`.
std::string FileWithin(const std::filesystem::path& root, const std::string& given, const std::string& where);

// Says where the photographs and masks of frames are.
struct FrameFiles {
  bool are_read = true;                  // if false, paths are taken as they are written
  bool may_be_resized = false;           // photographs may be resized; then their cameras are scaled
  std::filesystem::path root = {};       // the folder that frames' paths are relative to
  std::optional<SetImages> images = {};  // if set, the photographs' folder instead of `root`
};

// Returns "" if missing. nerfstudio writes paths with their ending, Blender's original NeRF sets without.
std::string PathOfPhotograph(const FrameFiles& files, const std::string& given, const std::string& where);

// Returns the photograph in the set's own folder although others are read; empty if it does not exist.
std::filesystem::path MeasuredPhotograph(const FrameFiles& files, const std::string& given,
                                         const std::string& where);

// Counts photographs that frames name and that do not exist.
class MissingPhotographs {
 public:
  void Add(const std::string& where, const std::string& given) {
    if (count_++ == 0) first_where_ = where, first_ = given;
  }
  void RequireNone(const FrameFiles& files) const;

 private:
  std::size_t count_ = 0;
  std::string first_where_, first_;
};

// Returns the set's own mask, relative to the photographs' folder. Throws Error if it is missing or leaves
// the folder.
std::string MaskOfSet(const FrameFiles& files, const std::string& given, const std::string& where);

// Returns "" if there is none. A mask beside photographs in another folder has precedence: it has their size.
std::string PathOfMask(const FrameFiles& files, const JsonPlace& frame, const std::string& photograph);

}  // namespace ulf
