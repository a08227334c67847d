// Owns the map and alone changes it. The tracker makes the mapper and hands it a report for every frame:
// which points the frame should have shown and did show, and the frame itself if it should become a keyframe.
//
// For a new keyframe the mapper triangulates points with its neighbours, merges points that exist twice,
// adjusts the neighbourhood, and removes superfluous points and keyframes. When the map has grown by a tenth,
// or a loop was closed, it adjusts the whole part of the map in the background. A new keyframe stops that
// adjustment, which is repeated later. So errors of the first two views are corrected early, while that is
// cheap. After some of these adjustments the lens is checked against the map (lens_watch.h).
//
// The mapper works in a thread of its own, or, if it is synchronous, inside Take(), so that the same frames
// give the same bytes. It reads the map without the lock and takes it for every change, so that the tracker
// waits for microseconds only. It works on one keyframe at a time and refuses others meanwhile: only with
// that one in the map can the tracker decide whether it needs another. The rest of a report is applied at
// once, in the caller's thread.
#pragma once

#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <unordered_map>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/similarity3.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/map/anchored.h"
#include "tracking/map/frame_report.h"
#include "tracking/map/lens_watch.h"
#include "tracking/map/map.h"
#include "tracking/map/mapper_options.h"
#include "tracking/map/relocalizer.h"
#include "tracking/map/tracked_image.h"

namespace ulf::tracking {

class LoopCloser;

// A bundle adjustment's iterations before and after outliers are dropped.
struct AdjustmentEffort {
  int robust_iterations = 0, iterations = 0;
};

class Mapper {
 public:
  // Starts with `map`: an empty one, or one from a file.
  Mapper(const CameraModel& camera, Map map, bool synchronous, const MapperOptions& options = {},
         unsigned seed = 1);
  ~Mapper();
  Mapper(const Mapper&) = delete;
  Mapper& operator=(const Mapper&) = delete;

  // Gives read access to the map and to the index of its keyframes.
  const SharedMap& shared() const { return owned_.shared; }
  const KeyframeIndex& index() const { return index_; }

  // Take(), Drain() and WaitUntilIdle() rethrow what was thrown in the mapper's thread. Take() applies a
  // frame's report. It returns false if it refused the keyframe because it still works on the one before.
  bool Take(FrameReport report);
  void Drain();          // waits until all keyframes are in the map and adjusted
  void WaitUntilIdle();  // the same, but adjustments in the background are cut short or left out

  // Notes the points that a recorded view shows.
  void NoteView(int view_id, std::span<const MapObservation> seen);
  // Switches the measuring of a rolling shutter, after each adjustment of a whole part, on or off.
  void MeasureReadout(bool measure) { measure_readout_ = measure; }
  // Waits until idle, compensates this readout (0: global) in the keyframes, requests an adjustment.
  void SetReadout(double readout_s);

  // Call the following only while the mapper is idle.
  // Adjusts the part that the camera is in, because much has moved: at once if synchronous, else in
  // the background.
  void RequestFullAdjustment();
  // Begins a part of the map, the first of which is the main part, and returns its number. The median depth
  // of its points becomes 1; `scale` brings it near that before the adjustment. `color`: the second view.
  int StartFromTwoViews(const TwoViewStart& start, double scale, const cv::Mat& color);
  // Seeds are keyframes whose poses are given and stay: recorded views from which the map is made anew. In
  // the end FinishSeeds() adjusts the points and sets find rates; false: fewer than `min_points`.
  void AddSeed(NewKeyframe keyframe);
  bool FinishSeeds(int min_points);
  void MoveWorld(const Similarity3& given_from_map);  // into the world in which fiducials are given
  // Adjusts every part for the last time, with Cauchy's loss: observations that do not fit weigh less.
  void AdjustAll();
  // Returns the lens that the map's images support (ChooseLens()) in place of the present one, after
  // adjusting the map together with it; the mapper goes on under it. Returns none if the present lens stays.
  std::optional<RefinedLens> RefineLens();
  // Checks the lens at once if frames have another focal length than the map's (`log_ratio` is the logarithm
  // of their ratio): a moved zoom or a wrong lens, which bends a map, may be the reason. Returns true, and
  // sets SharedMap::wrong_lens, if the map contradicts the lens by more than such a zoom could have bent it.
  bool ContradictsLensBeyond(double log_ratio);
  void RemovePart(int part);  // after the last one the mapper begins anew
  void SetMainPart(int part);

 private:
  void Reset();
  void Run();
  bool Offer(NewKeyframe keyframe);
  void ThrowFailure() ULF_REQUIRES(work_mutex_);
  void Process(NewKeyframe& offered);
  int Insert(NewKeyframe& offered);
  void CullRecentPoints(int newest);
  void Triangulate(int newest, const std::vector<int>& neighbours);
  void Fuse(int newest, const std::vector<int>& neighbours);
  void FuseInto(int keyframe, const std::vector<int>& points);
  void AdjustLocal(int newest, bool poses_too);
  int PartInWork() const;
  bool IsDue();
  void AdjustInBackground();
  BundleOptions BundleOptionsFor(const AdjustmentEffort& effort) const;
  void AdjustWhole(int part, const BundleOptions& options);
  void CheckLens();
  void CullKeyframes(int newest);
  void CommitPoint(const Eigen::Vector3d& position, const Observation& reference, const Observation& other)
      ULF_REQUIRES(owned_.shared.mutex);
  Observation Measure(const MapPoint& point, int keyframe, int feature) const;
  std::vector<int> Neighbours(int keyframe, int most) const;
  std::vector<int> NeighboursByPose(int keyframe, int most) const;

  CameraModel camera_;
  OwnedMap owned_;
  const Map& map_ = owned_.shared.ReadByOwner();
  KeyframeIndex index_;
  bool synchronous_;
  std::unique_ptr<LoopCloser> loops_;
  MapperOptions options_;
  std::vector<int> recent_points_;
  std::unordered_map<int, int> adjust_all_at_;  // keyframes, by part
  bool after_loop_ = false;                     // a loop was closed since everything was adjusted
  std::atomic<bool> measure_readout_{false};
  LensWatch lens_;

  Mutex work_mutex_;
  ConditionVariable changed_;
  std::optional<NewKeyframe> next_ ULF_GUARDED_BY(work_mutex_);
  bool working_ ULF_GUARDED_BY(work_mutex_) = false;
  bool in_background_ ULF_GUARDED_BY(work_mutex_) = false;  // the present work may be cut short
  bool owed_ ULF_GUARDED_BY(work_mutex_) = false;           // an adjustment of everything is due
  std::exception_ptr failure_ ULF_GUARDED_BY(work_mutex_);  // thrown in the mapper's thread
  bool ending_ ULF_GUARDED_BY(work_mutex_) = false;
  std::atomic<bool> cut_short_{false};
  std::thread thread_;
};

}  // namespace ulf::tracking
