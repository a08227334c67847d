// The display's own small copies of what the camera saw, with poses: what the augmented aperture and the
// review are made of. Kept compressed; a 10-minute capture stays within some tens of megabytes.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <vector>

#include "acquisition/camera_model.h"
#include "acquisition/rigid3.h"
#include "coverage/capture_state.h"

namespace ulf {

struct PosedPicture {
  std::uint64_t key = 0;  // its own: two pictures never share one
  CameraModel camera;     // of the copy, with its distortion
  Rigid3 cam_from_world;
  double device_time_s = 0;
  std::vector<unsigned char> jpeg;

  // The live picture of a state with a pose, at most `longer_side` pixels.
  static PosedPicture Of(const CaptureState& state, std::uint64_t key, int longer_side = 640);
  cv::Mat Srgb8() const;
};

// A few dozen pictures from places far apart, whatever the camera did in between: where a place is visited
// again the new picture takes over, for its pose is of the newer map.
class SpreadPictures {
 public:
  explicit SpreadPictures(std::size_t most = 24) : most_(most) {}
  void Offer(const CaptureState& state);
  const std::vector<PosedPicture>& pictures() const { return pictures_; }
  void Clear() { pictures_.clear(); }

 private:
  std::size_t most_;
  std::uint64_t next_key_ = std::uint64_t{1} << 32;  // apart from view ids
  double least_baseline_ = 0;                        // world units; grows when there are too many
  std::vector<PosedPicture> pictures_;
};

// By view id, at the poses that the newest state's coverage map has for them.
class RecordedPictures {
 public:
  void Add(const CaptureState& state);  // one with recorded_view
  // Views that were taken back go, poses are brought up to date. Photographs of a tethered camera are not
  // here; the live pictures taken with them keep their own poses.
  void Follow(const CaptureState& state);
  const std::map<int, PosedPicture>& pictures() const { return pictures_; }

 private:
  std::map<int, PosedPicture> pictures_;
};

// From the session's thread to the display's: the newest state, and every one that became a view.
class CaptureFeed {
 public:
  void Publish(std::shared_ptr<const CaptureState> state);
  void Close();  // nobody looks any more: what is published is dropped
  std::shared_ptr<const CaptureState> Newest() const { return newest_.Get(); }  // null before the first
  std::vector<std::shared_ptr<const CaptureState>> TakeRecorded();

 private:
  LatestCaptureState newest_;
  std::mutex mutex_;
  bool closed_ = false;
  std::deque<std::shared_ptr<const CaptureState>> recorded_;
};

}  // namespace ulf
