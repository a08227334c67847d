// Checks the header of an OpenEXR file ("OpenEXR file layout", openexr.com) before the library reads it:
// the library allocates as much memory as the header claims, and ignores the stated length of attributes of
// known types, so that it may read later attributes from a wrong place.
#pragma once

#include <string>

namespace ulf {

// Throws an Error that begins with `path` if an attribute is longer than the file or has another length than
// its type, or if lines or tiles of its pixels would need more memory than the file can justify
// (RequirePixelsOfFile). Files that are no OpenEXR pass: the library reports them.
void RequireExrHeader(const std::string& path);

// Throws an Error that says that the file is truncated or damaged, why, and the remedy.
[[noreturn]] void RefuseExr(const std::string& path, const char* why);

}  // namespace ulf
