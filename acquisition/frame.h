// One image as a device delivered it, with all that is known about how it was taken.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/image.h"
#include "acquisition/rigid3.h"

namespace ulf {

// kIncomplete: part of the pixels never arrived; such a frame is counted and shown, never tracked or
// recorded.
enum class FrameStatus { kComplete, kIncomplete };

struct Frame {
  Image image;
  std::uint64_t id = 0;  // the device's own counter
  double device_time_s =
      0;                   // the device's clock, middle of exposure where the device says so, else its start
  double host_time_s = 0;  // seconds since the epoch when the frame reached this machine
  double exposure_s = 0;   // 0: unknown
  double gain = 1;         // linear: 10^(dB/20)
  double black_level = 0;  // as a share of full scale
  FrameStatus status = FrameStatus::kComplete;
  // The file behind the image where it is one already (replay): a light field keeps a camera's JPEG byte for
  // byte.
  std::string source_path;
  // Known without tracking: the simulator's truth, a replayed light field's pose. Never used by a tracker.
  std::optional<Rigid3> known_cam_from_world;
};

}  // namespace ulf
