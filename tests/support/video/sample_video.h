// Writes small videos as cameras, telephones and editors do: any layout of pixels, with the tags asked for.
#pragma once

extern "C" {
#include <libavutil/pixfmt.h>
}

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ulf::test {

struct VideoSample {
  std::string encoder = "ffv1";  // without loss
  AVPixelFormat format = AV_PIX_FMT_YUV420P;
  int width = 64, height = 48, pictures = 5, rate = 25;
  AVColorSpace matrix = AVCOL_SPC_UNSPECIFIED;
  AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
  AVColorPrimaries primaries = AVCOL_PRI_UNSPECIFIED;
  AVColorTransferCharacteristic curve = AVCOL_TRC_UNSPECIFIED;
  int aspect_num = 0, aspect_den = 1;                     // of a pixel; 0: not said
  std::optional<std::array<int, 4>> display_matrix = {};  // a, b, c, d: x' = a x + c y, y' = b x + d y
  int dolby_vision_profile = 0;  // 0: none; 5: its base layer is of no other standard
  int spherical = -1;            // AVSphericalProjection, of a Matroska file; -1: not said
  int stereo = -1;               // AVStereo3DType, of a Matroska file; -1: not said
  bool is_interlaced = false;
  bool drops_key_frames = false;
  std::vector<std::int64_t> times = {};  // of the pictures, in 1/rate s; empty: one after the other
  // Returns the number to store for plane `plane` of picture `number` at x, y of that plane.
  std::function<int(int number, int plane, int x, int y)> value;
};

// The ending of the name chooses the container.
void WriteVideo(const std::filesystem::path& file, const VideoSample& sample);

}  // namespace ulf::test
