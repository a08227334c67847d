// Defines the input of refining and of triangulating: views with poses, and how to read their pictures.
// Converts a light field's views to it, and points back. Poses are cam_from_world in any unit.
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
    int lens = 0;  // index into `lenses`
    Rigid3 cam_from_world;
    // The predicted error of the camera's centre, as a share of the distance of what it sees; 0: unknown.
    double center_error_share = 0;
    std::optional<Twist> twist = {};  // the camera's velocity at its middle row, as the capture knew it
    // If false, the pose was found by LocatePhotographs() and does not fix the world.
    bool is_recorded = true;
  };
  std::vector<CameraModel> lenses;
  std::vector<View> views;
  // Reads a view's picture. It may be called in any thread, and throws Error.
  std::function<Image(int view)> read;
  // Reads a view's mask: CV_8UC1 of the picture's size, 0 where it shows nothing of the world of the poses (a
  // standing background before which the subject turned), or empty. No function: no view has a mask. It may
  // be called in any thread, and throws Error.
  std::function<cv::Mat(int view)> read_mask = {};
  // The readout time from the first row to the last; negative: the last is read first; 0: global.
  double readout_s = 0;
};

// Returns the views of a light field. The input reads photographs from `light_field`, which must outlive it.
RefineInput RefineInputOf(const LightField& light_field);

// Returns the points with tracks that name views by View::id instead of by index.
std::vector<ScenePoint> WithViewIds(std::vector<ScenePoint> points, const LightField& light_field);

// Removes observations (by View::id) in pixels that masks exclude, and points of which these leave fewer than
// two. Throws Error for a mask that is missing or of another aspect ratio.
std::vector<ScenePoint> WithoutMasked(std::vector<ScenePoint> points, const LightField& light_field);

}  // namespace ulf::tracking
