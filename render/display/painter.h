// Flat drawing on a surface: pictures, shapes of an overlay, boxes and text. Dear ImGui's draw lists and font
// atlas do the work (nothing else of it is used), OpenGL gets all of a frame in a few calls. A surface's
// context is current.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>

#include "render/display/shapes.h"

namespace ulf::render {

// Where a picture lies on the screen, whole and undistorted in its aspect; pixels.
struct Placement {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double scale = 1;
  cv::Size2d picture;
  static Placement Letterboxed(const cv::Size& picture, const cv::Size& screen);
  Eigen::Vector2d ScreenFromImg(const Eigen::Vector2d& img) const { return origin + scale * img; }
  Eigen::Vector2d ImgFromScreen(const Eigen::Vector2d& screen) const { return (screen - origin) / scale; }
  cv::Rect2d Area() const { return {origin.x(), origin.y(), scale * picture.width, scale * picture.height}; }
};

// Sizes of text, in points; others are brought to the nearest.
enum class TextSize { kSmall, kMedium, kLarge };

class Painter {
 public:
  Painter();
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  // A frame on a screen of this size in pixels, with so many pixels a point.
  void Begin(const cv::Size& screen, double pixels_per_point);
  void Picture(unsigned texture, const cv::Rect2d& area, double opacity = 1);
  // The part of a picture right of `from`, a share of its width.
  void PictureRightOf(unsigned texture, const cv::Rect2d& area, double from);
  void Draw(const Overlay& overlay, const Placement& placement);
  void Box(const cv::Rect2d& area, const Rgba& color, double corner_points = 4);
  void Gradient(const cv::Rect2d& area, const Rgba& left, const Rgba& right);
  void Disc(const Eigen::Vector2d& middle, double radius_points, const Rgba& color);
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_points, const Rgba& color);
  void Text(const Eigen::Vector2d& upper_left, const std::string& text, TextSize size, const Rgba& color,
            double wrap_px = 0);
  Eigen::Vector2d Extent(const std::string& text, TextSize size, double wrap_px = 0) const;
  void End();  // all of it goes to the framebuffer that is bound

 private:
  void MakeFonts(double pixels_per_point);
  double pixels_per_point_ = 0;  // that fonts were made for
};

}  // namespace ulf::render
