// A webcam's Motion JPEG picture as a JPEG file of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace ulf::acquisition {

// The bytes from the start marker to the end marker, with the standard's Huffman tables put in where the
// camera left them out to save room (many do; not every program reads such files). None when either marker is
// missing: then part of the picture never arrived.
std::optional<std::string> StandaloneJpeg(std::span<const std::uint8_t> bytes);

}  // namespace ulf::acquisition
