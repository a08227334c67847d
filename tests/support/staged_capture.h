// Stages a capture as the operator display sees it: a simulated camera stands where a test puts it, views are
// recorded when the test says so, and the states are those that a session would publish.
#pragma once

#include <memory>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"
#include "coverage/session/capture_state.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct StageOptions {
  int width = 640, height = 480;
  bool rendered = false;  // live pictures are ray cast; else an even grey
  std::optional<Cap> cap = Cap{60 * M_PI / 180, 40 * M_PI / 180};
  double threshold_px = 12;
};

class StagedCapture {
 public:
  static constexpr int kGrey = 128;
  explicit StagedCapture(const StageOptions& options = {});

  const CameraModel& camera() const { return simulated_.camera(); }
  const Subject& subject() const { return subject_; }
  // Returns the pose of a camera at these angles about the first direction, at `distance` from the subject's
  // centre, aimed at a point off the centre by `aside` (world units to the camera's right, and down).
  Rigid3 CameraAt(double azimuth_deg, double elevation_deg, double distance = 1,
                  const Eigen::Vector2d& aside = Eigen::Vector2d::Zero()) const;

  // Returns the state of a tracked camera with this pose.
  std::shared_ptr<CaptureState> At(const Rigid3& cam_from_world) const;
  // Records a view there and returns the state of its frame.
  std::shared_ptr<CaptureState> Record(const Rigid3& cam_from_world);
  // Records rows of views over a part of the cap.
  void RecordRows(double from_azimuth_deg, double to_azimuth_deg, double from_elevation_deg,
                  double to_elevation_deg, double step_deg, double distance = 1);
  std::shared_ptr<CaptureState> Lost() const;
  void TakeBack(int id);
  void PlaceSubject(const Subject& subject);

  const std::vector<std::shared_ptr<const CaptureState>>& recorded() const { return recorded_; }

 private:
  StageOptions options_;
  const SimulatedCamera& simulated_;
  Subject subject_;
  CapFrame frame_;
  std::vector<Eigen::Vector3d> points_;
  cv::Mat grey_;  // what every state shows unless pictures are rendered
  CoverageMap NewMap() const;
  std::shared_ptr<CoverageMap> map_;
  std::vector<int> ids_;
  int last_id_ = 0;
  std::shared_ptr<const RecordedFrame> newest_;
  std::vector<std::shared_ptr<const CaptureState>> recorded_;
};

}  // namespace ulf::test
