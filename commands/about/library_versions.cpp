#include "commands/about/library_versions.h"

#include <fmt/core.h>

#include <opencv2/core/utility.hpp>

#include "acquisition/aravis/aravis_discovery.h"
#include "acquisition/gphoto2/gphoto_device.h"
#include "core/base/error.h"
#include "core/image/raw_file.h"
#include "render/display/surface.h"
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

// Libraries that can be replaced beside the program are asked; of what was compiled into it, or does not tell, CMake
// knows the version that was there.
std::string VersionText() {
  return fmt::format(
      "ulf {}\nlibraries: Aravis {}, libgphoto2 {}, LibRaw {}, OpenCV {}, GLFW {}\n"
      "built with: OpenGV {}, Ceres {}, CGAL {}, OpenEXR {}, Dear ImGui {}\nOpenGL: {}",
      ULF_VERSION, acquisition::AravisVersion(), acquisition::GphotoVersion(), LibRawVersion(),
      cv::getVersionString(), render::GlfwVersion(), ULF_OPENGV_VERSION, ULF_CERES_VERSION, ULF_CGAL_VERSION,
      ULF_OPENEXR_VERSION, ULF_IMGUI_VERSION, OpenGlText());
}

}  // namespace ulf::commands
