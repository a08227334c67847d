// Whether the camera's exposure has come to rest, or the light on the subject: a light field's pictures must
// differ by viewpoint alone. A moving camera changes what it sees, too; so brightness is compared only
// between frames from nearly the same direction, a fraction of a second apart.
//
// Waited is only where waiting helps: a camera that can be told to hold its exposure, and of which it is
// known that it does, or what it does. A video, or a webcam that exposes by itself and does not say how,
// would be waited for in vain: it is recorded as it is, and its light is matched (exposure_match.h).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/frame.h"
#include "core/light_field/light_field.h"

namespace ulf::coverage {

class ExposureWatch {
 public:
  // Every frame with a pose that sees the whole subject, in order. `held`: whether the camera's automatic is
  // off, none where it does not tell (Device::Held). True: settled, as far as can be told.
  bool Settled(const Frame& frame, const CameraModel& camera, const Rigid3& cam_from_world,
               const Subject& subject, std::optional<bool> held);

 private:
  struct Seen {
    double time_s = 0;
    double setting = 0;                                   // exposure time x gain; 0: not told
    double light = 0;                                     // mean, linear; 0: not known
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // from the subject
  };
  std::deque<Seen> recent_;
};

}  // namespace ulf::coverage
