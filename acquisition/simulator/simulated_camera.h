// Simulates a camera in a hand (hand.h or another motion) in front of a simulated scene, with exact poses.
//
// Motion blur: radiance is averaged over as many instants of the exposure as the blur is long in pixels (the
// largest displacement of a grid of image points during the exposure, rounded; 1 to 64). Everything is a pure
// function of the options, the shot and the frame's id.
//
// Mistakes of lens, lamps and automatics are faults (imperfections.h). With the fault `lens` the camera has
// another lens than StoredCamera(), the one of its calibration. With `auto_exposure` the exposure follows the
// pictures of the last half second, measured at few points.
//
// Rolling shutter (`readout_ms=20`): rows are exposed one after the other, the last one `readout_ms` after
// the first, each for the whole exposure; bands of eight rows share one pose. The frame's time and pose are
// those of the middle row, in the middle of its exposure.
//
// Before a turntable (scene `turntable`) the camera is fixed (tripod.h), and what turns is the world: a
// frame's pose is relative to the things on the table, as if these had stood still.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/simulator/hand.h"
#include "acquisition/simulator/scene/ray_caster.h"
#include "acquisition/simulator/sensor.h"
#include "acquisition/simulator/simulated_faults.h"
#include "core/frames/frame.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {

struct SimulationOptions {
  std::string scene = "studio";
  std::uint64_t seed = 7;
  double fps = 15;
  int width = 640, height = 480;
  SensorFormat format = SensorFormat::kRgb8;
  double exposure_s = 0.005;
  double readout_s = 0;  // of a rolling shutter, from the first row to the last; 0: global
  double gain_db = 0;
  bool noise = true;
  double cap_azimuth = Radians(60), cap_elevation = Radians(40);
  double row_spacing = Radians(2.2);
  double speed = Radians(13);  // of azimuth, per second
  double dolly = 1;            // the distance is 1 / dolly to dolly times the scene's own
  bool looks_away = true;
  double duration_s = std::numeric_limits<double>::infinity();
  double sways_from_s = 6, sways_s = 8;  // when the scene's moving parts begin to move, and for how long
  double turn_speed = Radians(24);       // of a turntable, per second
  double unsteady = 0;                   // of its tripod: 1 trembles as a hand does
  SensorColors colors;     // lamp_k=6504&crosstalk=0: what the sensor makes of the scene's colours
  SimulatedFaults faults;  // `fault=drift=0.5`, may be repeated (simulated_faults.h)

  // Parses a URI such as
  //   sim:studio?seed=7&fps=15&width=640&height=480&format=rgb8&exposure_us=5000&readout_ms=0&gain_db=0
  //             &noise=1&cap=60x40&row_deg=2.2&speed_deg_s=13&dolly=1&look_away=1&duration_s=20
  //             &sways_from_s=6&sways_s=8&turn_deg_s=24&unsteady=0
  // Throws Refusal that names an unknown option or a value out of range.
  static SimulationOptions FromUri(const DeviceUri& uri);
  void Validate() const;  // throws Refusal
};

// Returns a moderate wide angle (f = 0.875 widths, 59 degrees), slightly barrel-distorted and off-centre.
CameraModel SimulatedIntrinsics(int width, int height);

struct Shot {
  double open_s = 0;  // start of the (first row's) exposure on the hand's clock
  double exposure_s = 0.005;
  double gain = 1;  // linear
  SensorFormat format = SensorFormat::kRgb8;
  std::uint64_t id = 0;                  // also the seed of the noise
  std::array<double, 3> light{1, 1, 1};  // factors on the lamp's R G B (faults `drift` and `bluer`)
};

class SimulatedCamera {
 public:
  // `hand`: null for the hand that the options describe.
  explicit SimulatedCamera(const SimulationOptions& options,
                           std::shared_ptr<const HandMotion> hand = nullptr);

  const SimulationOptions& options() const { return options_; }
  const CameraModel& camera() const { return caster_.camera(); }
  // Returns the camera of a calibration made before another lens was mounted; else camera().
  CameraModel StoredCamera() const;
  const Scene& scene() const { return caster_.scene(); }
  const HandMotion& hand() const { return *hand_; }
  const RayCaster& caster() const { return caster_; }

  // Captures frame `index` of the free-running camera: opened at index / fps with the options' settings.
  Frame Capture(std::uint64_t index) const;
  // Captures the frame with this exposure, whatever automatic exposure would choose.
  Frame Capture(std::uint64_t index, double exposure_s) const;
  // Captures a shot. Frame::device_time_s (the hand's clock) and known_cam_from_world are those of the middle
  // of the exposure, of a rolling shutter's middle row.
  Frame Capture(const Shot& shot) const;

  // Returns the angle, radians, of what moves in the scene at a time of the hand's clock (Scene::SwayAngle).
  double SwayAngle(double time_s) const;
  // Returns the pose relative to the scene at rest; for a turntable, relative to what turns.
  Rigid3 CamFromRest(double time_s) const;
  // Returns a mask, CV_8UC1, 255 where the middle of a frame's exposure shows what moves in the scene.
  cv::Mat MovingPixels(double time_s) const;

  // Renders the scene at rest without noise, blur and sensor: CV_32FC3, linear B, G, R, on the sensor's scale
  // at the options' exposure and gain.
  cv::Mat CleanLinear(const Rigid3& cam_from_world) const;
  // Returns that image as 8-bit sRGB.
  cv::Mat CleanSrgb(const Rigid3& cam_from_world) const;
  // Returns the factor from RayCaster's radiance to CleanLinear().
  double LightScale() const;

  // Returns the length of an exposure's motion blur in pixels, by the camera's motion and the scene's.
  double BlurPx(double open_s, double exposure_s) const;

 private:
  SimulationOptions options_;
  // Returns the automatic's exposure time at a time.
  double MeteredExposure(double open_s) const;

  RayCaster caster_;
  std::unique_ptr<const RayCaster> meter_;  // of few pixels; null where the exposure is held
  cv::Mat dust_;                            // factors on the light; empty: none
  std::shared_ptr<const HandMotion> hand_;
};

}  // namespace ulf::acquisition
