#include "acquisition/aravis/aravis_options.h"

#include <cmath>
#include <cstdio>

#include "acquisition/error.h"
#include "acquisition/pixel_format.h"

namespace ulf {
namespace {

std::optional<int> PositiveInt(const DeviceUri& uri, const std::string& key) {
  const auto number = uri.Number(key);
  if (!number) return std::nullopt;
  if (*number < 1 || *number > 1e6 || *number != std::floor(*number))
    throw UsageError("'{}': {} must be a whole number above 0", uri.Text(), key);
  return static_cast<int>(*number);
}

}  // namespace

AravisOptions AravisOptionsOf(const DeviceUri& uri) {
  uri.AllowOnly({"exposure_us", "gain_db", "fps", "format", "roi", "packet_size", "queue"});
  AravisOptions options{.exposure_us = uri.Number("exposure_us"),
                        .gain_db = uri.Number("gain_db"),
                        .fps = uri.Number("fps"),
                        .format = uri.Option("format"),
                        .region = {},
                        .packet_size = PositiveInt(uri, "packet_size")};
  if (const auto queue = PositiveInt(uri, "queue")) options.queue = static_cast<std::size_t>(*queue);
  if (options.format && !PixelFormatByName(*options.format))
    throw UsageError("'{}': the pixel format {} is not supported; supported are {}", uri.Text(),
                     *options.format, SupportedPixelFormats());
  if (const auto roi = uri.Option("roi")) {
    AravisRegion region;
    char rest = 0;
    if (std::sscanf(roi->c_str(), "%dx%d+%d+%d%c", &region.width, &region.height, &region.x, &region.y,
                    &rest) != 4 ||
        region.width < 1 || region.height < 1 || region.x < 0 || region.y < 0)
      throw UsageError("'{}': roi must read WIDTHxHEIGHT+X+Y, such as 640x480+0+0", uri.Text());
    options.region = region;
  }
  return options;
}

}  // namespace ulf
