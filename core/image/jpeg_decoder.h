// A webcam's JPEG picture, decoded, and whether all of it came.
//
// A USB packet that is lost leaves a hole in the middle: the picture is shifted or smeared behind it, and
// nothing marks it. Only the decoder notices, when the data end before the picture does (libjpeg warns, and
// fills up). What it also warns of and is whole all the same: many webcams leave some bytes of filling before
// a marker.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>

namespace ulf {

struct DecodedJpeg {
  cv::Size size;       // as its header says; empty: there is none
  cv::Mat bgr;         // 8 bits, where that is the size expected
  std::string damage;  // what is wrong with it, for people; empty: nothing
};
DecodedJpeg DecodeWebcamJpeg(std::span<const std::uint8_t> bytes, cv::Size expected);

}  // namespace ulf
