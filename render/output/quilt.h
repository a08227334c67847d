// Renders quilts for light-field displays (Looking Glass and others): one picture of many tiles, each the
// scene from one viewpoint.
//
// It follows "Quilts" and "Camera" of docs.lookingglassfactory.com. The display is a window in the plane of
// focus. All viewpoints stand on a line parallel to the window, at equal steps of the angle seen from it, and
// look in the same direction; each frustum is sheared so that it goes through the window (off its axis),
// never rotated towards the subject: that would tilt the plane of focus and give vertical parallax. Tile 0,
// the leftmost viewpoint, is at the bottom left; tiles follow from left to right, then upwards. The file's
// name holds the display's aspect (_qs8x6a0.75: columns x rows, width over height), as tiles may be squeezed.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/renderer/renderer.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct QuiltFormat {
  int columns = 8, rows = 6;
  int width_px = 3360, height_px = 3360;  // maximum size of the quilt; tiles have whole pixels
  double aspect = 0.75;                   // of the display: width over height
};

// The settings that the maker gives for each display.
struct NamedQuilt {
  const char* display;
  QuiltFormat format;
};
const std::vector<NamedQuilt>& QuiltDisplays();
// Throws Refusal that lists the names.
QuiltFormat QuiltOfDisplay(const std::string& name);

struct QuiltOptions {
  QuiltFormat format = {};
  // The angle under which the viewpoints are seen from the middle of the window, radians; none: as much as
  // the recorded viewpoints cover, up to kMostViewCone.
  std::optional<double> view_cone = {};
  double zoom = 1;  // of the window; at 1 the subject's sphere fits
};
// Displays show 53 to 58 degrees, depending on the model.
inline constexpr double kMostViewCone = 54 * 3.14159265358979323846 / 180;

struct QuiltViews {
  std::vector<CameraModel> cameras;  // one for each tile, in the order of the tiles
  std::vector<Rigid3> cam_from_world;
  double view_cone = 0;  // radians
  int outside = 0;       // number of viewpoints outside the recorded ones' hull
  // The window, world frame.
  Eigen::Vector3d window_center = Eigen::Vector3d::Zero(), right = Eigen::Vector3d::UnitX(),
                  up = Eigen::Vector3d::UnitY();  // unit
  double width = 0, height = 0;                   // world units
};

// Places the window at the subject's surface as the proxy's triangles show it from the middle of the recorded
// viewpoints (the median depth within its sphere), or at its centre if there are none. The window faces that
// middle, and the line of viewpoints goes through it. Throws Refusal for an invalid format (fewer than 2
// tiles, tiles below 16 pixels).
QuiltViews QuiltViewsOf(const RenderScene& scene, const QuiltOptions& options);

// Returns 8-bit sRGB. `progress` is called after each tile.
cv::Mat DrawQuilt(Renderer& renderer, const QuiltViews& views, const QuiltFormat& format,
                  const std::function<void(int done)>& progress = {});

// Returns "NAME_qs8x6a0.75.png".
std::string QuiltName(const std::string& name, const QuiltFormat& format);

}  // namespace ulf::render
