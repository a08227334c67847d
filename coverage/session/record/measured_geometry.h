// Keeps the geometry of the recorded views during a capture, and the errors measured over it. It hears of
// every change of views and subject, and begins again under another lens that moves the pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "core/light_field/folder/opened_folder.h"
#include "core/light_field/light_field.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/measured/error_meter.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/session/record/live_geometry.h"
#include "coverage/session/record/recorded_views.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

class MeasuredGeometry final : public RecordedViews::Observer {
 public:
  // Continues with the views, the depth maps and the errors of `earlier` sessions. `lens` and `options`
  // outlive it. Makes geometry, and measures, if CaptureOptions::geometry asks for it.
  MeasuredGeometry(const LightField& earlier, const CaptureLens& lens, const CaptureOptions& options,
                   std::function<void(const std::string&)> say);

  void Added(const RecordedViews::Entry& view, const Image& image) override;
  void Removed(const RecordedViews::Entry& view) override;
  void Moved(const RecordedViews& views) override;
  // Sets another subject. `goes_on`: it is that of the earlier session, whose errors remain valid.
  void SetSubject(const Subject& subject, bool goes_on);
  // Moves the same subject: measured errors stay.
  void MoveSubject(const Subject& subject);

  enum class Attempt {
    kNotPossible,  // without meter, subject, pose or mesh
    kMade,
    kFailed  // nothing is measured from now on, and that was said
  };
  struct Measurement {
    Attempt attempt = Attempt::kNotPossible;
    std::optional<MeasuredFrame> frame;  // none: there was no time
  };
  // Measures the error at a frame, and one at an earlier frame again, and notes both in errors().
  Measurement Measure(const Frame& frame, const CameraModel& camera, const tracking::Track& track);

  bool IsMade() const { return geometry_ != nullptr; }
  bool MeshMayCome() const { return geometry_ && !geometry_->HasFailed(); }
  bool IsMeasured() const { return meter_ != nullptr; }
  // Returns the newest mesh; null if there is none yet, or none is made.
  std::shared_ptr<const LiveMesh> mesh() const { return geometry_ ? geometry_->State().mesh : nullptr; }
  const std::shared_ptr<const ErrorMap>& errors() const { return errors_; }  // null: nothing is measured
  // Returns the errors in the light field's form; none: nothing was ever measured.
  std::optional<MeasuredErrors> ForLightField() const;
  // Makes at the end the mesh of all views with their depth maps and writes them into the closed light field.
  // Returns none when the mesh that is there stays. `closing` hears what is done, step by step.
  std::optional<FinishedGeometry> Finish(const OpenedFolder& folder, const std::filesystem::path& root,
                                         bool has_new_views,
                                         const std::function<void(const std::string&)>& closing);

 private:
  void AddEarlierViews(const LightField& light_field);
  void StartAgain(const RecordedViews& views);
  void KeepSmall(int id, const Image& image);
  void Note(const std::function<void(ErrorMap&)>& change);
  void SayProblem();

  const CaptureLens& lens_;
  const CaptureOptions& options_;
  const std::function<void(const std::string&)> say_;
  const MeasuredErrors earlier_measured_;
  std::uint64_t frames_measured_;
  std::unique_ptr<LiveGeometry> geometry_;  // null: none is made
  CameraModel geometry_lens_;               // under which geometry and meter have the views
  std::unique_ptr<ErrorMeter> meter_;       // null: nothing is measured
  std::map<int, cv::Mat> small_;            // the views' pictures, grey, for another lens of these two
  std::shared_ptr<const ErrorMap> errors_;
  std::optional<Subject> subject_;
  std::shared_ptr<const LiveMesh> measured_over_;  // the mesh that the meter has; null: it is due
};

}  // namespace ulf::coverage
