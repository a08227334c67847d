// Charts through gnuplot (Debian package gnuplot-nox), started as a child that reads its script from a file.
#pragma once

#include <string>

namespace ulf {

// As a string in a script.
std::string QuotedForGnuplot(const std::string& text);

// Throws UsageError when `path` cannot be written or does not end in .png, .svg or .pdf, and Error when
// gnuplot is not installed: asked before the work that the chart is to show.
void RequireChart(const std::string& path);

// Runs `script` with terminal (by the ending of `path`) and output set; width and height are pixels, or 1/100
// inch in a .pdf. Throws Error with what gnuplot said; then no half picture stays.
void DrawChart(const std::string& path, int width, int height, const std::string& script);

}  // namespace ulf
