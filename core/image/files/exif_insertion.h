// Puts Exif data into the files of pictures without touching their pixels.
#pragma once

#include <optional>
#include <string>

#include "core/image/files/exif.h"

namespace ulf {

// Returns the bytes of a JPEG or PNG with these facts in its Exif data (the APP1 segment, the eXIf chunk);
// what its Exif data say otherwise stays, and nothing changes if they say all that already. Returns none for
// other kinds of files, and if the data are larger than a JPEG's segment holds.
std::optional<std::string> WithExif(const std::string& picture, const ExifFacts& facts);

// Returns what the Exif data in the bytes of a JPEG or PNG say; nothing is set if there are none.
ExifFacts ExifOfPicture(const std::string& picture);

}  // namespace ulf
