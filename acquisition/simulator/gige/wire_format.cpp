#include "acquisition/simulator/gige/wire_format.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace ulf::acquisition {

void PackImage(const cv::Mat& pixels, const cv::Rect& part, const PixelFormat& format, std::uint8_t* out) {
  const cv::Mat from = pixels(part);
  if (format.bits == 8) {
    CV_Assert(from.type() == CV_8UC(format.channels));
    cv::Mat to(part.height, part.width, from.type(), out);
    if (format.red_first)
      cv::cvtColor(from, to, cv::COLOR_BGR2RGB);
    else
      from.copyTo(to);
    return;
  }
  CV_Assert(from.type() == CV_16UC1);
  const int unused_bits = 16 - format.bits;
  std::uint32_t pending = 0;  // LSB packing: bits that do not fill a byte yet; they continue in the next row
  int pending_bits = 0;
  for (int y = 0; y < part.height; ++y) {
    const auto* row = from.ptr<std::uint16_t>(y);
    for (int x = 0; x < part.width; ++x) {
      const std::uint32_t value = row[x] >> unused_bits;
      if (format.packing == PixelPacking::kLsbPacked) {
        pending |= value << pending_bits;
        pending_bits += format.bits;
        for (; pending_bits >= 8; pending_bits -= 8, pending >>= 8)
          *out++ = static_cast<std::uint8_t>(pending);
      } else if (format.packing == PixelPacking::kWholeBytes) {
        *out++ = static_cast<std::uint8_t>(value);
        *out++ = static_cast<std::uint8_t>(value >> 8);
      } else {
        throw Error("the simulated camera does not send {}", format.name);
      }
    }
  }
  if (pending_bits > 0) *out = static_cast<std::uint8_t>(pending);
}

}  // namespace ulf::acquisition
