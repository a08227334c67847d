// Guards symbolic links that lead out of a light field's folder, such as images/ after a move to a larger
// disk. A folder may come from anybody, so nothing is read or written through such a link until the caller
// permits it (FollowOutsideLinks). The permission is kept in links.json, for these links of this folder to
// these places alone: a copy needs a new one. A place of another user than the folder's is never followed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

inline constexpr const char* kLinksFile = "links.json";

// Permits this process to follow the links that it meets, and to store the permission in their folders.
void FollowOutsideLinks(bool follow = true);

struct OutsideLink {
  std::string link;  // relative to the light field's folder: "images", "images/000007.png"
  // The folder that it leads to, or that holds the file that it leads to; otherwise the missing place itself.
  std::filesystem::path target;
  bool is_there = false, is_of_same_owner = false;
};

// Returns the links that lead out of the folder `root` and may not be followed, among its entries and the
// files of `views`, each once. New permissions are noted in links.json; if that cannot be written, the links
// are followed all the same.
std::vector<OutsideLink> RefusedLinks(const std::filesystem::path& root, const std::vector<View>& views);

// Describes links, of which there is at least one: "the link 'images' leads to /large/images, outside of the
// light field; ...", with the remedy.
std::string Words(const std::filesystem::path& root, const std::vector<OutsideLink>& refused);

// Throws Error with this description if there are any.
void RequireFollowed(const std::filesystem::path& root, const std::vector<OutsideLink>& refused);

}  // namespace ulf
