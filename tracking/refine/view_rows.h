// Tells the poses of the rows of a light field's views that a rolling shutter took, and what one instant
// would have shown. The light field has the pictures' poses, which explain all pixels as if taken at once,
// and the cameras' velocities (View::twist); the middle row's pose follows from the points that a view
// observes.
#pragma once

#include <map>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/undistortion.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::tracking {

struct ViewRows {
  Rigid3 middle_from_world;  // the middle row's pose, cam_from_world
  Twist twist = Twist::Zero();
  double readout_s = 0;  // of all rows, as in ShutterReadout
  DepthField depths;     // of the points that the view observes

  // Returns the pose when the row at this height of the picture was read, px from its top.
  Rigid3 PoseAt(const CameraModel& camera, double row) const;
};

// Returns the rows of each view that has a velocity and observes enough points of the light field, by id.
// Empty for a global shutter, and where the readout is unknown.
std::map<int, ViewRows> RowsOfViews(const LightField& light_field);

// Returns where the view's photograph shows what `to`, a camera at the middle row's place, would show of one
// instant: a map of cv::remap into the photograph (UndistortionMap). `depth` is CV_32F of the size of `to`,
// along its axis; where it is 0, the depth between the view's points is taken. Places outside the photograph
// are outside it in the map, too.
UndistortionMap InstantMap(const ViewRows& rows, const CameraModel& from, const CameraModel& to,
                           const cv::Mat& depth);

// Returns the light field as a global shutter would have recorded it: with the middle rows' poses, and
// observations where the instant shows them; these views have no velocity any more, and the light field no
// readout. Its photographs stay those of the rows: InstantMap() changes them.
LightField AtOneInstant(const LightField& light_field, const std::map<int, ViewRows>& rows);

}  // namespace ulf::tracking
