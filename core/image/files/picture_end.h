// Tells whether a JPEG or PNG file has its end, by walking its segments or chunks (ITU T.81, ISO 15948). What
// follows the end (the film of a motion photo, padding) and an end mark inside a thumbnail do not count.
#pragma once

#include <filesystem>
#include <string_view>

namespace ulf {

// Returns whether the bytes are a JPEG with the picture's end mark.
bool JpegIsWhole(std::string_view bytes);
// Returns whether a JPEG or PNG file has its end; true for other kinds, whose decoders tell, and false for
// what is no regular file or shorter than 8 bytes.
bool ImageFileIsWhole(const std::filesystem::path& path);

}  // namespace ulf
