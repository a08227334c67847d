#include "coverage/operator/live_texture.h"

#include <epoxy/gl.h>

#include <opencv2/imgproc.hpp>

#include "render/gl_objects.h"

namespace ulf {

LiveTexture::~LiveTexture() { Release(); }

void LiveTexture::Release() {
  if (texture_) glDeleteTextures(1, &texture_);
  texture_ = 0;
}

void LiveTexture::Upload(const cv::Mat& srgb8) {
  if (srgb8.size() != size_) {
    Release();
    size_ = srgb8.size();
    glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
    glTextureStorage2D(texture_, 1, GL_RGBA8, size_.width, size_.height);
    glTextureParameteri(texture_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(texture_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  // Four bytes a pixel: drivers take three one by one.
  cv::cvtColor(srgb8, with_alpha_, cv::COLOR_BGR2RGBA);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(texture_, 0, 0, 0, size_.width, size_.height, GL_RGBA, GL_UNSIGNED_BYTE,
                      with_alpha_.data);
  CheckGl("showing the live picture");
}

}  // namespace ulf
