// Draws charts with gnuplot (Debian package gnuplot-nox), which runs as a child process and reads a script.
#pragma once

#include <string>

namespace ulf::test {

// Returns the text as a quoted string for a gnuplot script.
std::string QuotedForGnuplot(const std::string& text);

// Runs `script` for a picture at `path`, whose ending chooses the format (.svg, .pdf, else PNG); width and
// height are pixels, or 1/100 inch for .pdf. Throws Error where gnuplot is not installed, or with gnuplot's
// message; then no partial picture is left.
void DrawChart(const std::string& path, int width, int height, const std::string& script);

}  // namespace ulf::test
