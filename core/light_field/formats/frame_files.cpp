#include "core/light_field/formats/frame_files.h"

#include <algorithm>
#include <utility>

#include "core/base/counted.h"
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

// Returns the file relative to `root`, wherever it lies; none if it does not exist.
std::optional<std::string> PathFrom(const fs::path& root, const std::string& given) {
  std::error_code unknown;
  if (given.empty() || !fs::is_regular_file(root / given, unknown)) return std::nullopt;
  return fs::path(given).is_absolute() ? fs::proximate(given, fs::absolute(root)).generic_string()
                                       : fs::path(given).lexically_normal().generic_string();
}

constexpr const char* kEndings[] = {"", ".png", ".jpg", ".jpeg", ".exr"};

std::string FoundAround(const FrameFiles& files, const std::string& given) {
  for (const SetImages& folder : files.around) {
    // The folder above holds other things than the set.
    const bool is_root = &folder == &files.around.front();
    if (std::string found = is_root ? folder.Find(given) : folder.FindByEnd(given); !found.empty())
      return fs::proximate(folder.folder() / found, files.root).generic_string();
  }
  return {};
}

std::string PathOfCopied(const FrameFiles& files, const std::string& given, const std::string& where) {
  for (const std::string& path : {given, WithSlashes(given)}) {
    for (const char* ending : kEndings)
      if (auto found = PathFrom(files.root, path + ending)) return *std::move(found);
    if (const fs::path raw = RawBeside(files.root / path); !raw.empty())
      return (fs::path(path).parent_path() / raw.filename()).generic_string();
  }
  try {
    return FoundAround(files, given);
  } catch (const Error& error) {
    throw Error("{}: {}", where, error.what());
  }
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

std::string FileOfSet(const FrameFiles& files, const std::string& given, const std::string& where) {
  for (const std::string& path : {given, WithSlashes(given)}) {
    if (files.is_copied()) {
      if (auto found = PathFrom(files.root, path)) return *std::move(found);
      continue;
    }
    if (std::string inside = PathInside(files.root, path, where); fs::is_regular_file(files.root / inside))
      return inside;
  }
  return {};
}

std::string PathOfPhotograph(const FrameFiles& files, const std::string& given, const std::string& where) {
  if (!files.are_read) return given;
  if (files.images) return files.images->Find(given);
  if (files.is_copied()) return PathOfCopied(files, given, where);
  for (const std::string& path : {given, WithSlashes(given)}) {
    for (const char* ending : kEndings) {
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

void MissingPhotographs::Tell(const FrameFiles& files, std::size_t there, bool all_needed,
                              std::vector<std::string>& doubts) const {
  if (count_ == 0) return;
  const std::string folder = (files.images ? files.images->folder() : files.root).string();
  if (files.may_be_poses_alone) {
    doubts.push_back(fmt::format("{}: {} without their photographs left out: poses to be rendered", file_,
                                 Counted(count_, "frame")));
    return;
  }
  if (!all_needed && count_ <= there) {
    doubts.push_back(fmt::format("{}: {} missing in {} and left out ('{}'{})", file_,
                                 Counted(count_, "photograph"), folder, first_,
                                 count_ == 1 ? "" : " is the first"));
    return;
  }
  const std::string which = count_ == 1
                                ? fmt::format("the image '{}' is missing", first_)
                                : fmt::format("the image '{}' and {} more are missing", first_, count_ - 1);
  if (files.images)
    throw Error("{}: {} in {}; give the folder that holds all photographs, or take the frames out",
                first_where_, which, folder);
  throw Error("{}: {} in {}; restore what is missing or take the frames out; {}", first_where_, which, folder,
              kFindByName);
}

fs::path MeasuredPhotograph(const FrameFiles& files, const std::string& given, const std::string& where) {
  for (const std::string& path : {given, WithSlashes(given)})
    for (const char* ending : kEndings)
      if (const auto found = files.is_copied() ? PathFrom(files.root, path + ending)
                                               : PathWithin(files.root, path + ending, where);
          found && fs::is_regular_file(files.root / *found))
        return files.root / *found;
  return {};
}

std::string MaskOfSet(const FrameFiles& files, const std::string& given, const std::string& where) {
  const std::string inside =
      files.is_copied() ? PathOfCopied(files, given, where) : FileOfSet(files, given, where);
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
