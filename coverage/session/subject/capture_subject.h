// The subject of a running capture: found by itself, placed as a person asks, and watched for whether it was
// moved. What is recorded of it is the record's; what it says is what a person should know.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "coverage/session/capture_outlook.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/record/capture_record.h"
#include "coverage/session/subject/subject_watch.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

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
  // As asked, with the camera where it was last seen; says why not where it cannot be.
  void Place(const Subject& subject, const std::optional<Rigid3>& cam_from_world);
  void Find(const FindSubject& asked, const std::optional<Rigid3>& cam_from_world);
  void Watch(const tracking::Track& track, double time_s);
  bool Moved() const { return moved_; }
  // What is in the middle of the picture can be told; not long enough yet.
  bool Finding() const { return finding_; }
  bool FoundByItself() const { return found_; }

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
