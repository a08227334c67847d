// Converts a webcam's Motion JPEG picture to a JPEG file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace ulf::acquisition {

// The bytes from the start marker (SOI) to the end marker (EOI), with the Huffman tables of ITU-T T.81, Annex
// K inserted if the camera omitted them (many do; not every program reads such files). None when a marker is
// missing, because part of the picture did not arrive.
std::optional<std::string> StandaloneJpeg(std::span<const std::uint8_t> bytes);

}  // namespace ulf::acquisition
