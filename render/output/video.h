// Writes 8-bit pictures to a video (.mp4), one picture (.png), or a folder of numbered pictures.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace ulf::render {

class PictureSink {
 public:
  virtual ~PictureSink() = default;
  virtual void Add(const cv::Mat& srgb8) = 0;  // all of one size
  virtual void Close() = 0;                    // throws Error if the file is not complete
};

// For OUT.mp4 it writes H.264 if the libraries have it, otherwise MPEG-4, and cuts an odd last row or column
// off. The video gets its name when it is complete. If the disk is nearly full it is closed with the pictures
// so far, and DiskFullError says how many these are. For OUT.png it writes one picture, for anything else a
// folder, made if needed, with frame_00000.png and so on. Throws Error or Refusal.
std::unique_ptr<PictureSink> OpenPictureSink(const std::filesystem::path& out, double fps);

}  // namespace ulf::render
