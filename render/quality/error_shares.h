// Splits the squared error of a picture among kinds of pixels. Each pixel is of the first kind that fits; of
// blur, displacement and light, the one that explains most.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string_view>

namespace ulf::render {

enum class ErrorKind {
  kUnseen,     // no view of the field sees the point: other views filled the pixel, or nothing did
  kThin,       // on or beside something near that is at most 8 px wide in the rendering's depth
  kEdge,       // within 4 px of where depth jumps
  kBlurred,    // the rendering is a blurred photograph
  kDisplaced,  // the rendering is the photograph moved by a pixel or less: wrong depth, pose or lens
  kLight,      // the rendering is brighter, darker or of another tint than the photograph
  kOther,      // none of these: double contours, highlights, wrong contents
};
inline constexpr std::size_t kErrorKinds = 7;
inline constexpr std::array<std::string_view, kErrorKinds> kErrorKindNames{
    "unseen", "thin parts", "depth edges", "blurred", "displaced", "light", "other"};

struct ErrorShares {
  std::array<double, kErrorKinds> of_error{};  // squared, by ErrorKind; they sum to 1, or are 0 without error
  std::array<double, kErrorKinds> of_pixels{};  // they sum to 1
  double of_worst_hundredth = 0;                // share of all error in the worst hundredth of the pixels
};

// Pictures are 8-bit sRGB; `valid` is CV_8U, 0 where pixels do not count; the others are Rendering's.
ErrorShares ShareErrors(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid,
                        const cv::Mat& depth, const cv::Mat& confidence);

}  // namespace ulf::render
