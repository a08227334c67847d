// Grows and cleans the map behind the tracker: a keyframe comes in, points are triangulated with its
// neighbours, those seen twice are merged, the neighbourhood is bundle-adjusted, and what turned out
// superfluous goes.
//
// Runs in a thread of its own, or, where the same frames must give the same bytes, inside Offer(). It alone
// changes the map's structure; it reads without the lock and takes it for every change, so the tracker waits
// for microseconds only. The queue is bounded: when it is full a keyframe is refused (live) or waited for
// (replay).
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "acquisition/camera_model.h"
#include "tracking/initializer.h"
#include "tracking/map.h"
#include "tracking/relocalizer.h"

namespace ulf {

struct MapperOptions {
  bool synchronous = false;
  bool wait_when_full = false;
  int queue_length = 2;
};

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

class Mapper {
 public:
  Mapper(const CameraModel& camera, SharedMap& shared, KeyframeIndex& index, const MapperOptions& options);
  ~Mapper();
  Mapper(const Mapper&) = delete;
  Mapper& operator=(const Mapper&) = delete;

  // False when it was refused. Throws what broke while mapping earlier keyframes.
  bool Offer(NewKeyframe keyframe);
  bool Idle() const;
  void Drain();  // returns when all that was offered is in the map

  // The following are called by the tracker while the mapper rests.
  void StartFromTwoViews(const TwoViewStart& start, double scale, const cv::Mat& color);
  void AddSeed(NewKeyframe keyframe);  // pose given and kept
  void AdjustAll();                    // bundle adjustment of everything
  void Reset();

 private:
  void Run();
  void Process(NewKeyframe& offered);
  int Insert(NewKeyframe& offered);
  void CullRecentPoints(int newest);
  void Triangulate(int newest, const std::vector<int>& neighbours);
  void Fuse(int newest, const std::vector<int>& neighbours);
  void FuseInto(int keyframe, const std::vector<int>& points);
  void AdjustLocal(int newest, bool poses_too);
  void Adjust(const std::vector<int>& free, const std::vector<int>& held, int robust_iterations,
              int iterations);
  void CullKeyframes(int newest);
  void CommitPoint(const Eigen::Vector3d& position, const Observation& reference, const Observation& other);
  Observation Measure(const MapPoint& point, int keyframe, int feature) const;
  std::vector<int> Neighbours(int keyframe, int most) const;
  std::vector<int> NeighboursByPose(int keyframe, int most) const;

  CameraModel camera_;
  SharedMap& shared_;
  Map& map_;
  KeyframeIndex& index_;
  MapperOptions options_;
  std::vector<int> recent_points_;

  mutable std::mutex queue_mutex_;
  std::condition_variable changed_;
  std::deque<NewKeyframe> queue_;
  bool working_ = false;
  bool ending_ = false;
  std::exception_ptr failure_;  // what broke in the second thread: thrown to whoever offers or drains next
  std::atomic<bool> hurry_{false};  // more is waiting: local adjustment may end early
  std::thread thread_;
};

}  // namespace ulf
