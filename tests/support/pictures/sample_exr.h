// Writes OpenEXR files of layouts that other programs write, with the six patches of sample_pictures.h in
// linear light.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ulf::test {

struct ExrPartLayout {
  std::string name = "part";
  std::vector<std::string> channels = {"R", "G",
                                       "B"};  // which end in R, G, B, Y show the patches; others 0.5
  std::string type = "half";                  // or "float", "uint"
  // Chromaticities x, y of red, green, blue, white, to which the numbers are converted; none: not said.
  std::optional<std::array<float, 8>> primaries = {};
  float alpha = 1;  // of channels that end in A; colours are multiplied by it
  bool tiles = false;
  int panorama = -1;  // the attribute envmap: 0 latitude and longitude, 1 a cube; -1: none
  int origin = 0;     // of both windows, in x and y
  float pixel_aspect = 1;
  std::vector<std::string> views = {};  // the attribute multiView
  int margin = 0;  // the data window is larger than the display window by so many pixels on each side
};
// Writes a plain file of one part, or a file of several parts.
void WriteExrSample(const std::filesystem::path& path, const std::vector<ExrPartLayout>& parts);
// Writes luminance with chroma of half the size (Y, RY, BY). Readers filter chroma over 27 pixels: the
// patches are larger by this factor.
inline constexpr int kLuminanceChromaScale = 4;
void WriteLuminanceChromaExr(const std::filesystem::path& path);

}  // namespace ulf::test
