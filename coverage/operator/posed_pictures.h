// The display's own small copies of what the camera saw, with poses: what the augmented aperture and the
// review are made of.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

struct PosedPicture {
  std::uint64_t key = 0;  // its own: two pictures never share one
  CameraModel camera;     // of the copy, with its distortion
  Rigid3 cam_from_world;
  std::vector<unsigned char> jpeg;

  // Of `image`, which `camera` took, at most kLongerSide pixels.
  static PosedPicture Of(const Image& image, const CameraModel& camera, const Rigid3& cam_from_world,
                         std::uint64_t key);
  cv::Mat Srgb8() const;
  static constexpr int kLongerSide = 640;
};

struct WeightedPicture {
  const PosedPicture* picture;
  float weight = 1;
};

// A few dozen live pictures from places far apart, whatever the camera did in between: where a place is
// visited again the new picture takes over, for its pose is of the newer map. One that was recorded is
// preferred, and goes with its view when that is taken back.
class SpreadPictures {
 public:
  explicit SpreadPictures(std::size_t most = 24) : most_(most) {}
  void Offer(const CaptureState& state);
  std::vector<WeightedPicture> pictures() const;  // all alike; until the next Offer()

 private:
  struct Kept {
    PosedPicture picture;
    double device_time_s = 0;
    std::optional<int> view;  // that the live picture was recorded as
    Eigen::Vector3d Center() const { return picture.cam_from_world.OriginInSource(); }
  };
  Kept Keep(const CaptureState& state);
  void DropTakenBack(const std::vector<int>& view_ids);
  void Thin();

  std::size_t most_;
  std::uint64_t next_key_ = std::uint64_t{1} << 32;  // apart from view ids
  double least_baseline_ = 0;                        // world units; grows when there are too many
  std::vector<Kept> kept_;
};

}  // namespace ulf::coverage
