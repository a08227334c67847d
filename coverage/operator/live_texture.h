// A picture that changes every frame, as an OpenGL texture.
#pragma once

#include <opencv2/core.hpp>

namespace ulf {

class LiveTexture {
 public:
  LiveTexture() = default;
  ~LiveTexture();
  LiveTexture(const LiveTexture&) = delete;
  LiveTexture& operator=(const LiveTexture&) = delete;
  void Upload(const cv::Mat& srgb8);  // 8-bit B, G, R
  unsigned name() const { return texture_; }
  cv::Size size() const { return size_; }

 private:
  void Release();
  unsigned texture_ = 0;
  cv::Size size_;
  cv::Mat with_alpha_;
};

}  // namespace ulf
