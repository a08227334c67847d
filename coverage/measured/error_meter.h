// Measures how well the recorded views predict frames of a running capture
// (render/prediction/frame_predictor.h), as peak signal-to-noise ratio in dB. The meter works in the caller's
// thread, for a share of its time at most, and leaves out frames for which there is no time.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "core/geometry/angles.h"
#include "core/geometry/camera_model.h"
#include "core/image/image.h"
#include "coverage/measured/error_map.h"
#include "render/prediction/frame_predictor.h"
#include "render/prediction/prediction_error.h"

namespace ulf::coverage {

// Converts to 8-bit sRGB, three channels, and reduces the longer side to at most about twice the given one,
// before the conversion, which is much faster. A mosaic that is reduced becomes grey.
cv::Mat SmallSrgb8(const Image& image, int longer_side_px);

class ErrorMeter {
 public:
  struct Options {
    int size_px = 320;             // longer side of the pictures that are compared. Guessed: 10 ms a frame.
    double processor_share = 0.3;  // of the caller's time, for Measure(); MeasureAgain() takes 0.15. Guessed.
    // Every call measures, whatever it costs: for captures whose result must not depend on time.
    bool every_frame = false;
    double good_db = 33;  // better predictions need no cause (CauseOf())
  };
  // A recorded view changes what was measured within this angle of it, seen from the subject. Guessed.
  static constexpr double kViewReach = Radians(8);
  using ReadPicture = std::function<cv::Mat()>;  // returns 8-bit sRGB

  explicit ErrorMeter(const Options& options) : options_(options), maker_(options.size_px) {}

  // `mesh`: of the scene, in world coordinates. Nothing is measured before there is one.
  void SetGeometry(const Subject& subject, std::shared_ptr<const render::TriangleMesh> mesh);
  void AddView(int id, const Image& image, const CameraModel& camera, const Rigid3& cam_from_world);
  // Adds a view of an earlier session, whose picture is read when a frame near the view is measured.
  void AddEarlierView(int id, ReadPicture picture, const CameraModel& camera, const Rigid3& cam_from_world);
  void RemoveView(int id, const Rigid3& cam_from_world);
  // Call it when the lens has changed: drops the geometry, all views and all frames.
  void StartAgain();
  // Corrects the views' poses. Drops the frames kept for MeasureAgain(), whose poses were corrected as well.
  void MoveViews(const std::map<int, Rigid3>& cam_from_world);

  struct Input {
    const Image& image;
    const CameraModel& camera;
    const Rigid3& cam_from_world;
    std::optional<double> center_sigma;  // of the pose, world units
    double time_s = 0;
  };
  // Returns none when there is no geometry or no view yet, or no time.
  std::optional<MeasuredFrame> Measure(const Input& input);
  // Measures an earlier frame around which views were recorded or removed since it was measured. Returns none
  // when there is no such frame, or no time.
  std::optional<MeasuredFrame> MeasureAgain();

 private:
  // A frame that can be measured again.
  struct Kept {
    render::StereoView small;  // its grey values as CV_8U
    std::optional<double> center_sigma;
    double time_s = 0;
    std::uint64_t number = 0;  // the smallest is the oldest
  };
  // Marks frames near a view that was added or removed, to be measured again.
  void MarkStale(const Rigid3& cam_from_world);
  MeasuredFrame MeasureSmall(const render::StereoView& small, std::optional<double> center_sigma,
                             double time_s);
  void Keep(const MeasuredFrame& measured, const render::StereoView& small,
            std::optional<double> center_sigma);

  Options options_;
  std::map<ErrorMap::Key, Kept> kept_;
  std::deque<ErrorMap::Key> stale_;
  std::uint64_t kept_so_far_ = 0;
  std::chrono::steady_clock::time_point rested_again_{};
  render::FramePredictor predictor_;
  render::StereoViewMaker maker_;
  std::chrono::steady_clock::time_point rested_{};
};

}  // namespace ulf::coverage
