// What is drawn over the live picture, as plain shapes: the subject's sphere with the coverage map on it, the
// present camera, the safety rectangle, where to go next (thesis, section 3.2 and figure 3-1). Pure: the
// state of a capture in, shapes out; the operator display draws them with OpenGL, coverage_drawing with
// OpenCV.
//
// Places are in the live image, with its camera's distortion.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "coverage/operator/palette.h"
#include "coverage/operator/shown_sphere.h"
#include "coverage/session/capture_state.h"
#include "render/display/shapes.h"

namespace ulf::coverage {

// Nothing of the sphere while there is no pose.
render::Overlay MakeOverlay(const CaptureState& state, const Palette& palette = Palette::Standard());

// The map around the present camera, enlarged until a view's disc is well seen from an arm's length: where
// the live picture's sphere is small the red dot's place among the discs is too fine to steer by.
struct CloseLook {
  Eigen::Vector2i size;  // of the picture that the shapes are in
  render::Overlay shapes;
};
// None without a pose or before the first view.
std::optional<CloseLook> MakeCloseLook(const CaptureState& state, int width, int height,
                                       const Palette& palette = Palette::Standard());

// The same without a capture: only what hangs on the camera and the subject's sphere.
render::Overlay SphereOverlay(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject,
                              const render::Rgba& color);

// The one thing to do now, a line for arm's length.
struct Instruction {
  std::string words;
  bool urgent = false;  // nothing is recorded until it is done
};
Instruction InstructionFor(const CaptureState& state);

}  // namespace ulf::coverage
