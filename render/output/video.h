// Writes 8-bit pictures to a video (.mp4), one picture (.png), or a folder of numbered pictures.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace ulf::render {

class PictureSink {
 public:
  virtual ~PictureSink() = default;
  virtual void Add(const cv::Mat& srgb8) = 0;  // B G R; all pictures of a video have one size
  virtual void Close() = 0;                    // comes last; throws Error if the file is not complete
};

// Opens `out` for writing. OUT.mp4 becomes a video: H.264 if the libraries have it, otherwise MPEG-4, without
// an odd last row or column. It gets its name when it is closed. If the disk is nearly full, Add() closes it
// with the pictures so far, and throws DiskFullError that says how many these are. OUT.png becomes one
// picture, anything else a folder, made if needed, with frame_00000.png and so on. Throws Error or Refusal.
std::unique_ptr<PictureSink> OpenPictureSink(const std::filesystem::path& out, double fps);

}  // namespace ulf::render
