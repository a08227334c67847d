// A photograph for renderers: a pyramid, of which they read one level at a time.
//
// Level 0 is the photograph; each further level is half the size (areas averaged in linear light), with the
// sizes of OpenGL's mipmaps: rounded down, at least one pixel. All photographs of a scene have one of two
// forms:
//
//   CV_8UC3   8-bit sRGB, B G R
//   CV_16FC4  half floats in linear light, B G R and the share of the pixel that has light at all. B G R are
//             multiplied by the share. Pixels of the photograph that are not finite have no light, and
//             clipped ones may have a small share (MakeLinearPyramid).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"

namespace ulf::render {

// Returns the camera with images whose longer side is at most `longest_px`, and no side is below `least_px`.
CameraModel Within(const CameraModel& camera, int longest_px, int least_px = 1);

// All levels, finest first.
using ViewPyramid = std::vector<cv::Mat>;
ViewPyramid MakePyramid(const cv::Mat& srgb8);
// Makes CV_16FC4 levels of a CV_32FC3 image in linear light, which is resized to `size` first if that is
// given. `clipped` marks pixels (not 0) whose share is only kShareOfClipped; empty marks none. A pixel of a
// coarser level is the mean of all light in it, clipped or not, and has the mean of the shares, so that
// clipped areas do not vanish from small pictures.
ViewPyramid MakeLinearPyramid(const cv::Mat& linear, cv::Size size = {}, const cv::Mat& clipped = {});
// The share of clipped pixels is so small that any view with light at a place outweighs clipped ones, and
// large enough to show the place if all are clipped. Guessed.
inline constexpr float kShareOfClipped = 1.0f / 256;

class Photograph {
 public:
  Photograph(const cv::Size& size, bool linear) : size_(size), linear_(linear) {}
  virtual ~Photograph() = default;
  Photograph(const Photograph&) = delete;
  Photograph& operator=(const Photograph&) = delete;

  const cv::Size& size() const { return size_; }
  bool linear() const { return linear_; }  // CV_16FC4
  int type() const { return linear_ ? CV_16FC4 : CV_8UC3; }
  int LevelCount() const;
  cv::Size LevelSize(int level) const;
  std::size_t LevelBytes(int level) const;

  // Returns continuous pixels; callers must not write to them. It may wait for the disk, and several threads
  // may call it. Throws Error for a photograph that is missing, truncated or not of its camera's size.
  virtual cv::Mat Level(int level) const = 0;
  // Returns a digest of the bytes of the files from which the pixels are made, which is the same on every
  // machine while the pixels may differ; for a photograph in memory that of its pixels. Throws as Level()
  // does.
  virtual std::uint64_t ContentDigest() const;

 private:
  cv::Size size_;
  bool linear_;
};

// Returns the photograph without its first `first` levels.
std::shared_ptr<const Photograph> FromLevel(std::shared_ptr<const Photograph> photograph, int first);

}  // namespace ulf::render
