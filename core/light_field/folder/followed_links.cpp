#include "core/light_field/folder/followed_links.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/light_field.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::atomic<bool> follow_from_now_on{false};

// Entries of a light field's folder beside the files that its journal names.
constexpr const char* kOwnEntries[] = {"journal.jsonl",
                                       "transforms.json",
                                       "sparse",
                                       "sparse/0",
                                       "images",
                                       "masters",
                                       "masks",
                                       "exposures",
                                       "merged",
                                       "unposed",
                                       "kept",
                                       "cache",
                                       "depth",
                                       "cache/pyramids",
                                       "points.ulf",
                                       "points.ply",
                                       "proxy.ply",
                                       kLinksFile,
                                       "depth/maps.json",
                                       "cache/map.ulf",
                                       "sparse/0/cameras.txt",
                                       "sparse/0/images.txt",
                                       "sparse/0/points3D.txt"};

std::optional<struct stat> StatusOf(const fs::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? std::optional(status) : std::nullopt;
}

bool IsInside(const fs::path& canonical_root, const fs::path& canonical) {
  const fs::path relative = canonical.lexically_relative(canonical_root);
  return !relative.empty() && *relative.begin() != "..";
}

// Returns where the link leads, also if nothing is there.
fs::path TargetOf(const fs::path& link) {
  std::error_code unknown;
  const fs::path target = fs::canonical(link, unknown);
  if (!unknown) return target;
  const fs::path said = FolderOf(link) / fs::read_symlink(link, unknown);
  const fs::path named = fs::weakly_canonical(said, unknown);
  return unknown ? fs::absolute(said).lexically_normal() : named;  // a link to itself
}

// Finds links that lead out of the folder. Each folder is read once, however many files it holds.
class LinkFinder {
 public:
  explicit LinkFinder(const fs::path& root) : root_(root), canonical_root_(fs::weakly_canonical(root)) {
    const auto status = StatusOf(root);
    if (status) owner_ = status->st_uid;
  }

  // `path` is relative to the folder.
  void Look(const fs::path& path) {
    const fs::path folder = path.parent_path();
    if (!folder.empty() && !LeadsInside(folder)) return;
    std::error_code unknown;
    if (!fs::is_symlink(fs::symlink_status(root_ / path, unknown))) return;
    const fs::path target = TargetOf(root_ / path);
    if (IsInside(canonical_root_, target)) return;
    const bool is_file = fs::exists(target, unknown) && !fs::is_directory(target, unknown);
    Add(path, is_file ? target.parent_path() : target, target);
  }

  std::map<std::string, OutsideLink> found;

 private:
  bool LeadsInside(const fs::path& folder) {
    const auto known = is_inside_.find(folder);
    if (known != is_inside_.end()) return known->second;
    Look(folder);
    std::error_code unknown;
    const fs::path target = fs::weakly_canonical(root_ / folder, unknown);
    return is_inside_[folder] = !unknown && IsInside(canonical_root_, target);
  }

  void Add(const fs::path& path, const fs::path& folder, const fs::path& target) {
    const auto of_folder = StatusOf(folder), of_target = StatusOf(target);
    const bool is_of_same_owner =
        of_folder && owner_ && of_folder->st_uid == *owner_ && of_target && of_target->st_uid == *owner_;
    found.emplace(path.generic_string(),
                  OutsideLink{path.generic_string(), folder, of_target.has_value(), is_of_same_owner});
  }

  fs::path root_, canonical_root_;
  std::optional<uid_t> owner_;
  std::map<fs::path, bool> is_inside_;
};

// Identifies the folder and the place by numbers that nobody who makes a folder for others knows.
json Entry(const fs::path& root, const OutsideLink& link) {
  const auto of_root = StatusOf(root), of_target = StatusOf(link.target);
  return {{"link", link.link},
          {"target", link.target.string()},
          {"folder_inode", of_root ? of_root->st_ino : 0},
          {"target_inode", of_target ? of_target->st_ino : 0}};
}

// Returns the entries of links.json; none if it cannot be read.
json FollowedIn(const fs::path& root) {
  const fs::path file = root / kLinksFile;
  std::error_code unknown;
  if (!fs::is_regular_file(fs::symlink_status(file, unknown))) return json::array();
  try {
    const json content = JsonOrDiscarded(ReadWholeFile(file));
    if (content.is_object() && content.contains("follow") && content["follow"].is_array())
      return content["follow"];
  } catch (const Error&) {
  }
  return json::array();
}

void Keep(const fs::path& root, const json& followed) {
  try {
    WriteFileAtomically(root / kLinksFile, JsonText(json{{"follow", followed}}, 1) + "\n");
  } catch (const Error&) {
    // For a folder that is not writable, the permission must be given again.
  }
}

}  // namespace

void FollowOutsideLinks(bool follow) { follow_from_now_on = follow; }

std::vector<OutsideLink> RefusedLinks(const fs::path& root, const std::vector<View>& views) {
  LinkFinder finder(root);
  for (const char* entry : kOwnEntries) finder.Look(entry);
  std::error_code none;
  for (const char* folder : {"depth", "unposed"})
    for (const auto& file : fs::directory_iterator(root / folder, none))
      finder.Look(folder / file.path().filename());
  for (const View& view : views) {
    for (const std::string& file : FilesOf(view)) finder.Look(file);
    if (!view.mask_path.empty()) finder.Look(view.mask_path);
  }
  std::vector<OutsideLink> refused;
  if (finder.found.empty()) return refused;
  json followed = FollowedIn(root);
  const std::size_t before = followed.size();
  for (const auto& [name, link] : finder.found) {
    const json entry = Entry(root, link);
    if (link.is_of_same_owner && std::ranges::find(followed, entry) != followed.end()) continue;
    if (link.is_of_same_owner && follow_from_now_on)
      followed.push_back(entry);
    else
      refused.push_back(link);
  }
  if (followed.size() != before) Keep(root, followed);
  return refused;
}

void RequireFollowed(const fs::path& root, const std::vector<OutsideLink>& refused) {
  if (!refused.empty()) throw Error("{}", Words(root, refused));
}

std::string Words(const fs::path& root, const std::vector<OutsideLink>& refused) {
  const OutsideLink& first = refused.front();
  std::string words = fmt::format("{}: the link '{}' leads to {}, outside of the light field", root.string(),
                                  first.link, first.target.string());
  if (refused.size() > 1) words += fmt::format(" (and {} more do)", refused.size() - 1);
  if (!std::ranges::all_of(refused, &OutsideLink::is_there))
    return words + ", which is not there: connect that disk, or put the files back";
  const bool may_be_followed = std::ranges::all_of(refused, &OutsideLink::is_of_same_owner);
  return words + (may_be_followed
                      ? fmt::format("; nothing was read or written through it: say {} once, which the folder "
                                    "keeps, or move the files back",
                                    Parameter("follow_links"))
                      : "; it belongs to another user than the light field and is not followed: move the "
                        "files back, or make both your own");
}

}  // namespace ulf
