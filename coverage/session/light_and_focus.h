// Checks before the first view whether the live frames are bright enough and in focus.
//
// A picture is out of focus when its finest detail is missing while coarser detail is there: in the picture
// at half its size, the finest octave (what a Gaussian of one pixel takes away) is compared with the next one
// at the same edges. Each part of the subject's image is judged for itself and the sharpest parts decide:
// what stands before or behind the plane of focus is rightly blurred, and a smooth thing is sharp at its
// outline alone. In the middle of photographs of ten public sets, 480 to 1536 pixels wide, the ratio is 1.1
// to 3.4; after a Gaussian blur of three pixels nine of ten in every set have at most 0.80.
//
// A lens far out of focus images each point as a disc, whose rim looks like fine detail, and whose edges are
// found at a quarter of the size alone, where they look sharper. So the slopes of edges are compared, too:
// their steepness after little smoothing over that after more falls with the width of the blur, whatever its
// shape. The lower of the two ratios counts, unless the first is 1.1 or more at half the size. In the middle
// of over 300 pictures of four public sets it is 0.80 to 1.4; in the simulator's scenes 1.3 to 1.5, and 0.7
// to 0.76 with a disc of eight pixels' radius (docs/capture.md#mistakes).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/subject_light.h"

namespace ulf::coverage {

// Returns that ratio for the sharpest parts inside a polygon (pixels) of an 8-bit grey picture; sharp
// pictures have 0.8 or more. Returns none when there are too few edges.
std::optional<double> FineDetail(const cv::Mat& grey8, const std::vector<Eigen::Vector2d>& outline);

struct PictureFinding {
  bool is_of_subject = false;  // else of the picture's middle: no subject is placed, or it is out of view
  std::optional<SubjectLight> light;  // of what was looked at
  std::optional<double> fine_detail;  // the best FineDetail() of two seconds; none: cannot be told yet
};

class LightAndFocusCheck {
 public:
  // Call it for every live frame; it looks at four of them a second, by the device's time `time_s`. `subject`
  // and `cam_from_world`: none while they are not known.
  const PictureFinding& Update(double time_s, const Image& image, const CameraModel& camera,
                               const std::optional<Rigid3>& cam_from_world,
                               const std::optional<Subject>& subject);

 private:
  struct Looked {
    double time_s = 0;
    std::optional<double> fine_detail;
  };
  std::deque<Looked> looked_;
  PictureFinding finding_;
};

}  // namespace ulf::coverage
