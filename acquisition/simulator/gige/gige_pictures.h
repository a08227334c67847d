// Makes the frames of the simulated network camera: of a scene from the simulated hand, of a board, or of a
// loop of pictures that are rendered at the start and played forwards and backwards. For one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_camera.h"
#include "core/frames/frame.h"
#include "core/frames/pixel_format.h"

namespace ulf::acquisition {

// The settings on which a picture depends, as a client has written them.
struct GigeSettings {
  std::uint32_t exposure_us = 0, gain_tenths_db = 0;
  std::uint32_t format = 0;  // PFNC
  bool operator==(const GigeSettings&) const = default;
};

class GigePictures {
 public:
  // `loop`: pictures in the loop; 0: every frame is rendered.
  GigePictures(const SimulationOptions& simulation, const std::optional<BoardSceneOptions>& board,
               std::size_t loop);

  // Renders the loop with the settings that the camera starts with, on several cores.
  void RenderLoop();
  // Returns the frame at a time of the hand's motion.
  Frame At(double hand_s, const GigeSettings& now);

  const SimulatedCamera& camera() const { return camera_.value(); }  // not with a board
  CameraModel StoredCamera() const;                                  // the intrinsics of a calibration

 private:
  Frame Capture(double hand_s, const GigeSettings& now, double light_s) const;
  Frame CaptureBoard(double hand_s, const GigeSettings& now) const;

  const SimulationOptions simulation_;
  std::optional<SimulatedCamera> camera_;  // or
  std::optional<BoardScene> board_;
  std::vector<std::optional<Frame>> loop_;
  GigeSettings loop_settings_;
};

// Packs pixels as a machine-vision camera sends them, which pixel_format.h unpacks.

// Writes a part of the image in rows without padding. `pixels`: as in ulf::Image, 8 bits or scaled to 16
// bits; three channels are B, G, R. `out`: room for ImageBytes() of the part.
void PackImage(const cv::Mat& pixels, const cv::Rect& part, const PixelFormat& format, std::uint8_t* out);

}  // namespace ulf::acquisition
