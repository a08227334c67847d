// What a video node can send (formats, sizes, frame rates) and what is chosen of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/v4l2/v4l2_node.h"
#include "core/image/image.h"
#include "core/image/pixel_format.h"

namespace ulf::acquisition {

// A kernel's four-character code as a pixel format, and back by either name ("YUYV", "Mono8" or "GREY").
std::optional<PixelFormat> PixelFormatOfFourcc(std::uint32_t fourcc);
std::optional<std::uint32_t> FourccByName(const std::string& name);
std::string FourccText(std::uint32_t fourcc);

struct V4l2Mode {
  std::uint32_t fourcc = 0;
  PixelFormat format;
  int width = 0, height = 0;
  std::vector<double> fps;  // offered, or the two ends where `any_fps`; empty: the driver does not say
  bool any_fps = false;

  double FastestFps() const;  // 0: unknown
  bool Offers(double fps_wanted) const;
};

struct V4l2ModeRequest {
  std::optional<std::uint32_t> fourcc = {};
  std::optional<std::pair<int, int>> size = {};
  std::optional<double> fps = {};
};

// Every supported mode. Where a driver takes any size within limits, the usual sizes within them and `also`.
std::vector<V4l2Mode> V4l2Modes(const V4l2Node& node, std::optional<std::pair<int, int>> also = {});

// Kernel's codes of what the camera sends and this program does not read.
std::vector<std::uint32_t> UnreadV4l2Formats(const V4l2Node& node);

// What was not asked for: the largest picture up to 1920x1080 that comes at 24 frames a second or more (or
// at the rate asked for), then the best format (PreferredPixelFormat). Throws UsageError listing what there
// is when a request cannot be met.
V4l2Mode ChooseV4l2Mode(const std::string& uri, const std::vector<V4l2Mode>& modes,
                        const V4l2ModeRequest& request);

struct V4l2Configured {
  PixelFormat format;
  int width = 0, height = 0;
  BytesLayout layout;
  std::size_t image_bytes = 0;  // of a buffer
  Transfer transfer = Transfer::kSrgb;
  double period_s = 0;  // 0: unknown
};

// Sets the mode and reads back what the driver made of it. Throws Error when that is another size or format.
V4l2Configured SetV4l2Mode(const V4l2Node& node, const V4l2Mode& mode, std::optional<double> fps);

// What the kernel's colour fields mean for pixels of this format.
YuvEncoding YuvEncodingOf(const v4l2_pix_format& pixels);
Transfer TransferOf(const v4l2_pix_format& pixels);

}  // namespace ulf::acquisition
