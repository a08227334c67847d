// OpenEXR files of layouts that other programs write, with the six patches of sample_pictures.h
// in linear light.
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
                                       "B"};  // what ends in R, G, B or Y has the patches; all else 0.5
  std::string type = "half";                  // or "float", "uint"
  std::optional<std::array<float, 8>> primaries =
      {};           // red, green, blue, white; the numbers are converted to them
  float alpha = 1;  // of channels that end in A; colours are multiplied by it
  bool tiles = false;
  int panorama = -1;  // the attribute envmap: 0 latitude and longitude, 1 a cube; -1: none
  int origin = 0;     // of both windows, in x and y
  float pixel_aspect = 1;
  std::vector<std::string> views = {};  // the attribute multiView
  int margin =
      0;  // pixels by which the data window is larger than the display window on each side; negative: smaller
};
// One part is written as a plain file.
void WriteExrSample(const std::filesystem::path& path, const std::vector<ExrPartLayout>& parts);
// Luminance with chroma of half the size (Y, RY, BY), which is filtered over 27 pixels: the patches are
// larger by this factor.
inline constexpr int kLuminanceChromaScale = 4;
void WriteLuminanceChromaExr(const std::filesystem::path& path);

}  // namespace ulf::test
