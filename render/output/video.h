// Where pictures for people go: a video (.mp4), one picture (.png), or a folder of numbered ones.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace ulf::render {

class PictureSink {
 public:
  virtual ~PictureSink() = default;
  virtual void Add(const cv::Mat& srgb8) = 0;  // all of one size
  virtual void Close() = 0;                    // throws Error when what was written is not whole
};

// OUT.mp4: H.264 where the libraries have it, else MPEG-4; an odd last row or column is cut off. It gets its
// name when it is whole; when the disk is nearly full it is closed with the pictures there are, and
// DiskFullError says how many. OUT.png: one picture only. Anything else: a folder, made if need be, with
// frame_00000.png and so on. Throws Error or UsageError.
std::unique_ptr<PictureSink> OpenPictureSink(const std::filesystem::path& out, double fps);

}  // namespace ulf::render
