#include "render/display/surface.h"

#include <epoxy/gl.h>
#include <fmt/core.h>
// This must follow OpenGL's own header.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <utility>

#include "render/gl/gl_objects.h"
// This comes last because of its macros.
#include <X11/Xlib.h>
#include <fmt/format.h>
#include <map>
#include <sstream>

// GLFW's own header for these needs more headers of X11. A GLFW that was built for Wayland alone does not
// have them.
extern "C" [[gnu::weak]] Display* glfwGetX11Display();
extern "C" [[gnu::weak]] ::Window glfwGetX11Window(GLFWwindow*);

namespace ulf::render {
namespace {

std::string LastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

std::optional<Key> KeyOf(int glfw_key) {
  static constexpr std::array<std::pair<int, Key>, 14> kKeys{{{GLFW_KEY_ESCAPE, Key::kEscape},
                                                              {GLFW_KEY_ENTER, Key::kEnter},
                                                              {GLFW_KEY_KP_ENTER, Key::kEnter},
                                                              {GLFW_KEY_BACKSPACE, Key::kBackspace},
                                                              {GLFW_KEY_DELETE, Key::kDelete},
                                                              {GLFW_KEY_LEFT, Key::kLeft},
                                                              {GLFW_KEY_RIGHT, Key::kRight},
                                                              {GLFW_KEY_UP, Key::kUp},
                                                              {GLFW_KEY_DOWN, Key::kDown},
                                                              {GLFW_KEY_PAGE_UP, Key::kPageUp},
                                                              {GLFW_KEY_PAGE_DOWN, Key::kPageDown},
                                                              {GLFW_KEY_HOME, Key::kHome},
                                                              {GLFW_KEY_F1, Key::kF1},
                                                              {GLFW_KEY_F11, Key::kF11}}};
  for (const auto& [glfw, key] : kKeys)
    if (glfw == glfw_key) return key;
  return std::nullopt;
}

class Window : public Surface {
 public:
  Window(const std::string& title, cv::Size points) {
    if (!glfwInit()) throw Error("no window: {}", LastGlfwError());
    HandleDisplayServerLoss();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    // The renderers use EGL, and a thread cannot have contexts of EGL and of GLX at the same time.
    for (const int api : {GLFW_EGL_CONTEXT_API, GLFW_NATIVE_CONTEXT_API}) {
      glfwWindowHint(GLFW_CONTEXT_CREATION_API, api);
      window_ = glfwCreateWindow(points.width, points.height, "", nullptr, nullptr);
      if (window_) break;
      RequireServer();
    }
    if (!window_) {
      const std::string reason = LastGlfwError();
      glfwTerminate();
      throw Error("no window with OpenGL 4.5: {}", reason);
    }
    glfwMakeContextCurrent(window_);
    // The title is set after OpenGL: Mesa 22.3 crashes if a server ends while the window gets its OpenGL, and
    // a program that ends servers finds the window by its title.
    glfwSetWindowTitle(window_, title.c_str());
    RequireServer();
    HandleDestroyedWindow();
    glfwSwapInterval(0);  // callers have their own clocks
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
      const auto known = KeyOf(key);
      if (action != GLFW_RELEASE && known)
        WindowOf(window).Push(KeyPressed{*known, (modifiers & GLFW_MOD_SHIFT) != 0});
    });
    glfwSetCharCallback(
        window_, [](GLFWwindow* window, unsigned character) { WindowOf(window).Push(Typed{character}); });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
      WindowOf(window).Push(
          MouseMoved{WindowOf(window).PixelsFromPoints().cwiseProduct(Eigen::Vector2d(x, y))});
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
      WindowOf(window).Push(MouseButton{button, action == GLFW_PRESS});
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double steps) {
      const auto held = [&](int left, int right) {
        return glfwGetKey(window, left) == GLFW_PRESS || glfwGetKey(window, right) == GLFW_PRESS;
      };
      WindowOf(window).Push(WheelTurned{steps, held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT),
                                        held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL)});
    });
    glfwSetWindowCloseCallback(window_, [](GLFWwindow* window) { WindowOf(window).Push(CloseAsked{}); });
  }
  ~Window() override {
    if (gone_) return;
    glfwDestroyWindow(window_);
    glfwTerminate();
    x11_window = 0;
  }

  cv::Size Size() const override {
    cv::Size size;
    glfwGetFramebufferSize(window_, &size.width, &size.height);
    RequireServer();
    if (!destroyed) size_ = size;  // the size of a destroyed window is undefined
    return size_;
  }
  double ContentScale() const override {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::max(0.5f, std::min(x, y));
  }
  std::vector<InputEvent> TakeEvents(double patience_s) override {
    if (patience_s > 0)
      glfwWaitEventsTimeout(patience_s);
    else
      glfwPollEvents();
    RequireServer();
    if (destroyed) Push(CloseAsked{});
    return std::exchange(events_, {});
  }
  void Bind() override {
    const cv::Size size = Size();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, size.width, size.height);
  }
  void Present() override {
    if (!destroyed) glfwSwapBuffers(window_);
    RequireServer();
  }
  void ToggleFullScreen() override {
    if (destroyed) return;
    if (glfwGetWindowMonitor(window_)) {
      glfwSetWindowMonitor(window_, nullptr, windowed_.x, windowed_.y, windowed_.width, windowed_.height, 0);
      return;
    }
    GLFWmonitor* monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
    if (!mode) return;
    glfwGetWindowPos(window_, &windowed_.x, &windowed_.y);
    glfwGetWindowSize(window_, &windowed_.width, &windowed_.height);
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
  }

 private:
  // Without this Xlib ends the process when the display server ends.
  void HandleDisplayServerLoss() {
    Display* display = glfwGetX11Display ? glfwGetX11Display() : nullptr;
    if (!display) return;
    display_name_ = DisplayString(display);
    XSetIOErrorHandler([](Display*) { return 0; });  // the default one prints a fatal error
    XSetIOErrorExitHandler(
        display, [](Display*, void* window) { static_cast<Window*>(window)->gone_ = true; }, this);
  }
  void RequireServer() const {
    if (!gone_) return;
    Display* again = XOpenDisplay(display_name_.c_str());
    if (!again) throw SurfaceGone("the display server has ended");
    XCloseDisplay(again);
    throw SurfaceKilled("the window was closed by force");
  }
  // Without this Xlib ends the process for any request that fails, such as one for a window that another
  // program has destroyed. Call it after the window is made, because GLFW then restores the default.
  void HandleDestroyedWindow() {
    if (!glfwGetX11Display || !glfwGetX11Display() || !glfwGetX11Window) return;
    destroyed = false;
    x11_window = glfwGetX11Window(window_);
    XSetErrorHandler([](Display*, XErrorEvent* error) {
      const bool of_drawable = error->error_code == BadWindow || error->error_code == BadDrawable;
      if (of_drawable && error->resourceid == x11_window) destroyed = true;
      return 0;
    });
  }
  static Window& WindowOf(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }
  void Push(InputEvent event) { events_.push_back(event); }
  // Window coordinates are pixels on some systems and points on others.
  Eigen::Vector2d PixelsFromPoints() const {
    int width = 1, height = 1;
    glfwGetWindowSize(window_, &width, &height);
    const cv::Size pixels = Size();
    return {static_cast<double>(pixels.width) / std::max(1, width),
            static_cast<double>(pixels.height) / std::max(1, height)};
  }

  // It is static, because Xlib's handler gets only the error. There is one window at a time.
  inline static unsigned long x11_window = 0;
  inline static std::atomic<bool> destroyed{false};

  GLFWwindow* window_ = nullptr;
  bool gone_ = false;
  std::string display_name_;
  mutable cv::Size size_;
  cv::Rect windowed_;  // its place before full screen
  std::vector<InputEvent> events_;
};

}  // namespace

