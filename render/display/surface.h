// A surface for drawing and input: a window (GLFW), or a picture without a window (EGL). Both use the same
// drawing code. Input events are values, so that a test can simulate the user. While a surface lives, OpenGL
// 4.5 core is current in the thread that made it, which alone may use it. One surface may live at a time.
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
  char32_t character;  // Unicode, as the keyboard's layout gives it
};
struct MouseMoved {
  Eigen::Vector2d at;  // pixels of the framebuffer, from its upper left corner
};
struct MouseButton {
  int button = 0;  // 0 left, 1 right, 2 middle
  bool down = false;
};
struct WheelTurned {
  double steps = 0;  // positive: away from the user
  bool shift = false, control = false;
};
struct CloseAsked {};
using InputEvent = std::variant<KeyPressed, Typed, MouseMoved, MouseButton, WheelTurned, CloseAsked>;

// Reports that the display server has ended, and the surface with it. The program must not use the surface or
// its OpenGL objects again, not even to release them (see Abandon()).
class SurfaceGone : public Error {
 public:
  using Error::Error;
};

// Reports that the display server runs but has cut the connection, as xkill makes it do to close the window.
class SurfaceKilled : public SurfaceGone {
 public:
  using SurfaceGone::SurfaceGone;
};

// Keeps an object until the process ends and never destroys it: for what needs a surface that has gone.
template <typename Thing>
void Abandon(std::unique_ptr<Thing> thing) {
  static auto* const abandoned = new std::vector<Thing*>;
  abandoned->push_back(thing.release());
}

class Surface {
 public:
  virtual ~Surface() = default;
  virtual cv::Size Size() const = 0;        // pixels
  virtual double ContentScale() const = 0;  // pixels per point: 1 on ordinary screens
  // Returns the events since the last call; waits up to `patience_s` for one.
  virtual std::vector<InputEvent> TakeEvents(double patience_s) = 0;
  virtual void Bind() = 0;     // makes this the target of drawing
  virtual void Present() = 0;  // shows what was drawn
  virtual void ToggleFullScreen() = 0;
  // Returns what was drawn since Bind(): CV_8UC3, B, G, R. In a window it is undefined after Present().
  cv::Mat Read();
};

// Opens a window; call it in the process's first thread. `points`: its size in points (ContentScale). Throws
// Error if there is no display, or no OpenGL 4.5 on it. Once the display server has ended, all functions but
// ContentScale() and ToggleFullScreen() throw SurfaceGone. A window that another program has destroyed sends
// CloseAsked with every TakeEvents() and shows nothing.
std::unique_ptr<Surface> OpenWindow(const std::string& title, cv::Size points);

class OffscreenSurface : public Surface {
 public:
  // `size`: pixels. Throws Error without OpenGL 4.5.
  explicit OffscreenSurface(cv::Size size, double content_scale = 1);
  ~OffscreenSurface() override;
  // Adds an event for TakeEvents(), which never waits here.
  void Push(const InputEvent& event) { events_.push_back(event); }
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

// Parses names of keys, separated by commas: "b,comma,Left,Shift+Up". A single character, `comma` or `Space`
// becomes Typed. Left, Right, Up, Down, PageUp (PgUp), PageDown (PgDn), Home, Enter, Escape (Esc), Backspace,
// Delete, F1 and F11 become KeyPressed, with Shift held after "Shift+". Throws Refusal for other names.
std::vector<InputEvent> KeysFromNames(const std::string& names);

}  // namespace ulf::render
