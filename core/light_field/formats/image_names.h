// Makes unique image names that other programs can read.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace ulf {

// Returns "a/b.jpg" for "images/a/b.jpg", other paths unchanged.
std::string NameInImagesFolder(std::string_view image_path);

// Makes a name for rows whose fields are separated by spaces: white space of any script (Python also splits
// at U+202F), control characters and bytes that are not UTF-8 become '_'.
std::string SafeName(std::string_view name);

// Returns the name, or "name-2.jpg", "name-3.jpg" if the name without its ending is taken. A name that is too
// long for a file system is cut, with a digest of the whole name at its end. Adds the result to `taken`.
std::string UniqueName(const std::string& name, std::set<std::string>& taken);

}  // namespace ulf
