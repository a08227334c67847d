// What is drawn over the live picture, as plain shapes: the subject's sphere with the coverage map on it, the
// present camera, the safety rectangle, where to go next (thesis, section 3.2 and figure 3-1). Pure: the
// state of a capture in, shapes out; the operator display draws them with OpenGL, coverage_drawing with
// OpenCV.
//
// Places are in the live image, with its camera's distortion, pixel centres at integer + 0.5. Widths, radii
// and text sizes are in points: pixels of a screen of ordinary density.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "coverage/capture_state.h"
#include "coverage/operator/palette.h"
#include "coverage/operator/shown_sphere.h"

namespace ulf {

struct Polyline {
  std::vector<Eigen::Vector2d> img;
  double width = 1;
  Rgba color;
  bool closed = false;
};
// Convex.
struct Polygon {
  std::vector<Eigen::Vector2d> img;
  Rgba color;
};
// One of many that lie side by side: its edges are not smoothed.
struct Patch {
  std::array<Eigen::Vector2d, 4> img;
  Rgba color;
};
struct Spot {
  Eigen::Vector2d img;
  double radius = 1;
  Rgba color;
};
struct Label {
  Eigen::Vector2d img;
  std::string text;
  double size = 20;
  Rgba color;
  Eigen::Vector2d anchor{
      0.5, 0.5};  // which point of the text is at `img`: 0,0 its upper left, 1,1 its lower right
};
using OverlayShape = std::variant<Polyline, Polygon, Patch, Spot, Label>;
using Overlay = std::vector<OverlayShape>;  // in the order of drawing

// Nothing of the sphere while there is no pose.
Overlay MakeOverlay(const CaptureState& state, const Palette& palette = Palette::Standard());

// The map around the present camera, enlarged until a view's disc is well seen from an arm's length: where
// the live picture's sphere is small the red dot's place among the discs is too fine to steer by.
struct CloseLook {
  Eigen::Vector2i size;  // of the picture that the shapes are in
  Overlay shapes;
};
// None without a pose or before the first view.
std::optional<CloseLook> MakeCloseLook(const CaptureState& state, int width, int height,
                                       const Palette& palette = Palette::Standard());

// The same without a capture: only what hangs on the camera and the subject's sphere.
Overlay SphereOverlay(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject,
                      const Rgba& color);

// The one thing to do now, a line for arm's length.
struct Instruction {
  std::string words;
  bool urgent = false;  // nothing is recorded until it is done
};
Instruction InstructionFor(const CaptureState& state);

}  // namespace ulf
