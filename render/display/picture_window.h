// A window that shows one picture after another, whole and with its aspect ratio.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "render/display/live_texture.h"
#include "render/display/surface.h"

namespace ulf::render {

class PictureWindow {
 public:
  explicit PictureWindow(const std::string& title);  // throws Error where no window can be opened
  // `srgb8`: 8-bit B, G, R. Returns false once `q`, Escape or the close button has been pressed.
  bool Show(const cv::Mat& srgb8);

 private:
  std::unique_ptr<Surface> surface_;  // first, so that its context outlives the texture
  LiveTexture texture_;
};

}  // namespace ulf::render
