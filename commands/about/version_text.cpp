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

std::string VersionText() {
  return fmt::format("ulf {}\nbuilt with: {}\nOpenGL: {}", ULF_VERSION, ULF_LIBRARIES, OpenGlText());
}

}  // namespace ulf::commands
