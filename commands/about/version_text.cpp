#include "commands/about/version_text.h"

#include <fmt/core.h>

#include "core/base/error.h"
#include "render/gl/gl_context.h"

namespace ulf::commands {
namespace {

std::string OpenGlText() {
  try {
    const render::GlContext context;
    return context.device();
  } catch (const Error& error) {
    return fmt::format("none: {}", error.what());
  }
}

}  // namespace

std::string VersionText(bool asks_opengl) {
  const std::string text = fmt::format("ulf {}\nbuilt with: {}", ULF_VERSION, ULF_LIBRARIES);
  return asks_opengl ? text + "\nOpenGL: " + OpenGlText() : text;
}

}  // namespace ulf::commands
