// What a capture has recorded: the views, on their way to disk and there; the subject that they are of; and
// what they cover. It says what it does that a person should know.
//
// The map is shared with states that were given out, and whoever looks at one looks at a value: the map is
// copied before it changes while somebody else holds it.
#pragma once

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
#include "coverage/bound/reopened.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/record/held_views.h"
#include "coverage/session/record/view_spool.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

// How the light field was left.
struct ClosedRecord {
  std::uint64_t recorded = 0;                              // views of this session that are in it
  std::uint64_t unwritten = 0;                             // frames that were taken and are nowhere
  std::map<std::filesystem::path, std::size_t> set_aside;  // that are elsewhere, by folder
  std::string problem;                                     // what the disk said no to; empty: it is closed
};

class CaptureRecord {
 public:
  struct Options {
    CameraModel camera;  // of the views
    int coverage_width_px = 640;
    CoverageMapOptions map;
    std::size_t spool_views = 16;
    bool deterministic = false;
  };
  // `writer` may hold views of an earlier session: they are taken over.
  CaptureRecord(LightFieldWriter writer, const Options& options, std::function<void(const std::string&)> say);

  ViewSpool& spool() { return spool_; }
  const ViewSpool& spool() const { return spool_; }
  const HeldViews& views() const { return views_; }
  const CoverageMap* map() const { return map_.get(); }  // null without a subject
  std::shared_ptr<const CoverageMap> SharedMap() const { return map_; }
  const std::optional<Subject>& subject() const { return subject_; }
  // The subject of the earlier session; none before the first SetSubject.
  const std::optional<Subject>& ResumedSubject() const { return resumed_subject_; }

  // What was recorded is painted anew.
  void SetSubject(const Subject& subject);
  // The view's id; none when there is no room for it. A photograph is always taken. `poses`, which the track
  // is of, keep what the view shows.
  std::optional<int> Add(const Frame& frame, const tracking::Track& track, std::optional<double> bound_px,
                         tracking::PoseSource& poses);
  // How many there were to take back.
  std::size_t TakeBack(const std::vector<int>& ids);
  // What later adjustments say of the views' poses: painted, and journaled unless it is the last time. False
  // when it has to be tried again: the disk is behind.
  bool CorrectPoses(const tracking::PoseSource& poses, bool last);
  // The map says when it is worth measuring; the measure, on directions of its own, decides. A map without an
  // open cell is as much as can be asked for: nothing could say where to go.
  bool CapIsCovered(double share, const tracking::PoseSource& poses);
  // Writes what waits, then what the poses are now, `points`, and what this session adds to the earlier ones'
  // time and counts.
  ClosedRecord Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons,
                     std::vector<ScenePoint> points);
  void Describe(CaptureState& state) const;

 private:
  CoverageMap& MapToChange();
  double Repaint();  // the share that fell open
  std::string OfWhat() const { return options_.map.cap ? "of the cap" : "of what was covered"; }

  const Options options_;
  const std::function<void(const std::string&)> say_;
  const int first_new_id_;
  const double earlier_s_;
  const std::map<std::string, std::uint64_t> earlier_reasons_;
  std::optional<Subject> subject_, resumed_subject_;
  HeldViews views_;
  ViewSpool spool_;
  std::shared_ptr<CoverageMap> map_;
  Reopened reopened_;
  bool measured_ = false;  // the coverage, since a view was added
};

}  // namespace ulf::coverage
