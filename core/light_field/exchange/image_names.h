// Names of images that no other program's reader stumbles over, and that are given once.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace ulf {

// "a/b.jpg" for "images/a/b.jpg".
std::string NameInImagesFolder(std::string_view image_path);

// The name for rows whose fields are parted by spaces: white space of any script (Python parts fields at
// U+202F, too), control characters and bytes that are not UTF-8 become '_'.
std::string SafeName(std::string_view name);

// The name, or "name-2.jpg", "name-3.jpg" where it has been given without its ending already; one that a file
// system would refuse is cut, with a digest of all of it at its end. Adds it to `taken`.
std::string UniqueName(const std::string& name, std::set<std::string>& taken);

}  // namespace ulf
