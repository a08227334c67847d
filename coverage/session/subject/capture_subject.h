// The subject of a running capture: finds it automatically, places it on request, and detects when it was
// moved. `say` gets a line for everything that a person should know.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "coverage/session/capture_outlook.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/record/capture_record.h"
#include "coverage/session/subject/subject_watch.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

// Where the subject is, when nobody says it: the mean depth of the tracked points within `reach` (a share of
// the image's height) of the picture's middle. (Thesis, section 3.1: "the system initializes its distance with
// the average depth of feature points".) The nearest and farthest quarter of the points may belong to what
// stands before or behind the subject and do not count. None with fewer than `fewest` points.
struct MiddleDepthOptions {
  double reach = 0.25;     // guessed; more takes in what stands beside the subject
  std::size_t fewest = 8;  // guessed; fewer are met by chance
};
std::optional<double> DepthNearCenter(const std::vector<tracking::VisiblePoint>& points,
                                      const CameraModel& camera, const MiddleDepthOptions& options = {});

// What is wrong with a subject for a camera that stands there, with the way out; empty: nothing.
std::string ProblemOf(const Subject& subject, const std::optional<Rigid3>& cam_from_world);

class CaptureSubject {
 public:
  struct Options {
    double size = 0.28;            // the sphere's image, share of the image's width
    double rectangle_share = 0.8;  // no larger
    int stable_frames = 10;        // tracked in a row before it is found by itself
  };
  CaptureSubject(CaptureRecord& record, CaptureOutlook& outlook, const tracking::PoseSource& poses,
                 const CameraModel& camera, const Options& options,
                 std::function<void(const std::string&)> say)
      : record_(record),
        outlook_(outlook),
        poses_(poses),
        camera_(camera),
        options_(options),
        say_(std::move(say)) {}

  void Set(const Subject& subject);
  // After every tracked frame, until there is one.
  void FindFirst(const tracking::Track& track);
  // On request, with the camera at its last known pose. Reports why when the request is refused.
  void Place(const Subject& subject, const std::optional<Rigid3>& cam_from_world);
  void Find(const FindSubject& asked, const std::optional<Rigid3>& cam_from_world);
  void Watch(const tracking::Track& track, double time_s);
  bool Moved() const { return moved_; }
  // A depth was found in the middle of the picture, but tracking is not stable for long enough yet.
  bool Finding() const { return finding_; }
  bool IsFoundAutomatically() const { return found_; }

 private:
  void Move(const Subject& subject);

  CaptureRecord& record_;
  CaptureOutlook& outlook_;
  const tracking::PoseSource& poses_;
  const CameraModel camera_;  // of the frames that are tracked
  const Options options_;
  const std::function<void(const std::string&)> say_;
  SubjectWatch watch_;
  bool moved_ = false;
  bool finding_ = false;
  bool found_ = false;
  int tracked_in_a_row_ = 0;
};

}  // namespace ulf::coverage
