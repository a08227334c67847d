// A picture that changes every frame, as an OpenGL texture. The context must be current.
#pragma once

#include <opencv2/core.hpp>

namespace ulf::render {

class LiveTexture {
 public:
  LiveTexture() = default;
  ~LiveTexture();
  LiveTexture(const LiveTexture&) = delete;
  LiveTexture& operator=(const LiveTexture&) = delete;
  void Upload(const cv::Mat& srgb8);  // 8-bit B, G, R
  // Fills the bound framebuffer of size `screen`: the picture in `area` (pixels from the upper left), the
  // colour `around_rgb` elsewhere. Without blending, which takes a software rasteriser longer than the
  // picture.
  void FillScreen(const cv::Rect2d& area, const cv::Size& screen, const cv::Vec3f& around_rgb) const;
  bool empty() const { return texture_ == 0; }

 private:
  void Release();
  unsigned texture_ = 0, framebuffer_ = 0;  // to read the texture from
  cv::Size size_;
  cv::Mat with_alpha_;
};

}  // namespace ulf::render
