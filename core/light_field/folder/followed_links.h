// Symbolic links in a light field's folder that lead out of it, such as images/ after a move to a larger
// disk. A folder may come from anybody, so nothing is read or written through such a link until the caller
// says so (FollowLinksFromNowOn). What was said is kept in DIR/links.json, for these links of this folder,
// to these places alone: a copy of the folder asks again. A place that belongs to another user than the
// folder is never followed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

inline constexpr const char* kLinksFile = "links.json";

// From now on this process follows the links that it meets, and keeps that in the folders.
void FollowLinksFromNowOn(bool follow = true);

struct OutsideLink {
  std::string link;  // relative to the light field's folder: "images", "images/000007.png"
  // The folder that it leads to, or that holds the file that it leads to; where nothing is there, that place.
  std::filesystem::path target;
  bool is_there = false, is_of_same_owner = false;
};

// The links that lead out of the folder `root` and may not be followed, among its own entries and the files
// of `views`, each once. Links that may be followed from now on are noted in links.json; where that cannot be
// written they are followed all the same.
std::vector<OutsideLink> RefusedLinks(const std::filesystem::path& root, const std::vector<View>& views);

// "images leads to /large/images, outside of the light field; ..." with the way out.
std::string Words(const std::filesystem::path& root, const std::vector<OutsideLink>& refused);

// Throws Error with these words where there are any.
void RequireFollowed(const std::filesystem::path& root, const std::vector<OutsideLink>& refused);

}  // namespace ulf
