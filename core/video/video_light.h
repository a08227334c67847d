// How the numbers of a video's pictures mean light: from what the stream says to sRGB or to linear light.
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

// The same layout without the mark of full range, which swscale takes from elsewhere (yuvj420p is yuv420p).
AVPixelFormat WithoutRange(AVPixelFormat format);

class VideoLight {
 public:
  // Throws Error, without the file's name, where the colours are coded in a way that is not understood.
  explicit VideoLight(const AVFrame& frame);

  // Whether the frame's numbers mean the same, so that one conversion serves both.
  bool IsOf(const AVFrame& frame) const;
  void Set(SwsContext& scaler) const;
  // More than 8 bits are kept, and needed: a high dynamic range, or other primaries.
  bool is_deep() const { return is_deep_; }
  Transfer transfer() const { return is_linear_ ? Transfer::kLinear : Transfer::kSrgb; }
  // B, G, R as the scaler gives them (16 bits where deep), to sRGB of 8 bits, or to linear light in float
  // with sRGB's primaries where 1 is the white of a sheet of paper.
  cv::Mat Finished(const cv::Mat& scaled) const;

  const std::vector<std::string>& notes() const { return notes_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void Judge(const AVFrame& frame);
  void MakeCurve();

  AVPixelFormat format_;
  AVColorSpace matrix_, used_matrix_ = AVCOL_SPC_UNSPECIFIED;
  AVColorRange range_;
  AVColorPrimaries primaries_;
  AVColorTransferCharacteristic curve_;
  bool is_rgb_ = false, is_full_ = false, is_deep_ = false, is_linear_ = false;
  int gray_bits_ = 0;                                     // of a grey value in limited range; 0: none such
  cv::Matx33f srgb_from_primaries_ = cv::Matx33f::eye();  // of R, G, B
  std::vector<float> linear_;                             // by 16-bit value
  std::vector<std::string> notes_, warnings_;
};

}  // namespace ulf
