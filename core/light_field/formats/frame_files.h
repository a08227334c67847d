// Where the photographs and masks are that the frames of a transforms.json name, and what keeps their paths
// within a folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "core/base/json_fields.h"
#include "core/light_field/formats/posed_set.h"

namespace ulf {

// Resolves symbolic links of `root`/`relative`; returns a '/'-separated path relative to `root`. Throws Error
// when it is outside `root`.
std::string PathInside(const std::filesystem::path& root, const std::string& relative,
                       const std::string& where);

// The file of this name, relative to `root`; empty: it is missing. Throws Error where the name leaves `root`.
std::string FileWithin(const std::filesystem::path& root, const std::string& given, const std::string& where);

// Where the photographs and masks are that frames name.
struct FrameFiles {
  bool are_read = true;                  // else paths are taken as they are written
  bool may_be_resized = false;           // photographs: then their cameras are scaled
  std::filesystem::path root = {};       // they lie here
  std::optional<SetImages> images = {};  // photographs lie here instead
};

// Empty: it is missing. nerfstudio writes paths with their ending, Blender's original NeRF sets without.
std::string PathOfPhotograph(const FrameFiles& files, const std::string& given, const std::string& where);

// The photograph of this name in the set's own folder, where others of it are read; empty: it is not there.
std::filesystem::path MeasuredPhotograph(const FrameFiles& files, const std::string& given,
                                         const std::string& where);

// Photographs that frames name and that are not there.
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

// The set's own mask, relative to where the photographs lie. Throws Error where it is missing or leaves the
// folder.
std::string MaskElsewhere(const FrameFiles& files, const std::string& given, const std::string& where);

// Empty: none. Of photographs that lie elsewhere the mask beside them comes first: it has their size.
std::string PathOfMask(const FrameFiles& files, const JsonPlace& frame, const std::string& photograph);

}  // namespace ulf
