// What is drawn on and where input comes from: a window (GLFW), or a picture without one (EGL). The same
// drawing code serves both; input is values, so that a test plays a person. OpenGL 4.5 core is current in the
// caller's thread as long as a surface lives; one at a time.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "render/gl/gl_context.h"

namespace ulf::render {

enum class Key {
  kEscape,
  kEnter,
  kBackspace,
  kDelete,
  kLeft,
  kRight,
  kUp,
  kDown,
  kPageUp,
  kPageDown,
  kHome,
  kF1,
  kF11
};
struct KeyPressed {
  Key key;
  bool shift = false;
};
struct Typed {
  char32_t character;  // whatever the keyboard's layout
};
struct MouseMoved {
  Eigen::Vector2d at;  // pixels of the framebuffer
};
struct MouseButton {
  int button = 0;  // 0 left, 1 right
  bool down = false;
};
struct WheelTurned {
  double steps = 0;  // away from the person: positive
  bool shift = false, control = false;
};
struct CloseAsked {};
using InputEvent = std::variant<KeyPressed, Typed, MouseMoved, MouseButton, WheelTurned, CloseAsked>;

// The display server has ended and took the surface with it: neither that nor anything of its OpenGL may be
// touched again, not even to be given back.
class SurfaceGone : public Error {
 public:
  using Error::Error;
};

// The display server lives, but has cut the connection (xkill does that): somebody wanted the window closed.
class SurfaceKilled : public SurfaceGone {
 public:
  using SurfaceGone::SurfaceGone;
};

// What may not even be given back is kept to the end of the process.
template <typename Thing>
void Abandon(std::unique_ptr<Thing> thing) {
  static auto* const abandoned = new std::vector<Thing*>;
  abandoned->push_back(thing.release());
}

class Surface {
 public:
  virtual ~Surface() = default;
  virtual cv::Size Size() const = 0;        // pixels
  virtual double ContentScale() const = 0;  // pixels a point: 1 on ordinary screens
  // What has come since the last call; waits up to `patience_s` for something to come.
  virtual std::vector<InputEvent> TakeEvents(double patience_s) = 0;
  virtual void Bind() = 0;  // drawing goes here, into all of it
  virtual void Present() = 0;
  virtual void ToggleFullScreen() = 0;
  cv::Mat Read();  // what has been drawn since Bind(), 8-bit B, G, R
};

// Throws Error where there is no display, or no OpenGL 4.5 on it. Whatever is asked of the window throws
// SurfaceGone once its display server has ended. A window that another program destroys asks to be closed, as
// by its button, and goes on asking; what is drawn then is seen by nobody.
std::unique_ptr<Surface> OpenWindow(const std::string& title, cv::Size points);

class OffscreenSurface : public Surface {
 public:
  explicit OffscreenSurface(cv::Size size, double content_scale = 1);
  ~OffscreenSurface() override;
  void Push(InputEvent event) { events_.push_back(event); }
  void Resize(cv::Size size, double content_scale);

  cv::Size Size() const override { return size_; }
  double ContentScale() const override { return content_scale_; }
  std::vector<InputEvent> TakeEvents(double patience_s) override;
  void Bind() override;
  void Present() override;
  void ToggleFullScreen() override { full_screen_ = !full_screen_; }
  bool full_screen() const { return full_screen_; }

 private:
  void Release();
  GlContext context_;
  GlContext::Current current_;
  cv::Size size_;
  double content_scale_;
  bool full_screen_ = false;
  unsigned framebuffer_ = 0, color_ = 0;
  std::vector<InputEvent> events_;
};

}  // namespace ulf::render
