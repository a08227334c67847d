// Where a picture is wrong: its squared error, shared out among kinds of pixels. Each pixel is of the first kind that
// fits.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string_view>

namespace ulf::render {

enum class ErrorKind {
  kUnseen,    // no view of the field sees the point: other views filled the pixel, or nothing did
  kEdge,      // within kEdgePx of where depth jumps
  kTextured,  // elsewhere, where the photograph has texture
  kPlain,     // elsewhere
};
inline constexpr std::array<std::string_view, 4> kErrorKindNames{"unseen", "depth edges", "textured",
                                                                 "plain"};

struct ErrorShares {
  std::array<double, 4> of_error{};  // squared, by ErrorKind; they sum to 1, or are 0 where there is no error
  std::array<double, 4> of_pixels{};  // sum to 1
  double of_worst_hundredth = 0;      // of all error, in the hundredth of the pixels that is worst
};

// Guessed, all of them; they say how the table is divided and change no picture.
struct ErrorShareOptions {
  int edge_px = 4;
  double jump = 0.02;        // of inverse depth, within edge_px: more is an edge
  double texture_grey = 10;  // standard deviation of grey over 5x5 pixels: more is texture
};

// Pictures in 8-bit sRGB; `valid` CV_8U; `depth` CV_32F; `confidence` CV_32F as Rendering has it.
ErrorShares ShareErrors(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid,
                        const cv::Mat& depth, const cv::Mat& confidence,
                        const ErrorShareOptions& options = {});

}  // namespace ulf::render
