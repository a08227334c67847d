// Makes the overlay of the live picture as plain shapes: the subject's sphere with the coverage map on it,
// the present camera, the safety rectangle, the way to the next viewpoint (thesis, section 3.2 and figure
// 3-1). The operator display draws the shapes with OpenGL, coverage_drawing with OpenCV.
//
// Positions are in pixels of the live image, with its camera's distortion.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "coverage/operator/palette.h"
#include "coverage/operator/shown_sphere.h"
#include "coverage/session/capture_state.h"
#include "render/display/shapes.h"

namespace ulf::coverage {

// Describes what is painted on the sphere.
enum class SphereLayer {
  kCoverage,  // which directions are covered, and from how far away
  kErrors,    // the errors that were measured at frames
};

// Without a pose the overlay shows no sphere. Where the camera's rotation is known, it shows instead where
// the camera looked when it last had a pose.
render::Overlay MakeOverlay(const CaptureState& state, const Palette& palette = Palette::Standard(),
                            SphereLayer layer = SphereLayer::kCoverage);

// Returns the letter that marks a cause on the sphere; empty if there is none.
const char* LetterOf(render::ErrorCause cause);

// The part of the map around the present camera, enlarged so that a view's disc is well visible at arm's
// length: on the live picture's sphere the dot's place among the discs may be too small to steer by.
struct CloseLook {
  Eigen::Vector2i size;  // of the picture that the shapes are in
  render::Overlay shapes;
};
// `width`, `height`: of its picture, px. Returns none without a pose, before the first view, or inside the
// sphere.
std::optional<CloseLook> MakeCloseLook(const CaptureState& state, int width, int height,
                                       const Palette& palette = Palette::Standard());

// Returns the wireframe and the outline of a subject's sphere alone.
render::Overlay SphereOverlay(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject,
                              const render::Rgba& color);

}  // namespace ulf::coverage
