#include "core/light_field/formats/frame_files.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/light_field/formats/raw_beside.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Returns the path with '/' between folders, also from Windows.
std::string WithSlashes(std::string path) {
  std::ranges::replace(path, '\\', '/');
  return path;
}

// Returns a '/'-separated path relative to `root`, with the symbolic links of both followed; none if it
// leaves `root`.
std::optional<std::string> PathWithin(const fs::path& root, const std::string& relative,
                                      const std::string& where) {
  std::error_code unknown;  // for example a name that is too long
  const fs::path canonical_root = fs::weakly_canonical(root);
  const fs::path target = fs::weakly_canonical(canonical_root / relative, unknown);
  if (unknown)
    throw Error("{}: the path '{:.200}' cannot be followed: {}", where, relative, unknown.message());
  const fs::path inside = target.lexically_relative(canonical_root);
  if (relative.empty() || inside.empty() || *inside.begin() == "..") return std::nullopt;
  if (fs::path(relative).is_absolute()) return inside.generic_string();
  return fs::path(relative).lexically_normal().generic_string();
}

constexpr const char* kFindByName =
    "'ulf import SET --images FOLDER -o OUT' finds photographs by their names";

}  // namespace

std::string PathInside(const fs::path& root, const std::string& relative, const std::string& where) {
  if (auto inside = PathWithin(root, relative, where)) return *std::move(inside);
  throw Error(
      "{}: the path '{}' leaves the folder {}, by itself or by a symbolic link; a light field only holds "
      "what lies inside it",
      where, relative, root.string());
}

std::string FileWithin(const fs::path& root, const std::string& given, const std::string& where) {
  for (const std::string& path : {given, WithSlashes(given)})
    if (std::string inside = PathInside(root, path, where); fs::is_regular_file(root / inside)) return inside;
  return {};
}

std::string PathOfPhotograph(const FrameFiles& files, const std::string& given, const std::string& where) {
  if (!files.are_read) return given;
  if (files.images) return files.images->Find(given);
  for (const std::string& path : {given, WithSlashes(given)}) {
    for (const char* ending : {"", ".png", ".jpg", ".jpeg", ".exr"}) {
      const auto inside = PathWithin(files.root, path + ending, where);
      if (!inside)
        throw Error(
            "{}: the path '{}' leaves the folder {}, by itself or by a symbolic link; a light field only "
            "holds what lies inside it; {}",
            where, given, files.root.string(), kFindByName);
      if (fs::is_regular_file(files.root / *inside)) return *inside;
    }
    // Another program made JPEGs of these raw files for the set.
    if (const fs::path raw = RawBeside(files.root / path); !raw.empty())
      return PathInside(files.root, (fs::path(path).parent_path() / raw.filename()).generic_string(), where);
  }
  return {};
}

void MissingPhotographs::RequireNone(const FrameFiles& files) const {
  if (count_ == 0) return;
  const std::string which = count_ == 1
                                ? fmt::format("the image '{}' is missing", first_)
                                : fmt::format("the image '{}' and {} more are missing", first_, count_ - 1);
  if (files.images)
    throw Error("{}: {} in {}; give the folder that holds all photographs, or take the frames out",
                first_where_, which, files.images->folder().string());
  throw Error("{}: {} in {}; restore what is missing or take the frames out; {}", first_where_, which,
              files.root.string(), kFindByName);
}

fs::path MeasuredPhotograph(const FrameFiles& files, const std::string& given, const std::string& where) {
  for (const std::string& path : {given, WithSlashes(given)})
    for (const char* ending : {"", ".png", ".jpg", ".jpeg", ".exr"})
      if (const auto inside = PathWithin(files.root, path + ending, where);
          inside && fs::is_regular_file(files.root / *inside))
        return files.root / *inside;
  return {};
}

std::string MaskOfSet(const FrameFiles& files, const std::string& given, const std::string& where) {
  const std::string inside = FileWithin(files.root, given, where);
  if (inside.empty())
    throw Error("{}: the mask '{}' is missing in {}; restore it or take it out of the frame", where, given,
                files.root.string());
  return files.images ? fs::proximate(files.root / inside, files.images->folder()).generic_string() : inside;
}

std::string PathOfMask(const FrameFiles& files, const JsonPlace& frame, const std::string& photograph) {
  if (files.images)
    if (std::string beside = files.images->MaskOf(photograph); !beside.empty()) return beside;
  if (!frame.Has("mask_path")) return {};
  const std::string given = frame.Text("mask_path");
  return files.are_read ? MaskOfSet(files, given, frame.where) : given;
}

}  // namespace ulf
