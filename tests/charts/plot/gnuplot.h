// Draws charts with gnuplot (Debian package gnuplot-nox), which runs as a child process and reads a script.
#pragma once

#include <string>

namespace ulf {

// The text as a quoted string for a gnuplot script.
std::string QuotedForGnuplot(const std::string& text);

// Throws UsageError when `path` cannot be written or does not end in .png, .svg or .pdf, and Error when
// gnuplot is not installed. Commands call it before the work that the chart shows.
void RequireChart(const std::string& path);

// Runs `script` after setting output and terminal (by the ending of `path`); width and height are pixels, or
// 1/100 inch for .pdf. Throws Error with gnuplot's message; then no partial picture is left.
void DrawChart(const std::string& path, int width, int height, const std::string& script);

}  // namespace ulf
