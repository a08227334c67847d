// Whether a JPEG or PNG file has its end, told by walking its segments or chunks (ITU T.81, ISO 15948): what
// follows the end does not matter (the film of a motion photo, padding), and an end mark inside a thumbnail
// is none.
#pragma once

#include <filesystem>
#include <string_view>

namespace ulf {

// Of bytes in memory: false where they are no JPEG or the picture's end mark is missing.
bool JpegIsWhole(std::string_view bytes);
// True for other kinds, whose decoders tell. False for what is no regular file.
bool ImageFileIsWhole(const std::filesystem::path& path);

}  // namespace ulf
