// Finds single ArUco markers of one dictionary in an image, and refines the corners of square markers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ulf {

using MarkerImage = std::array<Eigen::Vector2d, 4>;  // corners in the image, clockwise from the upper left

// Refines the corners of a square marker to about a twentieth of a pixel. Along each side, near the corner,
// the step from dark to bright is located across the side at every pixel; a line is fitted to these steps;
// the lines of two sides intersect in the corner. This works for small markers, where the usual square window
// around the corner would contain cells of the marker or of its neighbour. Lines of at most 24 pixels are
// straight under any lens distortion.
// `gray` is CV_8UC1, display-encoded. `corners` are accurate to one or two pixels; these and the result have
// pixel centres at integer + 0.5. `cells` counts cells along the marker's side, with its border. A corner
// whose sides are not visible, are shorter than 6 pixels or meet more than 3 pixels away stays unchanged.
MarkerImage RefinedBySides(const cv::Mat& gray, const MarkerImage& corners, int cells);

// Returns all markers with their numbers, in no particular order, with corners refined by RefinedBySides().
// Throws Refusal for a dictionary that does not exist.
std::vector<std::pair<int, MarkerImage>> DetectMarkers(const std::string& dictionary, const cv::Mat& gray);

// The next two functions find markers whose corners touch other dark areas, as those of an AprilGrid do:
// OpenCV's detector takes outlines that touch for a single one and misses most of them. Here dark areas are
// eroded until they part, and quadrilaterals among the outlines of what remains are grown back.

// Returns outlines that may be markers, clockwise, accurate to about two pixels, with pixel centres at
// integer + 0.5; a marker may be there more than once. `gray` is CV_8UC1.
std::vector<MarkerImage> DarkQuads(const cv::Mat& gray);

// Returns the markers of a dictionary among the outlines, each number once (the outline with the fewest wrong
// border cells), with corners clockwise from the upper left one of OpenCV's picture of the marker.
// `border_cells` is the width of a marker's dark border. Throws Refusal for a dictionary that does not exist.
std::vector<std::pair<int, MarkerImage>> MarkersAmong(const std::vector<MarkerImage>& quads,
                                                      const cv::Mat& gray, const std::string& dictionary,
                                                      int border_cells);

}  // namespace ulf
