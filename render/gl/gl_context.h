// An OpenGL 4.5 core context without a window or a display server, through EGL: on the first GPU that
// provides one, otherwise on Mesa's software rasteriser. It can also stand for the caller's context.
#pragma once

#include <string>

namespace ulf::render {

enum class GlContextKind {
  kOwn,      // creates a context
  kCurrent,  // uses this thread's current one, which the caller owns
};

class GlContext {
 public:
  // Throws Error that says what was tried and what to install. A created context is not current yet.
  explicit GlContext(GlContextKind kind = GlContextKind::kOwn);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Makes the context current in this thread; the destructor restores the former. Does nothing for kCurrent.
  class Current {
   public:
    explicit Current(const GlContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

   private:
    void *display_, *previous_display_, *previous_context_, *previous_draw_, *previous_read_;
  };

  const std::string& device() const { return device_; }  // GL_RENDERER
  bool IsSoftware() const;                               // a software rasteriser, no GPU

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;  // null: the caller's
  std::string device_;
};

}  // namespace ulf::render
