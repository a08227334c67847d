// What a running capture has recorded: its views (waiting for the disk, or written), their subject, and the
// coverage map. `say` gets a line for everything that a person should know.
//
// The coverage map is an immutable snapshot. A new view and corrected poses make a new one; whoever holds the
// old one keeps it as it was.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/image/frame.h"
#include "core/light_field/light_field_io.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/measured/error_meter.h"
#include "coverage/session/capture_lens.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/record/live_geometry.h"
#include "coverage/session/record/recorded_views.h"
#include "coverage/session/record/view_spool.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::coverage {

// How the light field was left.
struct ClosedRecord {
  std::uint64_t recorded = 0;                              // views of this session that are in it
  std::uint64_t unwritten = 0;                             // frames that were accepted and are lost
  std::map<std::filesystem::path, std::size_t> set_aside;  // frames that were written elsewhere, by folder
  std::string problem;                                     // why it could not be closed; empty: it is closed
  // None: it was not asked for, the light field is not closed, or the mesh that was there stays.
  std::optional<FinishedGeometry> geometry;
};

class CaptureRecord {
 public:
  struct Options {
    int coverage_width_px = 640;
    CoverageMapOptions map;
    std::size_t spool_views = 16;
    bool deterministic = false;
    std::optional<LiveGeometry::Options> geometry;  // none: no mesh is made, and nothing is measured
    CoverGoal cover;
    bool lens_may_change = false;  // GoOverToLens() may be called
    FrameSource source = FrameSource::kCamera;
    // A correction that moves no view by more than this, radians as seen from the subject, is not worth
    // painting the map and writing the journal for; it is about a tenth of a pixel of the coverage image.
    // Guessed.
    double worth_painting_anew = 2e-4;
    // A correction that reopens at least this share of the cap is reported; the next view fills a smaller one.
    // Guessed.
    double worth_telling = 0.005;
    // A lens that moves nothing by more, in pixels of geometry's pictures, leaves these as they are. Guessed: as
    // LiveGeometry::Options::moved_px.
    double same_pictures_px = 0.5;
  };
  // Goes on with the views of an earlier session that `writer` holds. `lens` outlives it.
  CaptureRecord(LightFieldWriter writer, const CaptureLens& lens, const Options& options,
                std::function<void(const std::string&)> say);

  ViewSpool& spool() { return spool_; }
  const ViewSpool& spool() const { return spool_; }
  const RecordedViews& views() const { return views_; }
  const std::shared_ptr<const CoverageMap>& map() const { return map_; }  // null without a subject
  const std::optional<Subject>& subject() const { return subject_; }
  // The subject of the earlier session; none before the first SetSubject.
  const std::optional<Subject>& ResumedSubject() const { return resumed_subject_; }

  // Paints the coverage map of this subject from the recorded views.
  void SetSubject(const Subject& subject);
  // Returns the view's id; none when there is no room for it (a photograph is always accepted). `poses`, whose
  // track this is, keeps which map points the view shows.
  std::optional<int> Add(const Frame& frame, const tracking::Track& track, std::optional<double> bound_px,
                         tracking::PoseSource& poses);
  // Returns how many views were taken back.
  std::size_t TakeBack(const std::vector<int>& ids);
  // Brings the views' poses up to date with the tracker's map: repaints the coverage map and, except for the
  // `last` time before Close(), writes the journal. `subject`: where the correction has taken the subject, if
  // anywhere; what was measured stays. Returns false when the disk is behind: try again.
  bool CorrectPoses(const tracking::PoseSource& poses, bool last, const std::optional<Subject>& subject = {});
  // Goes on under the lens that CaptureLens has now, in place of `before`: with the views where `poses` has them (in the journal in one line
  // with the lens, so that a kill leaves the old or the new of both), the coverage map painted anew, and geometry and
  // what is measured begun again from small pictures of the views. Views of earlier sessions must not be there: they
  // hold the map where it is. `last`: Close() comes next and writes the journal. `subject`: where the subject is
  // under this lens; none: there is none.
  void GoOverToLens(const CameraModel& before, const tracking::PoseSource& poses, bool last,
                    const std::optional<Subject>& subject);
  // Whether `share` of the cap is covered. Where the present map says so, it corrects the poses, paints the
  // map anew and asks CoverageMap::CoveredShare again: the snapshot that it publishes then is the one that
  // decided. False while the disk is behind a correction.
  bool IsCapCovered(double share, const tracking::PoseSource& poses);
  // Writes the waiting views, the final poses, `points`, the rolling shutter that was measured, and the time and the
  // counts of this session added to those of earlier ones. `closing`: hears what is done, step by step.
  ClosedRecord Close(
      double capture_s, const std::map<std::string, std::uint64_t>& reasons, std::vector<ScenePoint> points,
      const std::optional<tracking::Readout>& rolling_shutter = {},
      const std::function<void(const std::string&)>& closing = [](const std::string&) {});
  void Describe(CaptureState& state) const;

