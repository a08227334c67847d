// Simulates calibration with known ground truth: `sim:board` and `sim:card`.
//
//   sim:board  a calibration target in a simulated hand: held still in a part of the image, tilted, moved
//              to the next, until every part has been seen with every tilt;
//   sim:card   an evenly lit plain card behind a lens that darkens towards the corners, for the flat field.
//
// The image is sampled by area: 4 x 4 samples between the points at which the rays of a pixel's corners meet
// the board; then lens blur, vignetting and sensor noise. Pixels are linear 8-bit grey. Everything is a pure
// function of the options and the frame number.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "acquisition/device/device.h"
#include "core/fiducials/board.h"

namespace ulf::acquisition {

struct BoardSceneOptions {
  std::optional<Board> board = {};  // none: a plain card
  CameraModel camera = {};
  std::uint64_t seed = 7;
  double noise_levels = 1;  // standard deviation, full scale is 255
  double blur_px = 0.6;     // of the lens, standard deviation
  double vignetting = 0;    // share of the light lost in the image's corner (cos^4 law)
  double gradient = 0;      // of the card's lighting from edge to edge; its direction changes with each frame
  int dust = 0;             // dark spots on the sensor
  double card_level = 0.6;  // share of full scale, in the middle
};

// Returns the lens "pinhole", "barrel" (59 degrees wide), "wide" (100 degrees) or "fisheye" (150 degrees);
// throws Refusal for another name.
CameraModel SimulatedLens(const std::string& name, int width, int height);

// Poses are in millimetres, the board's frame is that of core/fiducials/board.h.
class BoardScene {
 public:
  explicit BoardScene(const BoardSceneOptions& options);
  const BoardSceneOptions& options() const { return options_; }

  // Renders CV_8UC1, linear. `noise_seed` selects the noise and the lighting of a card.
  cv::Mat Render(const Rigid3& cam_from_board, std::uint64_t noise_seed) const;
  // Returns the image without noise: CV_32FC1, 1 is full scale.
  cv::Mat Light(const Rigid3& cam_from_board, std::uint64_t noise_seed) const;
  // Returns the pose: at the `stop`-th place for a share of 0 or below, at the next for 1, between them else.
  Rigid3 HeldAt(std::uint64_t stop, double share) const;
  // Returns the pose at a time: the board rests for half of each stop's time.
  Rigid3 HeldAtTime(double time_s) const;
  // Returns the share of light that reaches the sensor, 1 in the middle, without dust: CV_32FC1.
  const cv::Mat& Vignetting() const { return vignetting_; }

 private:
  Rigid3 Place(std::uint64_t stop) const;
  cv::Mat BoardLight(const Rigid3& cam_from_board) const;
  cv::Mat CardLight(std::uint64_t noise_seed) const;

  BoardSceneOptions options_;
  cv::Mat dark_;  // CV_8UC1: 1 where the board is dark, kCellsPerMm cells per millimetre
  std::vector<Eigen::Vector3f> corner_rays_;  // of pixel corners, row by row; zero where there is none
  cv::Mat vignetting_, dust_;
};

// Reads a URI as below into options of the scene, and the part of the sensor into `window`. Throws Refusal.
BoardSceneOptions BoardSceneFromUri(const DeviceUri& uri, SensorWindow& window);

// Opens `sim:board?board=SPEC&lens=barrel&seed=7&width=640&height=480&fps=15&noise=1&vignetting=0&stops=40`,
// or a card, `sim:card?vignetting=0.4&gradient=0.05&dust=3`, both also with `roi=X,Y,W,H&binning=2` (a part
// of the width x height sensor). Throws Refusal.
std::unique_ptr<Device> OpenSimulatedBoard(const DeviceUri& uri);

}  // namespace ulf::acquisition
