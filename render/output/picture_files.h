// Writes rendered pictures to files: one picture (OUT.png, OUT.exr), or a folder of numbered pictures.
//
// A picture is written under a temporary name and renamed, so that every picture in the folder is complete. A
// render that was killed therefore continues when it is started again, and several renders can fill one
// folder, each with a part of the path. The folder's render.json holds the settings that all its pictures
// have in common. A render with other settings is refused, because it would mix two renders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/image/files/exr_file.h"
#include "render/renderer/renderer.h"

namespace ulf::render {

enum class PictureFormat {
  kPng,    // 8 bits, sRGB
  kPng16,  // 16 bits, sRGB
  // Linear light: R G B A as half floats, Z as float if there is depth, layers confidence and weight.ID.
  kExr,
};

struct PictureEncoding {
  PictureFormat format = PictureFormat::kPng;
  double exposure_stops = 0;  // makes PNG and video brighter; EXR keeps the light
  // The colour (B G R, 0 to 1 in PNG's encoding) behind a picture with alpha; none: PNG and EXR keep the
  // alpha.
  std::optional<cv::Vec3d> background = {};
  bool closes_narrow_gaps = true;  // in PNG and video (WithNarrowGapsClosed())
  ExrCompression exr_compression = ExrCompression::kZip;
  bool knows_colors = true;  // RenderScene::knows_colors: an EXR may name its colour space
};

// Returns the format by the name of a file or folder and by `format` ("", "png", "png16" or "exr"). Throws
// Refusal if they contradict each other, or for a file of another ending.
PictureFormat FormatOf(const std::filesystem::path& out, const std::string& format);

bool IsSinglePicture(const std::filesystem::path& out);  // by its ending, .png or .exr
bool IsVideo(const std::filesystem::path& out);          // by its ending, .mp4

std::string PictureBytes(const Rendering& picture, const PictureEncoding& encoding);  // a file's content
// Returns the picture for a display, 8-bit sRGB, over the background or over black.
cv::Mat DisplayPicture(const Rendering& picture, const PictureEncoding& encoding);
// Returns 8-bit sRGB, brighter by `exposure_stops`.
cv::Mat DisplaySrgb8(const cv::Mat& linear, double exposure_stops);

// Estimates the bytes that rendering and encoding a picture take.
std::uint64_t MemoryForPicture(int width, int height, const PictureEncoding& encoding);
// Throws Error that says how much memory is needed and how much is available.
void RequireMemory(int width, int height, const PictureEncoding& encoding, std::uint64_t available);

// Throws the Refusals of PictureFiles() before its settings are all known, by those that are `known` and by
// the first words of others. Makes nothing.
void RequireFolderFor(const std::filesystem::path& out, std::map<std::string, std::string> known,
                      const std::map<std::string, std::string>& beginnings, bool overwrite);

class PictureFiles {
 public:
  // Makes the folder. `settings` are names and values for render.json. Throws Refusal if the folder holds
  // pictures of other settings; with `overwrite` it removes all of them instead, with a warning, because
  // render.json is valid for every picture of the folder. Throws Refusal also for pictures without a
  // render.json, which may be of another program.
  PictureFiles(std::filesystem::path out, const PictureEncoding& encoding,
               const std::map<std::string, std::string>& settings, bool overwrite);
  // Returns whether the picture exists in the folder and is to be kept (no `overwrite`).
  bool Has(int number) const;
  // Throws DiskFullError or Error; then nothing of this picture remains, and all other pictures do.
  void Write(int number, const Rendering& picture);

 private:
  std::filesystem::path PathOf(int number) const;
  std::filesystem::path out_;
  PictureEncoding encoding_;
  bool overwrite_;
};

// Narrow gaps that no photograph shows, mostly along a picture's border, get the colour beside them instead
// of black for displays and comparisons. Wider ones stay black, since their content is unknown. A gap is wide
// if one of its pixels is farther than this share of the longer side from what is drawn. Guessed.
inline constexpr double kNarrowGapShare = 0.03;

// `linear` and `drawn` are those of Rendering. A picture without gaps is returned unchanged.
cv::Mat WithNarrowGapsClosed(const cv::Mat& linear, const cv::Mat& drawn);

}  // namespace ulf::render
