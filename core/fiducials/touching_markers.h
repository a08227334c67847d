// Finds markers whose corners touch other dark areas, such as the squares between the tags of an AprilGrid: OpenCV's
// detector takes outlines that touch for one and misses most of them. Here dark areas are shrunk until they part, and
// quadrilaterals among the outlines of what remains are grown back.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/fiducials/marker_detector.h"

namespace ulf {

// Outlines that may be markers, clockwise, to about two pixels, with pixel centres at integer + 0.5; a marker may be
// there more than once. `gray`: CV_8UC1.
std::vector<MarkerImage> DarkQuads(const cv::Mat& gray);

// The markers of a dictionary among the outlines, each number once (that with the fewest wrong cells), corners clockwise from
// the upper left one of OpenCV's picture of the marker, as accurate as the outlines. Throws Refusal for a
// dictionary that does not exist.
std::vector<std::pair<int, MarkerImage>> MarkersAmong(const std::vector<MarkerImage>& quads,
                                                      const cv::Mat& gray, const std::string& dictionary,
                                                      int border_cells);

}  // namespace ulf
