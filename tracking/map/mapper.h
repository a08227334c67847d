// Grows and cleans the map behind the tracker: a keyframe comes in, points are triangulated with its
// neighbours, those seen twice are merged, the neighbourhood is bundle-adjusted, and what turned out
// superfluous goes. Whenever the map has grown by some share, all of it is adjusted: in the background, that
// is, for as long as no keyframe is offered, and again later where it was cut short. What a small map owes to
// its first two views is so corrected while it is cheap. Likewise when a loop was closed.
//
// Runs in a thread of its own, or, where the same frames must give the same bytes, inside Offer(). It alone
// changes the map's structure; it reads without the lock (map_) and takes it for every change (shared_.map),
// so the tracker waits for microseconds only. One keyframe at a time: while one is worked on, others are refused. Until it is in
// the map nobody knows whether another is needed, and what a later frame shows is worth as much.
#pragma once

#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/similarity3.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/map/map.h"
#include "tracking/map/mapper_options.h"
#include "tracking/map/relocalizer.h"
#include "tracking/tracker/initializer.h"

namespace ulf::tracking {

// A frame that shall become a keyframe, with the points it saw; `keyframe` in the observations is not yet
// known.
struct NewKeyframe {
  Keyframe keyframe;
  struct Seen {
    int point;
    Observation observation;
  };
  std::vector<Seen> seen;
};

class LoopCloser;

class Mapper {
 public:
  // Synchronous: everything happens inside Offer().
  Mapper(const CameraModel& camera, SharedMap& shared, KeyframeIndex& index, bool synchronous,
         const MapperOptions& options = {}, unsigned seed = 1);
  ~Mapper();
  Mapper(const Mapper&) = delete;
  Mapper& operator=(const Mapper&) = delete;

  // What broke while mapping in the second thread is thrown by the next of these three.
  // False when it was refused: the one before is still being worked on.
  bool Offer(NewKeyframe keyframe);
  void Drain();  // returns when all that was offered is in the map and adjusted
  void Rest();   // likewise, without waiting for adjustments in the background: they are cut short

  // The following are called by the tracker while the mapper rests.
  void AdjustSoon();  // everything, because much has moved: at once when synchronous, else in the background
  void StartFromTwoViews(const TwoViewStart& start, double scale, const cv::Mat& color);
  void AddSeed(NewKeyframe keyframe);                 // pose given and kept
  void FinishSeeds();                                 // after the last of them: their points
  void MoveWorld(const Similarity3& given_from_map);  // into the world that corners are given in
  void AdjustAll();  // everything, for the last time: what does not fit is doubted
  void Reset();

 private:
  void Run();
  void ThrowFailure() ULF_REQUIRES(work_mutex_);
  void Process(NewKeyframe& offered);
  int Insert(NewKeyframe& offered);
  void CullRecentPoints(int newest);
  void Triangulate(int newest, const std::vector<int>& neighbours);
  void Fuse(int newest, const std::vector<int>& neighbours);
  void FuseInto(int keyframe, const std::vector<int>& points);
  void AdjustLocal(int newest, bool poses_too);
  bool IsDue();
  void AdjustInBackground();
  void AdjustWhole(const BundleOptions& options);
  void CullKeyframes(int newest);
  void CommitPoint(const Eigen::Vector3d& position, const Observation& reference, const Observation& other)
      ULF_REQUIRES(shared_.mutex);
  Observation Measure(const MapPoint& point, int keyframe, int feature) const;
  double MedianDepth(int keyframe) const;
  std::vector<int> Neighbours(int keyframe, int most) const;
  std::vector<int> NeighboursByPose(int keyframe, int most) const;

  CameraModel camera_;
  SharedMap& shared_;
  const Map& map_;
  KeyframeIndex& index_;
  bool synchronous_;
  std::unique_ptr<LoopCloser> loops_;
  MapperOptions options_;
  std::vector<int> recent_points_;
  int adjust_all_at_ = 0;    // keyframes
  bool after_loop_ = false;  // closed since everything was adjusted

  Mutex work_mutex_;
  ConditionVariable changed_;
  std::optional<NewKeyframe> next_ ULF_GUARDED_BY(work_mutex_);
  bool working_ ULF_GUARDED_BY(work_mutex_) = false;
  bool in_background_ ULF_GUARDED_BY(work_mutex_) = false;  // what is worked on may be cut short
  bool owed_ ULF_GUARDED_BY(work_mutex_) = false;           // an adjustment of everything
  std::exception_ptr failure_ ULF_GUARDED_BY(work_mutex_);  // what broke in the second thread
  bool ending_ ULF_GUARDED_BY(work_mutex_) = false;
  std::atomic<bool> cut_short_{false};
  std::thread thread_;
};

}  // namespace ulf::tracking
