#include "render/gl/gl_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <vector>

#include "core/base/error.h"

namespace ulf::render {
namespace {

bool HasExtension(EGLDisplay display, const char* name) { return epoxy_has_egl_extension(display, name); }

// Returns displays to try, GPUs first. It uses the function of EXT, because the core's eglGetPlatformDisplay
// aborts in libepoxy on EGL 1.4 drivers.
std::vector<EGLDisplay> Displays() {
  std::vector<EGLDisplay> displays;
  if (HasExtension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
      HasExtension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count))
      for (EGLint i = 0; i < count; ++i)
        displays.push_back(
            eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], nullptr));
  }
  if (HasExtension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  return displays;
}

EGLContext ContextOn(EGLDisplay display) {
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) return EGL_NO_CONTEXT;
  if (!HasExtension(display, "EGL_KHR_surfaceless_context") || !eglBindAPI(EGL_OPENGL_API))
    return EGL_NO_CONTEXT;
  const EGLint config_request[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, config_request, &config, 1, &count)) return EGL_NO_CONTEXT;
  const EGLint level_request[] = {EGL_CONTEXT_MAJOR_VERSION,
                                  4,
                                  EGL_CONTEXT_MINOR_VERSION,
                                  5,
                                  EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                  EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                  EGL_NONE};
  return eglCreateContext(display, count > 0 ? config : EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, level_request);
}

}  // namespace

GlContext::Current::Current(const GlContext& context)
    : display_(context.display_),
      previous_display_(eglGetCurrentDisplay()),
      previous_context_(eglGetCurrentContext()),
      previous_draw_(eglGetCurrentSurface(EGL_DRAW)),
      previous_read_(eglGetCurrentSurface(EGL_READ)) {
  if (!display_) return;  // the caller's context is current already
  if (previous_context_ != context.context_ &&
      !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_))
    throw Error("OpenGL: the context cannot be made current (EGL error {:#x})", eglGetError());
}

GlContext::Current::~Current() {
  if (!display_) return;
  if (previous_context_ == EGL_NO_CONTEXT)
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  else
    eglMakeCurrent(previous_display_, previous_draw_, previous_read_, previous_context_);
}

GlContext::GlContext(GlContextKind kind) {
  if (kind == GlContextKind::kCurrent) {
    device_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    return;
  }
  for (const EGLDisplay display : Displays()) {
    const EGLContext context = ContextOn(display);
    if (context == EGL_NO_CONTEXT) continue;
    display_ = display;
    context_ = context;
    const Current current(*this);
    device_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    return;
  }
  throw Error(
      "EGL offers no OpenGL 4.5 without a window (neither on a GPU nor on Mesa's software rasteriser); "
      "install libegl-mesa0 libgl1-mesa-dri");
}

bool GlContext::IsSoftware() const {
  const auto is = [&](const char* name) { return device_.find(name) != std::string::npos; };
  return is("llvmpipe") || is("softpipe") || is("SwiftShader");
}

GlContext::~GlContext() {
  // The display stays initialised: other contexts of this process may use it.
  if (context_) eglDestroyContext(display_, context_);
}

}  // namespace ulf::render
