// What becomes of the lens while frames are tracked: another one, where the map's images ask for it, and a
// zoom that is moved.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"
#include "tracking/estimation/focal_change.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/pose_error.h"
#include "tracking/tracker/tracker_core.h"

namespace ulf::tracking {
namespace {

CameraModel Zoomed(const CameraModel& lens, double log_ratio) {
  CameraModel zoomed = lens;
  zoomed.fx *= std::exp(log_ratio);
  zoomed.fy *= std::exp(log_ratio);
  return zoomed;
}

}  // namespace

std::optional<RefinedLens> TrackerCore::RefinedLensInOriginalPixels() const {
  if (!refined_lens) return std::nullopt;
  const double scale = size.original().MeanFocalPx() / size.working().MeanFocalPx();
  return RefinedLens{size.original(), refined_lens->focal_sigma_px * scale, refined_lens->center_is_found};
}

// The mapper rests meanwhile, so a live camera's next frame waits.
bool TrackerCore::RefineLens() {
  mapper.WaitUntilIdle();
  std::optional<RefinedLens> refined = mapper.RefineLens();
  if (!refined) return false;
  // A later refinement that leaves the focal length as it was says nothing of its deviation.
  if (refined_lens) refined->focal_sigma_px = std::max(refined->focal_sigma_px, refined_lens->focal_sigma_px);
  size.SetWorking(refined->camera);
  TrackWithLens(size.working());
  zoom.Forget();
  if (rows.rolls()) mapper.SetReadout(rows.readout_s());
  // What was measured under the other lens is measured again.
  readout_search.Restart();
  map_drift.Clear();
  refined_lens = refined;
  ++lens_revision;
  return true;
}

// Tracks the frames to come with this lens: the map's, or that with its zoom moved. The map keeps its own.
void TrackerCore::TrackWithLens(const CameraModel& lens) {
  camera = lens;
  extractor.SetCamera(camera);
  locator.SetCamera(camera);
  initializer.SetCamera(camera);
  turns.SetCamera(camera);
  rows.SetCamera(camera);
}

// Call it before each frame.
void TrackerCore::PrepareLens() {
  if (zoom.IsMoved()) {
    // A camera that was lost with its zoom moved may come back with the zoom where it was.
    if (state == TrackState::kLost)
      TrackWithLens(frame % 2 == 0 ? size.working() : Zoomed(size.working(), zoom.log_ratio()));
    return;
  }
  if (options.lens != LensUse::kRefine) return;
  const bool contradicted = [&] {
    const MapLock lock(shared);
    return shared.wrong_lens.has_value();
  }();
  if ((contradicted || shared.lens_is_due) && !RefineLens() && contradicted)
    spdlog::warn("images contradict the given lens, and no other explains them better yet");
}

// Is called after each frame that has a pose.
void TrackerCore::WatchZoom(double time_s, const FramePose& frame_pose, Track& track) {
  if (options.lens == LensUse::kFixed) return;
  if (!zoom.IsMoved() && track.wrong_lens) return zoom.Forget();        // which bends the map ever anew
  if (zoom.IsMoved() && camera.fx == size.working().fx) zoom.Forget();  // found again without it
  std::vector<double> depths;
  for (const VisiblePoint& point : last.visible) depths.push_back(point.depth);
  const double distance = std::max(1e-9, Median(std::move(depths)));
  // What a map is off by, a focal length may be, too: a share of the pose's deviation. Where that is large,
  // nothing is told. Guessed.
  constexpr double kMapShare = 0.15, kLeastQuality = 0.4;
  const double by_map = kMapShare * track.center_sigma.value_or(0) / distance;
  std::optional<FocalChange> change;
  if (track.quality >= kLeastQuality)
    change = MeasureFocalChange(camera, ToObservations(frame_pose.candidates, frame_pose.matches),
                                frame_pose.cam_from_world);
  const double before = zoom.log_ratio(), by_rows = ZoomByRows();
  zoom.Step(time_s, change, std::hypot(by_rows, by_map));
  if (change)
    spdlog::debug(
        "frame {}: focal length off by {:.4f}, +- {:.4f} (map {:.4f}, rows {:.4f}), quality {:.2f}{}", frame,
        change->log_ratio, change->sigma, by_map, by_rows, track.quality,
        zoom.Disagrees() ? ": no keyframe" : "");
  if (before == 0 && zoom.IsMoved()) {
    mapper.WaitUntilIdle();
    if (mapper.ContradictsLensBeyond(zoom.log_ratio())) zoom.Forget();
  }
  if (zoom.log_ratio() != before) TrackWithLens(Zoomed(size.working(), zoom.log_ratio()));
  if (zoom.IsMoved()) track.focal_ratio = std::exp(zoom.log_ratio());
  // Magnified by so much, a camera seems to have come nearer by that share of the distance. How far a zoom
  // was moved is measured against a map that it does not fit: a jump may be told as a tenth of itself.
  constexpr double kLeast = 0.02;  // of a moved one; guessed
  const double off = std::hypot(zoom.Disagrees() && change ? change->log_ratio : 0,
                                zoom.IsMoved() ? std::max(kLeast, std::abs(zoom.log_ratio())) : 0);
  if (off == 0 || !track.center_sigma) return;
  track.center_sigma = std::hypot(*track.center_sigma, off * distance);
  track.quality = std::min(track.quality, QualityOf(*track.center_sigma, distance));
}

// One standard deviation of what a rolling shutter adds to a frame's focal length: a camera that pitches
// while its rows are read sees them stretched. Compensated rows leave a part of that.
double TrackerCore::ZoomByRows() const {
  if (!last.between) return 0;
  constexpr double kStretch = 0.5, kLeft = 0.3;  // of both axes; guessed
  const double readout_s = std::max(kLeft * std::abs(rows.readout_s()), readout_search.Suspected());
  return kStretch * last.between->head<3>().norm() * readout_s;
}

}  // namespace ulf::tracking
