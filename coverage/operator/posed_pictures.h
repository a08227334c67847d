// Keeps small copies of images, with poses, for the display's augmented aperture and review.
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
  std::uint64_t key = 0;  // no other picture has it
  CameraModel camera;     // of the copy, with its distortion
  Rigid3 cam_from_world;
  std::string jpeg;  // the copy, as a file's bytes

  // Reduces `image`, which `camera` took, so that its longer side has at most kLongerSide pixels.
  static PosedPicture Of(const Image& image, const CameraModel& camera, const Rigid3& cam_from_world,
                         std::uint64_t key);
  cv::Mat Srgb8() const;  // decoded: B, G, R
  static constexpr int kLongerSide = 640;
};

struct WeightedPicture {
  const PosedPicture* picture;
  float weight = 1;
};

// Keeps live pictures from places far apart. When a place is visited again the new picture replaces the old
// one, because its pose is of the newer map. A picture that was recorded is preferred, and is dropped when
// its view is taken back.
class SpreadPictures {
 public:
  // `most`: how many are kept; more take longer to draw, fewer show as single pictures in the blur. Guessed.
  explicit SpreadPictures(std::size_t most = 24) : most_(most) {}
  void Offer(const CaptureState& state);          // call it for every new state
  std::vector<WeightedPicture> pictures() const;  // all of one weight; valid until the next Offer()

 private:
  struct Kept {
    PosedPicture picture;
    double device_time_s = 0;
    std::optional<int> view;  // that the live picture was recorded as
    Eigen::Vector3d Center() const { return picture.cam_from_world.OriginInSource(); }
  };
  Kept Keep(const CaptureState& state);
  void Thin();

  const std::size_t most_;
  std::uint64_t next_key_ = std::uint64_t{1} << 32;  // apart from view ids
  double least_baseline_ = 0;                        // world units; grows when there are too many
  CameraModel lens_;                                 // of the newest state
  std::vector<Kept> kept_;
};

}  // namespace ulf::coverage
