// A photograph as a pyramid, of which renderers read one level at a time.
//
// Level 0 is the photograph; each further level is half the size (areas averaged in linear light), with the
// sizes of OpenGL's mipmaps: rounded down, at least one pixel. A scene's photographs have one form of two:
//
//   CV_8UC3   8-bit sRGB, B G R
//   CV_16FC4  half floats in linear light: B G R, premultiplied by the fourth channel, the pixel's share (as
//             alpha). The share is 0 for pixels of the photograph that are masked or not finite, may be
//             kShareOfClipped for clipped ones, and is 1 for others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"

namespace ulf::render {

// Returns the camera scaled down to images whose longer side is at most `longest_px` and whose shorter side
// is at least `least_px`.
CameraModel Within(const CameraModel& camera, int longest_px, int least_px = 1);

// All levels, finest first.
using ViewPyramid = std::vector<cv::Mat>;
// Makes CV_8UC3 levels; the first shares the pixels of `srgb8`.
ViewPyramid MakePyramid(const cv::Mat& srgb8);
// Makes CV_16FC4 levels of a CV_32FC3 image in linear light, which is resized to `size` first if that is
// given. `clipped` (CV_8UC1, as large as `linear`) is not 0 at pixels whose share is to be kShareOfClipped;
// empty: nowhere. A pixel of a coarser level has the unweighted mean light of its area, clipped or not, times
// the mean share, so that clipped areas keep their light in small pictures.
ViewPyramid MakeLinearPyramid(const cv::Mat& linear, cv::Size size = {}, const cv::Mat& clipped = {});
// The share of clipped pixels is so small that an unclipped view of a place outweighs clipped ones, and large
// enough to show the place if all are clipped. Guessed.
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

  // Returns a level (0: the photograph) as a continuous matrix (cv::Mat::isContinuous), to which callers must
  // not write. It may wait for the disk, and several threads may call it. Throws Error for a photograph that
  // is missing, truncated or not of its camera's size.
  virtual cv::Mat Level(int level) const = 0;
  // Returns a digest of the files from which the pixels are made, because decoders of different machines may
  // give different pixels; for a photograph in memory, a digest of its pixels. Throws as Level() does.
  virtual std::uint64_t ContentDigest() const;

 private:
  cv::Size size_;
  bool linear_;
};

// Returns the photograph without its `first` finest levels.
std::shared_ptr<const Photograph> FromLevel(std::shared_ptr<const Photograph> photograph, int first);

}  // namespace ulf::render
