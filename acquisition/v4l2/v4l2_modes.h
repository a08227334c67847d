// Lists the formats, sizes and frame rates that a video node offers, and chooses among them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/v4l2/v4l2_node.h"
#include "core/frames/pixel_format.h"
#include "core/image/image.h"

namespace ulf::acquisition {

// Returns the pixel format of a V4L2 four-character code, and the code of a name ("YUYV", "Mono8" or "GREY").
std::optional<PixelFormat> PixelFormatOfFourcc(std::uint32_t fourcc);
std::optional<std::uint32_t> FourccByName(const std::string& name);
std::string FourccText(std::uint32_t fourcc);

struct V4l2Mode {
  std::uint32_t fourcc = 0;
  PixelFormat format;
  int width = 0, height = 0;
  std::vector<double> fps;  // frames per second, or both limits if `any_fps`; empty: unknown
  bool any_fps = false;

  double FastestFps() const;  // 0: unknown
  bool Offers(double fps_wanted) const;
};

struct V4l2ModeRequest {
  std::optional<std::uint32_t> fourcc = {};
  std::optional<std::pair<int, int>> size = {};
  std::optional<double> fps = {};
};

// Returns every mode of the camera that ulf can read. If the driver accepts any size within limits, these are
// the common sizes within them, the largest, and `also` (width, height).
std::vector<V4l2Mode> V4l2Modes(const V4l2Node& node, std::optional<std::pair<int, int>> also = {});

// Returns the four-character codes of formats that the camera offers and ulf does not read.
std::vector<std::uint32_t> UnreadV4l2Formats(const V4l2Node& node);

// Chooses what the request leaves open: the largest picture up to 1920x1080 at 24 frames per second or more
// (or at the requested rate), else the largest of all, then the best format (PreferredPixelFormat). Throws
// Refusal that lists the modes if the request cannot be met, Error if there are none.
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

// Sets the mode and reads it back; `fps` none: the fastest rate of the mode. Throws Error if the driver sets
// another size, format or requested rate.
V4l2Configured SetV4l2Mode(const V4l2Node& node, const V4l2Mode& mode, std::optional<double> fps);

// Returns the colour encoding and transfer function that the V4L2 fields define for pixels of this format.
YuvEncoding YuvEncodingOf(const v4l2_pix_format& pixels);
Transfer TransferOf(const v4l2_pix_format& pixels);

}  // namespace ulf::acquisition
