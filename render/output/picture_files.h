// Rendered pictures as files: one (OUT.png, OUT.exr), or a folder of numbered ones.
//
// A picture is written under a temporary name and renamed: one that is there is whole. So a render that was
// killed goes on where it stopped when it is started again, and several can fill one folder, each with its
// part of the path. What all pictures of a folder have in common stands in its render.json: a render with
// other settings is refused, or one would get pictures of two.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/image/exr_file.h"
#include "render/scene/renderer.h"

namespace ulf::render {

enum class PictureFormat {
  kPng,    // 8 bits, sRGB
  kPng16,  // 16 bits, sRGB
  kExr,  // linear light: R G B A as halves, Z as float where there is depth, layers confidence and weight.ID
};

struct PictureEncoding {
  PictureFormat format = PictureFormat::kPng;
  double exposure_stops = 0;  // brighter by this, for a display: PNG and video
  ExrCompression exr_compression = ExrCompression::kZip;
};

// The form that a file's or folder's name and `format` ("", "png", "png16" or "exr") ask for; UsageError
// where they contradict each other.
PictureFormat FormatOf(const std::filesystem::path& out, const std::string& format);

bool IsSinglePicture(const std::filesystem::path& out);
bool IsVideo(const std::filesystem::path& out);

std::string PictureBytes(const Rendering& picture, const PictureEncoding& encoding);
// 8-bit display encoding, brighter by `exposure_stops`.
cv::Mat DisplaySrgb8(const cv::Mat& linear, double exposure_stops);

class PictureFiles {
 public:
  // Makes the folder. Throws UsageError when it holds pictures that were rendered with other `settings` (name
  // and value); `overwrite`: all of them are removed, which is said, for render.json speaks for every picture
  // of its folder. UsageError, too, for pictures without a render.json: they are not ours to remove.
  PictureFiles(std::filesystem::path out, const PictureEncoding& encoding,
               const std::map<std::string, std::string>& settings, bool overwrite);
  // Whether the picture is there already and is to stay.
  bool Has(int number) const;
  // Throws DiskFullError or Error; then nothing of this picture stays, and those before do.
  void Write(int number, const Rendering& picture);

 private:
  std::filesystem::path PathOf(int number) const;
  std::filesystem::path out_;
  PictureEncoding encoding_;
  bool overwrite_;
};

}  // namespace ulf::render
