// OpenCV's ArUco under one set of names: 4.7 took it out of the contributed modules, and returns dictionaries
// and boards as values. The calls that follow take pointers in both. Only the files of this folder include
// this header.
#pragma once

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/core/version.hpp>

namespace ulf {

// `number` as DictionaryNumber() (board.h) returns it.
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
