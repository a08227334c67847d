// A photograph as renderers read it: a pyramid, one level at a time, from wherever its pixels are.
//
// Levels are the photograph and its halvings (areas averaged in linear light), of OpenGL's mipmap sizes: half
// of the level above, rounded down, at least one. All photographs of a scene have one of two forms:
//   CV_8UC3   8-bit sRGB, B G R
//   CV_16FC4  halves in linear light, B G R and how much of the pixel has light at all, by which B G R are
//             multiplied: where a photograph's numbers are not finite there is none
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace ulf::render {

// All levels, the finest first.
using ViewPyramid = std::vector<cv::Mat>;
ViewPyramid MakePyramid(const cv::Mat& srgb8);
// The second form, of CV_32FC3, made smaller first where another size is given.
ViewPyramid MakeLinearPyramid(const cv::Mat& linear, cv::Size size = {});

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

  // Continuous, not to be written to. Waits for the disk where it must; may be called from several threads.
  // Throws Error for a photograph that is missing, truncated or not of its camera's size.
  virtual cv::Mat Level(int level) const = 0;

 private:
  cv::Size size_;
  bool linear_;
};

// In memory for good.
std::shared_ptr<const Photograph> HoldPhotograph(ViewPyramid pyramid);
// Without its first levels.
std::shared_ptr<const Photograph> FromLevel(std::shared_ptr<const Photograph> photograph, int first);

}  // namespace ulf::render
