// Draws in two dimensions on a surface: pictures, shapes of an overlay, boxes and text. It uses Dear ImGui's
// draw lists and font atlas and nothing else of that library; OpenGL gets a whole frame in a few calls. The
// surface's context must be current. Places and areas are pixels of the screen from its upper left corner.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "render/display/shapes.h"

struct ImGuiContext;

namespace ulf::render {

// The place of a whole picture on the screen; its aspect ratio is kept.
struct Placement {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // of its upper left corner
  double scale = 1;                                  // pixels of the screen for one of the picture
  cv::Size2d picture;
  // Returns the largest place in the middle of the screen.
  static Placement Letterboxed(const cv::Size& picture, const cv::Size& screen);
  Eigen::Vector2d ScreenFromImg(const Eigen::Vector2d& img) const { return origin + scale * img; }
  cv::Rect2d Area() const { return {origin.x(), origin.y(), scale * picture.width, scale * picture.height}; }
};

// Text has 17, 23 or 36 points. Labels with other sizes get the nearest.
enum class TextSize { kSmall, kMedium, kLarge };

class Painter {
 public:
  Painter();
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  // Begins a frame on a screen of this size in pixels; all other functions come between Begin() and End().
  void Begin(const cv::Size& screen, double pixels_per_point);
  void Picture(unsigned texture, const cv::Rect2d& area, double opacity = 1);
  // Draws the part of a picture to the right of `from`, a share of its width.
  void PictureRightOf(unsigned texture, const cv::Rect2d& area, double from);
  void Draw(const Overlay& overlay, const Placement& placement);  // over the placed picture, clipped to it
  void Box(const cv::Rect2d& area, const Rgba& color, double corner_points = 4);
  void Gradient(const cv::Rect2d& area, const Rgba& left, const Rgba& right);
  void Disc(const Eigen::Vector2d& middle, double radius_points, const Rgba& color);
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_points, const Rgba& color);
  // `wrap_px` is the width at which lines break; 0: they do not. Extent() is the text's size in pixels.
  void Text(const Eigen::Vector2d& upper_left, const std::string& text, TextSize size, const Rgba& color,
            double wrap_px = 0);
  Eigen::Vector2d Extent(const std::string& text, TextSize size, double wrap_px = 0) const;
  void End();  // draws the frame to the bound framebuffer

 private:
  struct DestroyContext {
    void operator()(ImGuiContext* context) const;
  };

  void MakeFonts(double pixels_per_point);

  std::unique_ptr<ImGuiContext, DestroyContext> context_;
  double pixels_per_point_ = 0;  // of the current fonts
};

}  // namespace ulf::render