cv::Mat Surface::Read() {
  const cv::Size size = Size();
  cv::Mat upside_down(size, CV_8UC3), picture;
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.width, size.height, GL_BGR, GL_UNSIGNED_BYTE, upside_down.data);
  CheckGl("reading the display back");
  cv::flip(upside_down, picture, 0);
  return picture;
}

std::unique_ptr<Surface> OpenWindow(const std::string& title, cv::Size points) {
  return std::make_unique<Window>(title, points);
}

OffscreenSurface::OffscreenSurface(cv::Size size, double content_scale)
    : current_(context_), size_(size), content_scale_(content_scale) {
  Resize(size, content_scale);
}

OffscreenSurface::~OffscreenSurface() { Release(); }

void OffscreenSurface::Release() {
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  if (color_) glDeleteRenderbuffers(1, &color_);
  framebuffer_ = color_ = 0;
}

void OffscreenSurface::Resize(cv::Size size, double content_scale) {
  Release();
  size_ = size;
  content_scale_ = content_scale;
  glCreateRenderbuffers(1, &color_);
  glNamedRenderbufferStorage(color_, GL_RGBA8, size.width, size.height);
  glCreateFramebuffers(1, &framebuffer_);
  glNamedFramebufferRenderbuffer(framebuffer_, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_);
  CheckMade("making the picture to draw into", [&] { Release(); });
}

std::vector<InputEvent> OffscreenSurface::TakeEvents(double) { return std::exchange(events_, {}); }

void OffscreenSurface::Bind() {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, size_.width, size_.height);
}

void OffscreenSurface::Present() { glFinish(); }

namespace {

InputEvent KeyFromName(const std::string& name) {
  static const std::map<std::string, Key> kKeys{{"Left", Key::kLeft},
                                                {"Right", Key::kRight},
                                                {"Up", Key::kUp},
                                                {"Down", Key::kDown},
                                                {"PageUp", Key::kPageUp},
                                                {"PageDown", Key::kPageDown},
                                                {"PgUp", Key::kPageUp},
                                                {"PgDn", Key::kPageDown},
                                                {"Home", Key::kHome},
                                                {"Enter", Key::kEnter},
                                                {"Escape", Key::kEscape},
                                                {"Esc", Key::kEscape},
                                                {"Backspace", Key::kBackspace},
                                                {"Delete", Key::kDelete},
                                                {"F1", Key::kF1},
                                                {"F11", Key::kF11}};
  constexpr char kShift[] = "Shift+";
  if (name.size() == 1) return Typed{static_cast<unsigned char>(name.front())};
  if (name == "comma") return Typed{U','};
  if (name == "Space") return Typed{U' '};
  const bool shift = name.starts_with(kShift);
  const auto key = kKeys.find(shift ? name.substr(sizeof kShift - 1) : name);
  if (key == kKeys.end())
    throw Refusal("there is no key", fmt::format("'{}'", name), "",
                  "there are single characters, comma, Space, and Left, Right, Up, Down, PageUp, PageDown, "
                  "Home, Enter, Escape, Backspace, Delete, F1, F11, also with Shift+");
  return KeyPressed{key->second, shift};
}

}  // namespace

std::vector<InputEvent> KeysFromNames(const std::string& names) {
  std::vector<InputEvent> keys;
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) keys.push_back(KeyFromName(name));
  return keys;
}

}  // namespace ulf::render
