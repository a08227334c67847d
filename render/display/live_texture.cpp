#include "render/display/live_texture.h"

#include <epoxy/gl.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <variant>

#include "render/display/painter.h"
#include "render/gl/gl_objects.h"

namespace ulf::render {

LiveTexture::~LiveTexture() { Release(); }

void LiveTexture::Release() {
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  if (texture_) glDeleteTextures(1, &texture_);
  texture_ = framebuffer_ = 0;
}

void LiveTexture::Upload(const cv::Mat& srgb8) {
  if (srgb8.size() != size_) {
    Release();
    size_ = srgb8.size();
    glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
    glTextureStorage2D(texture_, 1, GL_RGBA8, size_.width, size_.height);
    glCreateFramebuffers(1, &framebuffer_);
    glNamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, texture_, 0);
  }
  // Four bytes a pixel, because drivers convert three bytes pixel by pixel.
  cv::cvtColor(srgb8, with_alpha_, cv::COLOR_BGR2RGBA);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(texture_, 0, 0, 0, size_.width, size_.height, GL_RGBA, GL_UNSIGNED_BYTE,
                      with_alpha_.data);
  CheckGl("showing the live picture");
}

void LiveTexture::FillScreen(const cv::Rect2d& area, const cv::Size& screen,
                             const cv::Vec3f& around_rgb) const {
  const auto left = static_cast<int>(std::lround(area.x)), top = static_cast<int>(std::lround(area.y));
  const auto right = static_cast<int>(std::lround(area.x + area.width));
  const auto bottom = static_cast<int>(std::lround(area.y + area.height));
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  glDisable(GL_SCISSOR_TEST);
  if (left > 0 || top > 0 || right < screen.width || bottom < screen.height || empty()) {
    glClearColor(around_rgb[0], around_rgb[1], around_rgb[2], 1);
    glClear(GL_COLOR_BUFFER_BIT);
  }
  if (empty()) return;
  // OpenGL counts rows from below.
  const GLenum filter = right - left == size_.width && bottom - top == size_.height ? GL_NEAREST : GL_LINEAR;
  glBlitNamedFramebuffer(framebuffer_, static_cast<GLuint>(target), 0, 0, size_.width, size_.height, left,
                         screen.height - top, right, screen.height - bottom, GL_COLOR_BUFFER_BIT, filter);
  CheckGl("showing the live picture");
}

PictureWindow::PictureWindow(const std::string& title) : surface_(OpenWindow(title, {960, 720})) {}

bool PictureWindow::Show(const cv::Mat& srgb8) {
  bool goes_on = true;
  for (const InputEvent& event : surface_->TakeEvents(0)) {
    const auto* key = std::get_if<KeyPressed>(&event);
    const auto* typed = std::get_if<Typed>(&event);
    if (std::holds_alternative<CloseAsked>(event) || (key && key->key == Key::kEscape) ||
        (typed && typed->character == U'q'))
      goes_on = false;
    if (key && key->key == Key::kF11) surface_->ToggleFullScreen();
  }
  const cv::Size screen = surface_->Size();
  if (screen.empty()) return goes_on;  // iconified
  surface_->Bind();
  texture_.Upload(srgb8);
  texture_.FillScreen(Placement::Letterboxed(srgb8.size(), screen).Area(), screen, {0, 0, 0});
  surface_->Present();
  return goes_on;
}

}  // namespace ulf::render
