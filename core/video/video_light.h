// Converts the pictures of a video to sRGB or linear light, as the stream describes them. VideoReader makes a
// VideoLight from the first picture, sets its scaler by it, and converts what the scaler returns.
#pragma once

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixfmt.h>
#include <libswscale/swscale.h>
}

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace ulf {

// Returns the same layout without the mark of full range, which swscale does not use (yuvj420p is yuv420p).
AVPixelFormat WithoutRange(AVPixelFormat format);

class VideoLight {
 public:
  // Throws Error, without the file's name, if the coding of colours is unknown.
  explicit VideoLight(const AVFrame& frame);

  // Returns whether the frame has the same encoding, so that one conversion serves both.
  bool IsOf(const AVFrame& frame) const;
  // Sets the matrix and range by which the scaler converts to B, G, R.
  void Set(SwsContext& scaler) const;
  // Returns whether the scaler must give 16 bits, because of a high dynamic range or other primaries.
  bool is_deep() const { return is_deep_; }
  // Returns the encoding of what ToSrgbOrLinear() returns.
  Transfer transfer() const { return is_linear_ ? Transfer::kLinear : Transfer::kSrgb; }
  // Converts the scaler's B, G, R to CV_8UC3 in sRGB, or for a high dynamic range to CV_32FC3, linear light
  // with sRGB's primaries in which a sheet of white paper is 1.
  cv::Mat ToSrgbOrLinear(const cv::Mat& scaled) const;

  // These are as in VideoFacts.
  const std::vector<std::string>& notes() const { return notes_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void InterpretTags(const AVFrame& frame);
  void MakeCurve();

  AVPixelFormat format_;
  AVColorSpace matrix_, used_matrix_ = AVCOL_SPC_UNSPECIFIED;
  AVColorRange range_;
  AVColorPrimaries primaries_;
  AVColorTransferCharacteristic curve_;
  bool is_rgb_ = false, is_full_ = false, is_deep_ = false, is_linear_ = false;
  int gray_bits_ = 0;                                     // bits of a grey value in limited range, or 0
  cv::Matx33f srgb_from_primaries_ = cv::Matx33f::eye();  // acts on R, G, B
  std::vector<float> linear_;                             // indexed by 16-bit value
  std::vector<std::string> notes_, warnings_;
};

}  // namespace ulf
