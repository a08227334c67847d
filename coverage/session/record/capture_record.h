// Holds what a running capture has recorded: its views (waiting for the disk, or written), their subject, the
// coverage map, and geometry with the errors measured over it. `say` gets a line for everything that a person
// should know. All runs in the capture's thread, except for what spool and geometry do in threads of theirs.
//
// A change goes first to the disk, then to RecordedViews, which notifies its observers, and last to the map.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/session/record/coverage_painter.h"
#include "coverage/session/record/live_geometry.h"
#include "coverage/session/record/measured_geometry.h"
#include "coverage/session/record/recorded_views.h"
#include "coverage/session/record/view_spool.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

// Describes how the light field was left. Accepted frames are lost, or set aside in other folders, where the
// disk filled up or failed.
struct ClosedRecord {
  std::uint64_t recorded = 0;                              // views of this session that are in it
  std::uint64_t unwritten = 0;                             // accepted frames that are lost
  std::map<std::filesystem::path, std::size_t> set_aside;  // how many accepted frames are in other folders
  std::string problem;  // why the light field could not be closed; empty: it is closed
  // None: geometry was not asked for, the light field is not closed, or the mesh that was there stays.
  std::optional<FinishedGeometry> geometry;
};

class CaptureRecord {
 public:
  // Continues with the views of an earlier session that `writer` holds. `lens` and `options` outlive it.
  CaptureRecord(LightFieldWriter writer, const CaptureLens& lens, const CaptureOptions& options,
                std::function<void(const std::string&)> say, FrameSource source = FrameSource::kCamera);

  ViewSpool& spool() { return spool_; }
  const ViewSpool& spool() const { return spool_; }
  const RecordedViews& views() const { return views_; }
  const std::shared_ptr<const CoverageMap>& map() const { return painter_.map(); }  // null without a subject
  const std::vector<ReopenedDirection>& reopened() const { return painter_.reopened(); }
  int camera_index() const { return camera_index_; }  // of the views of this session, in the light field
  const std::optional<Subject>& subject() const { return subject_; }
  // Returns the subject of the earlier session until the first SetSubject(), then none.
  const std::optional<Subject>& ResumedSubject() const { return resumed_subject_; }

  // Paints the coverage map of this subject from the recorded views.
  void SetSubject(const Subject& subject);
  // Records a frame whose pose is known. Returns the view's id; none when there is no room for it (a
  // photograph is always accepted). `poses`, whose track this is, keeps which map points the view shows.
  std::optional<int> Add(const Frame& frame, const tracking::Track& track, std::optional<double> bound_px,
                         tracking::PoseSource& poses);
  // Returns how many views were taken back.
  std::size_t TakeBack(const std::vector<int>& ids);
  // Brings the views' poses up to date with the tracker's map: repaints the coverage map and, except for the
  // `last` time before Close(), writes the journal. `subject`: the subject's place after the correction, if
  // it has moved; measured errors stay valid. Returns false when the disk is behind: try again.
  bool CorrectPoses(const tracking::PoseSource& poses, bool last, const std::optional<Subject>& subject = {});
  // Replaces the lens `before` by that of CaptureLens: takes the views' poses from `poses` (journaled in one
  // line with the lens, so that a kill leaves the old or the new of both), repaints the coverage map, and
  // begins geometry and measured errors again from small pictures of the views. There must be no views of
  // earlier sessions, which hold the map where it is. `last`: Close() comes next and writes the journal.
  // `subject`: the subject's place under this lens; none: there is none.
  void ReplaceLens(const CameraModel& before, const tracking::PoseSource& poses, bool last,
                   const std::optional<Subject>& subject);
  // Returns whether `share` of the cap is covered. When the present map says so, it corrects the poses,
  // repaints the map and tests CoverageMap::CoveredShare() again, so that map() is the one that decided.
  // Returns false while the disk is behind a correction.
  bool IsCapCovered(double share, const tracking::PoseSource& poses);
  // Writes the waiting views, the final poses, `points`, the rolling shutter that was measured, and the time
  // and the counts of this session added to those of earlier ones. `capture_s`: the length of this session.
  // `closing` hears what is done, step by step.
  ClosedRecord Close(
      double capture_s, const std::map<std::string, std::uint64_t>& reasons, std::vector<ScenePoint> points,
      const std::optional<tracking::Readout>& rolling_shutter = {},
      const std::function<void(const std::string&)>& closing = [](const std::string&) {});
  // Measures the error at a frame with a known pose and notes it in errors(); unless the bound alone decides,
  // the coverage map follows once a second. Returns none when there is no geometry yet, or no time.
  std::optional<MeasuredFrame> Measure(const Frame& frame, const CameraModel& camera,
                                       const tracking::Track& track);
  // Returns the newest mesh of geometry; null if there is none yet, or none is made.
  std::shared_ptr<const LiveMesh> mesh() const { return geometry_.mesh(); }
  const std::shared_ptr<const ErrorMap>& errors() const { return geometry_.errors(); }  // null: not measured
  // Returns false when no mesh will come while capturing, because no geometry is made or it has failed.
  bool MeshMayCome() const { return geometry_.MeshMayCome(); }
  bool ErrorsMayCome() const { return geometry_.IsMeasured() && (mesh() || MeshMayCome()); }

 private:
  // Runs `change`, and paints the map anew if that moved or took back views, or moved the subject: nothing
  // else may do so. Returns the share of the cap that this reopens.
  double Change(const std::function<void()>& change);
  bool MoveViews(const tracking::PoseSource& poses, bool last);
  void MoveSubject(const Subject& subject);
  std::string ReopenedInWords(double share) const;

  const CaptureLens& lens_;
  const CaptureOptions& options_;
  const std::function<void(const std::string&)> say_;
  const FrameSource source_;
  const int first_new_id_;
  const int camera_index_;  // of the views of this session
  const double earlier_s_;
  const std::map<std::string, std::uint64_t> earlier_reasons_;
  std::optional<Subject> subject_, resumed_subject_;
  RecordedViews views_;
  MeasuredGeometry geometry_;
  CoveragePainter painter_;
  double followed_s_ = 0;  // the device's time when the map last followed the errors
  ViewSpool spool_;
};

}  // namespace ulf::coverage
