#include "acquisition/v4l2/v4l2_options.h"

#include <cstdio>
#include <set>

#include "core/base/error.h"

namespace ulf::acquisition {

V4l2Options V4l2OptionsOf(const DeviceUri& uri) {
  V4l2Options options;
  std::set<std::string> given;
  for (const auto& [key, value] : uri.options) {
    if (!given.insert(key).second)
      throw Refusal(fmt::format("'{}'", uri.Text()), "", fmt::format("{} is given twice", key), "");
    if (key == "format") {
      options.request.fourcc = FourccByName(value);
      if (!options.request.fourcc)
        throw Refusal(fmt::format("'{}'", uri.Text()), "",
                      fmt::format("ulf does not read the pixel format {} from webcams", value),
                      "use YUYV, NV12 or MJPEG");
    } else if (key == "size") {
      int width = 0, height = 0;
      char rest = 0;
      if (std::sscanf(value.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 || height < 1)
        throw Refusal(fmt::format("'{}'", uri.Text()), "", "size must read WIDTHxHEIGHT, such as 1280x720",
                      "");
      options.request.size = {width, height};
    } else if (key == "fps") {
      options.request.fps = uri.Number(key);
      if (*options.request.fps <= 0)
        throw Refusal(fmt::format("'{}'", uri.Text()), "", "fps must be above 0", "");
    } else if (key == "io") {
      if (value != "mmap" && value != "userptr")
        throw Refusal(fmt::format("'{}'", uri.Text()), "",
                      fmt::format("io must be mmap or userptr, not '{}'", value), "");
      options.io = value == "mmap" ? V4l2Io::kMmap : V4l2Io::kUserPtr;
    } else if (key == "settle") {
      options.settle_s = uri.Number(key, options.settle_s, 0, 60);
    } else if (key == "queue") {
      options.queue = static_cast<std::size_t>(*uri.Whole(key, 1, 1000));
    } else {
      options.controls.emplace_back(key, value);
    }
  }
  return options;
}

}  // namespace ulf::acquisition
