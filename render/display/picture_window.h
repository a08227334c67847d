// A window that shows one picture after the other, whole and in its aspect.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "render/display/live_texture.h"
#include "render/display/surface.h"

namespace ulf::render {

class PictureWindow {
 public:
  explicit PictureWindow(const std::string& title);  // throws Error where there is no window to be had
  // 8-bit B, G, R. False once `q`, Escape or the close button has been pressed.
  bool Show(const cv::Mat& srgb8);

 private:
  std::unique_ptr<Surface> surface_;  // its context outlives the texture
  LiveTexture texture_;
};

}  // namespace ulf::render
