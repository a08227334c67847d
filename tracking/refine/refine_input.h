// Defines the input of refining and of triangulating: views with poses, and how to read their pictures. A
// light field's recorded views are converted to it, and the points back.
//
// Poses are cam_from_world in any unit; image quantities are pixels of the input's images.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::tracking {

struct RefineInput {
  struct View {
    std::string name;
    int lens = 0;  // index into lenses
    Rigid3 cam_from_world;
    // The predicted error of the camera's centre, as a share of the distance of what it sees; 0: unknown.
    double center_error_share = 0;
    std::optional<Twist> twist = {};  // the camera's velocity at its middle row, as the capture knew it
    // False: the pose was found by LocatePhotographs() and does not fix the world.
    bool is_recorded = true;
  };
  std::vector<CameraModel> lenses;
  std::vector<View> views;
  // Reads a view's picture; is called in any thread, throws Error.
  std::function<Image(int view)> read;
  // Reads a view's mask: CV_8UC1 of the picture's size, 0 where it shows nothing of the world of the poses;
  // empty: everything is of that world. None: no view has a mask. Is called in any thread, throws Error.
  std::function<cv::Mat(int view)> read_mask = {};
  // The readout time of a rolling shutter, from the first row to the last; negative: from the last; 0:
  // global.
  double readout_s = 0;
};

// Returns the views of a light field. The input reads photographs from `light_field`, which must outlive it.
RefineInput RefineInputOf(const LightField& light_field);

// Makes the points' tracks name views by id instead of by index.
std::vector<ScenePoint> WithViewIds(std::vector<ScenePoint> points, const LightField& light_field);

// Removes observations in pixels that masks exclude, and points of which these leave fewer than two.
// Throws Error for a mask that is missing or of another aspect.
std::vector<ScenePoint> WithoutMasked(std::vector<ScenePoint> points, const LightField& light_field);

}  // namespace ulf::tracking
