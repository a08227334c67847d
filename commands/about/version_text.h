// What `ulf --version` says: what a report of a fault needs.
#pragma once

#include <string>

namespace ulf::commands {

// "ulf 0.1.0" in the first line, then the libraries that it was built with (a Debian release keeps their versions). With
// `asks_opengl` also the renderer that OpenGL has without a window, for which its driver is loaded (some 0.3 s); where there is
// none, the line says why.
std::string VersionText(bool asks_opengl);

}  // namespace ulf::commands
