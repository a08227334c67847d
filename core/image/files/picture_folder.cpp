#include "core/image/files/picture_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Recognises what people, cameras and programs keep beside photographs.
bool IsKeptBeside(const fs::path& file) {
  static const std::set<std::string> kEndings = {
      ".txt",  ".md",  ".json", ".jsonl", ".xmp", ".xml", ".csv", ".tsv", ".yaml", ".yml",  ".ini", ".cfg",
      ".log",  ".db",  ".aae",  ".thm",   ".pp3", ".dop", ".cos", ".gpx", ".mrk",  ".nmea", ".url", ".pdf",
      ".html", ".htm", ".npy",  ".npz",   ".ply", ".obj", ".mtl", ".bin", ".out",  ".nvm",  ".sfm", ".lst"};
  return kEndings.contains(Lowercase(file.extension().string()));
}

bool HoldsPictures(const fs::path& folder) {
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder, unknown))
    if (HasImageEnding(entry.path()) && entry.is_regular_file(unknown)) return true;
  return false;
}

// Text files may begin with the letters of some kinds of pictures.
bool HasPlausibleSize(const fs::path& file, PictureKind kind) {
  if (kind == PictureKind::kExr || ReadImageHeader(file.string())) return true;
  std::ifstream stream(file, std::ios::binary);
  const auto size = ClaimedSize(stream);
  constexpr double kMostPx = 1 << 20;
  return size && std::min(size->width, size->height) >= 1 && std::max(size->width, size->height) < kMostPx;
}

std::string CountedFiles(const std::vector<std::string>& names, const std::string& one,
                         const std::string& several) {
  return fmt::format("{} {}", Counted(names.size(), "file"),
                     names.size() == 1 ? "is " + one : "are " + several);
}

}  // namespace

std::string AbbreviatedList(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  return fmt::format("{}{}", fmt::join(names.begin(), names.begin() + std::min(names.size(), kMost), ", "),
                     names.size() > kMost ? ", ..." : "");
}

std::optional<Mismatch> FirstMismatch(const std::vector<std::string>& words) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& each : words) ++counts[each];
  Mismatch found;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (const std::size_t count = counts[words[i]]; count > found.usual_count) found = {0, i, count};
  if (found.usual_count == words.size()) return std::nullopt;
  while (words[found.odd] == words[found.usual]) ++found.odd;
  return found;
}

std::string PictureFolder::LeftOut() const { return fmt::format("{}", fmt::join(left_out, "; ")); }

void RefuseWithoutPictures(const std::string& path, const PictureFolder& folder) {
  if (!folder.left_out.empty())
    throw Error("{}: the folder contains no images that are read: {}", path, folder.LeftOut());
  throw Error("{}: the folder {}; give the one that holds the photographs", path,
              folder.is_empty      ? "is empty"
              : folder.others == 0 ? "contains no images"
                                   : fmt::format("contains no images, only {} other {}", folder.others,
                                                 folder.others == 1 ? "file" : "files"));
}

PictureFolder PicturesIn(const fs::path& folder, const std::set<std::string>& used) {
  PictureFolder found;
  std::map<std::string, std::vector<std::string>> unread;  // by kind
  std::vector<std::string> unnamed, no_pictures, folders;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::error_code unknown;
    found.is_empty = false;
    if (entry.is_directory(unknown) && name[0] != '.' && !used.contains(name) && HoldsPictures(entry.path()))
      folders.push_back(name);
    if (!entry.is_regular_file(unknown)) continue;
    if (HasImageEnding(name) && name[0] != '.') {
      found.pictures.push_back(entry.path());
      continue;
    }
    ++found.others;
    if (name[0] == '.' || IsKeptBeside(name) || used.contains(name)) continue;
    if (const auto words = UnreadPicture(name)) {
      unread[*words].push_back(name);
    } else if (const PictureKind kind = KindOfPicture(entry.path()); IsRead(kind)) {
      (HasPlausibleSize(entry.path(), kind) ? unnamed : no_pictures).push_back(name);
    } else if (kind != PictureKind::kUnknown) {
      unread[WordsOf(kind)].push_back(name);
    } else {
      no_pictures.push_back(name);
    }
  }
  LeaveOutRawTwins(found.pictures);
  std::ranges::sort(found.pictures, [](const fs::path& a, const fs::path& b) {
    return NameOrder(a.filename().string(), b.filename().string());
  });
  for (std::vector<std::string>* names : {&unnamed, &no_pictures, &folders})
    std::ranges::sort(*names, NameOrder);
  for (const auto& [words, names] : unread) found.left_out.push_back(CountedFiles(names, words, words));
  if (!unnamed.empty())
    found.left_out.push_back(
        fmt::format("{} by the first bytes, but not by the ending of the name ({}); rename what belongs "
                    "here, such as to .jpg",
                    CountedFiles(unnamed, "a picture", "pictures"), AbbreviatedList(unnamed)));
  if (!no_pictures.empty())
    found.left_out.push_back(fmt::format("{} that ulf knows ({})",
                                         CountedFiles(no_pictures, "no picture", "no pictures"),
                                         AbbreviatedList(no_pictures)));
  if (!folders.empty())
    found.left_out.push_back(fmt::format("{} inside {} pictures ({})", Counted(folders.size(), "folder"),
                                         folders.size() == 1 ? "holds" : "hold", AbbreviatedList(folders)));
  return found;
}

}  // namespace ulf
