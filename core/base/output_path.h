// Whether a result can be written where it was asked for: found out before the work, not after it.
#pragma once

#include <string>

namespace ulf {

// Throws UsageError when `path` is a folder, or its folder is missing or not writable.
void RequireWritable(const std::string& path);

// The same, and that the ending is a picture's: .png, .jpg or .jpeg.
void RequireWritablePicture(const std::string& path);

// Makes the folder where it is not there yet. Throws UsageError when it cannot be made or written into.
void RequireWritableFolder(const std::string& path);

}  // namespace ulf