  // What a frame whose pose is known shows of the error: noted in errors(), and, unless the bound alone decides, in
  // the coverage map. None: there is no geometry yet, or no time.
  std::optional<MeasuredFrame> Measure(const Frame& frame, const CameraModel& camera,
                                       const tracking::Track& track);
  // The newest mesh of geometry; null: none yet, or none is made.
  std::shared_ptr<const LiveMesh> mesh() const { return geometry_ ? geometry_->State().mesh : nullptr; }
  const std::shared_ptr<const ErrorMap>& errors() const { return errors_; }  // null: nothing is measured

 private:
  bool MoveViews(const tracking::PoseSource& poses, bool last, bool& moved);
  void MoveSubject(const Subject& subject);
  void KeepSmall(int id, const Image& image);
  void StartGeometryAgain();
  void PaintAnew();
  // Paints anew, notes the directions that this reopens, and returns their share of the cap (without one, of what
  // was covered).
  double Repaint();
  void DropCoveredAgain();
  LightFieldWriter AfterEarlierViews(LightFieldWriter writer);
  void AddEarlierViews(const LightField& light_field);
  void SayGeometryProblem();
  void ForgetMeasuredAround(const Rigid3& cam_from_world);
  // The map's thresholds by the errors so far.
  void FollowErrorsNow();
  std::optional<FinishedGeometry> FinishGeometry(const std::filesystem::path& root,
                                                 const std::function<void(const std::string&)>& closing);
  std::string ReopenedInWords(double share) const;

  const CaptureLens& lens_;
  const Options options_;
  const std::function<void(const std::string&)> say_;
  const int first_new_id_;
  const int camera_index_;  // of the views of this session
  const double earlier_s_;
  const std::map<std::string, std::uint64_t> earlier_reasons_;
  const MeasuredErrors earlier_measured_;
  std::uint64_t frames_measured_;
  std::optional<Subject> subject_, resumed_subject_;
  RecordedViews views_;
  std::unique_ptr<LiveGeometry> geometry_;  // null: none is made
  CameraModel geometry_lens_;               // under which it and the meter have the views
  std::unique_ptr<ErrorMeter> meter_;       // null: nothing is measured
  std::map<int, cv::Mat> small_;            // their pictures, grey, for another lens of these two
  std::shared_ptr<const ErrorMap> errors_;
  std::shared_ptr<const LiveMesh> measured_over_;  // the mesh
  double followed_s_ = 0;                          // the device's time when the map last followed the errors
  ViewSpool spool_;
  std::shared_ptr<const CoverageMap> map_;
  // What was covered and is not any more, because poses were corrected or views taken back.
  struct Reopened {
    Eigen::Vector3d direction;
    double share = 0;  // of the cap; without one, of what was covered
  };
  std::vector<Reopened> reopened_;
  bool painted_anew_ = false;  // since the last view was added to the map
};

}  // namespace ulf::coverage
