// The header of an OpenEXR file, checked before the library reads it ("OpenEXR file layout", openexr.com):
// the library takes as much memory as lengths and sizes in the header claim, and for known types it ignores
// the length, so that what follows is read from another place than the length says.
#pragma once

#include <string>

namespace ulf {

// Throws Error, which begins with `path`, where an attribute is longer than the file or has another length
// than its type, and where lines or tiles of its pixels would take more memory than the file can stand for
// (RequirePixelsOfFile). What is no OpenEXR file at all passes: the library says so.
void RequireExrHeader(const std::string& path);

[[noreturn]] void RefuseExr(const std::string& path, const char* why);

}  // namespace ulf
