// Decodes a JPEG picture of a webcam and tells whether it is complete.
//
// A lost USB packet leaves a gap in the data: the picture is shifted or smeared after it, and nothing marks
// the gap. Only the decoder notices, when the data end before the picture does (libjpeg warns and fills the
// rest). libjpeg also warns of filling bytes before a marker, which many webcams send; such pictures are
// complete.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>

namespace ulf {

struct DecodedJpeg {
  cv::Size size;       // from the header; empty: there is no header
  cv::Mat bgr;         // CV_8UC3; empty where `size` is not the expected one
  std::string damage;  // what is wrong, for messages; empty: nothing
};
DecodedJpeg DecodeWebcamJpeg(std::span<const std::uint8_t> bytes, cv::Size expected);

}  // namespace ulf
