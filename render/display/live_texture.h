// A picture that changes every frame, as an OpenGL texture. Its surface must outlive it.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "render/display/surface.h"

namespace ulf::render {

class LiveTexture {
 public:
  LiveTexture() = default;
  ~LiveTexture();
  LiveTexture(const LiveTexture&) = delete;
  LiveTexture& operator=(const LiveTexture&) = delete;
  void Upload(const cv::Mat& srgb8);  // 8-bit B, G, R
  // Fills the bound framebuffer of size `screen`: the picture in `area` (pixels from the upper left), the
  // colour `around_rgb` (0 to 1) elsewhere. It does not blend, which is slow on software rasterisers.
  void FillScreen(const cv::Rect2d& area, const cv::Size& screen, const cv::Vec3f& around_rgb) const;
  bool empty() const { return texture_ == 0; }  // until the first Upload()

 private:
  void Release();
  unsigned texture_ = 0, framebuffer_ = 0;
  cv::Size size_;
  cv::Mat with_alpha_;
};

// A window that shows one picture after another, whole and with its aspect ratio.
class PictureWindow {
 public:
  explicit PictureWindow(const std::string& title);  // throws Error if no window can be opened
  // `srgb8`: 8-bit B, G, R. Returns false if q, Escape or the close button was pressed. Throws SurfaceGone.
  bool Show(const cv::Mat& srgb8);

 private:
  std::unique_ptr<Surface> surface_;  // first, so that its context outlives the texture
  LiveTexture texture_;
};

}  // namespace ulf::render
