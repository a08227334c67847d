// An OpenGL 4.5 core context without a window or a display server, through EGL: on the first GPU that gives
// one, else on Mesa's software rasteriser. Or the context of whoever calls, a window's.
#pragma once

#include <memory>
#include <string>

namespace ulf::render {

enum class GlContextKind {
  kOwn,      // a context of its own
  kCurrent,  // the one that is current in this thread: it stays so and belongs to others
};

class GlContext {
 public:
  explicit GlContext(
      GlContextKind door = GlContextKind::kOwn);  // throws Error that says what was tried and what to install
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Makes it this thread's context; what was current before is current again when the result goes.
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
  bool IsSoftware() const;                               // and no GPU

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;  // null: others'
  std::string device_;
};

}  // namespace ulf::render
