// Hides the differences between OpenCV's versions of ArUco: 4.7 took it out of the contributed modules and
// returns dictionaries and boards as values. These functions return pointers in both. Only the files of
// this folder include this header.
#pragma once

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/core/version.hpp>

namespace ulf {

// `number` is what DictionaryNumber() (board.h) returns.
inline cv::Ptr<cv::aruco::Dictionary> ArucoDictionary(int number) {
#if CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR < 7
  return cv::aruco::getPredefinedDictionary(number);
#else
  return cv::makePtr<cv::aruco::Dictionary>(cv::aruco::getPredefinedDictionary(number));
#endif
}

inline cv::Ptr<cv::aruco::CharucoBoard> CharucoBoard(cv::Size squares, float square, float marker,
                                                     const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
#if CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR < 7
  return cv::aruco::CharucoBoard::create(squares.width, squares.height, square, marker, dictionary);
#else
  return cv::makePtr<cv::aruco::CharucoBoard>(squares, square, marker, *dictionary);
#endif
}

}  // namespace ulf
