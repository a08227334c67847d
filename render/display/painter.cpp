#include "render/display/painter.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include "core/base/error.h"

namespace ulf::render {
namespace {

constexpr std::array kPoints{17.0, 23.0, 36.0};  // by TextSize

ImU32 Packed(const Rgba& color) { return IM_COL32(color.r, color.g, color.b, color.a); }
ImVec2 Vec(const Eigen::Vector2d& at) { return {static_cast<float>(at.x()), static_cast<float>(at.y())}; }
ImVec2 Low(const cv::Rect2d& area) { return Vec({area.x, area.y}); }
ImVec2 High(const cv::Rect2d& area) { return Vec({area.x + area.width, area.y + area.height}); }
ImTextureID Id(unsigned texture) {
  return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture));
}
ImDrawList& Canvas() { return *ImGui::GetBackgroundDrawList(); }
ImFont* Font(TextSize size) { return ImGui::GetIO().Fonts->Fonts[static_cast<int>(size)]; }
TextSize Nearest(double points) {
  const auto nearer = [points](double a, double b) { return std::abs(a - points) < std::abs(b - points); };
  return static_cast<TextSize>(std::ranges::min_element(kPoints, nearer) - kPoints.begin());
}

// Draws shapes of an overlay into a draw list.
class ShapeDrawer {
 public:
  ShapeDrawer(ImDrawList& list, const Placement& placement, double pixels_per_point)
      : list_(list), placement_(placement), pixels_(pixels_per_point) {}

  void operator()(const Polyline& line) {
    points_.clear();
    for (const Eigen::Vector2d& img : line.img) points_.push_back(On(img));
    list_.AddPolyline(points_.data(), static_cast<int>(points_.size()), Packed(line.color),
                      line.closed ? ImDrawFlags_Closed : ImDrawFlags_None, Px(line.width));
  }
  void operator()(const Polygon& polygon) {
    points_.clear();
    // Dear ImGui smooths edges only of polygons that are clockwise on the screen.
    double twice_area = 0;
    for (std::size_t i = 0; i < polygon.img.size(); ++i) {
      const Eigen::Vector2d &a = polygon.img[i], &b = polygon.img[(i + 1) % polygon.img.size()];
      twice_area += a.x() * b.y() - a.y() * b.x();
    }
    for (const Eigen::Vector2d& img : polygon.img) points_.push_back(On(img));
    if (twice_area < 0) std::ranges::reverse(points_);
    list_.AddConvexPolyFilled(points_.data(), static_cast<int>(points_.size()), Packed(polygon.color));
  }
  void operator()(const Patch& patch) {
    list_.PrimReserve(6, 4);
    list_.PrimQuadUV(On(patch.img[0]), On(patch.img[1]), On(patch.img[2]), On(patch.img[3]), White(), White(),
                     White(), White(), Packed(patch.color));
  }
  void operator()(const Spot& spot) {
    list_.AddCircleFilled(On(spot.img), Px(spot.radius), Packed(spot.color));
  }
  void operator()(const Label& label) {
    const TextSize size = Nearest(label.size);
    ImFont* font = Font(size);
    const ImVec2 extent = font->CalcTextSizeA(font->FontSize, FLT_MAX, 0, label.text.c_str());
    const float pad = Px(6);
    const Eigen::Vector2d box(extent.x + 2 * pad, extent.y + pad);
    const Eigen::Vector2d low =
        (placement_.ScreenFromImg(label.img) - label.anchor.cwiseProduct(box)).array().round();
    list_.AddRectFilled(Vec(low), Vec(low + box), IM_COL32(0, 0, 0, 175), Px(4));
    list_.AddText(font, font->FontSize, Vec(low + Eigen::Vector2d(pad, 0.5 * pad)), Packed(label.color),
                  label.text.c_str());
  }

 private:
  static ImVec2 White() { return ImGui::GetFontTexUvWhitePixel(); }
  ImVec2 On(const Eigen::Vector2d& img) const { return Vec(placement_.ScreenFromImg(img)); }
  float Px(double points) const { return static_cast<float>(points * pixels_); }

  ImDrawList& list_;
  const Placement& placement_;
  double pixels_;
  std::vector<ImVec2> points_;
};

}  // namespace

Placement Placement::Letterboxed(const cv::Size& picture, const cv::Size& screen) {
  Placement placement;
  placement.picture = picture;
  if (picture.empty()) return placement;
  placement.scale = std::min(static_cast<double>(screen.width) / picture.width,
                             static_cast<double>(screen.height) / picture.height);
  placement.origin = 0.5 * (Eigen::Vector2d(screen.width, screen.height) -
                            placement.scale * Eigen::Vector2d(picture.width, picture.height));
  return placement;
}

void Painter::DestroyContext::operator()(ImGuiContext* context) const { ImGui::DestroyContext(context); }

Painter::Painter() : context_(ImGui::CreateContext()) {
  IMGUI_CHECKVERSION();
  ImGui::SetCurrentContext(context_.get());  // an old one may still exist (SurfaceGone)
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  if (!ImGui_ImplOpenGL3_Init("#version 450 core"))
    throw Error("OpenGL: Dear ImGui cannot draw with this driver");
}

Painter::~Painter() {
  ImGui::SetCurrentContext(context_.get());
  ImGui_ImplOpenGL3_Shutdown();
}

void Painter::MakeFonts(double pixels_per_point) {
  pixels_per_point_ = pixels_per_point;
  static constexpr const char* kFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  static const ImWchar kGlyphs[] = {0x20, 0xff, 0x2013, 0x2026, 0x2190, 0x2193, 0};
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.Clear();
  for (const double points : kPoints) {
    const auto pixels = static_cast<float>(std::round(points * pixels_per_point));
    if (std::filesystem::exists(kFile)) {
      fonts.AddFontFromFileTTF(kFile, pixels, nullptr, kGlyphs);
    } else {
      ImFontConfig config;
      config.SizePixels = pixels;
      fonts.AddFontDefault(&config);  // Dear ImGui's own font, which is coarse
    }
  }
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

void Painter::Begin(const cv::Size& screen, double pixels_per_point) {
  ImGui::SetCurrentContext(context_.get());
  if (pixels_per_point != pixels_per_point_) MakeFonts(pixels_per_point);
  ImGui::GetIO().DisplaySize = ImVec2(static_cast<float>(screen.width), static_cast<float>(screen.height));
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

void Painter::Picture(unsigned texture, const cv::Rect2d& area, double opacity) {
  const auto alpha = static_cast<int>(std::lround(255 * opacity));
  Canvas().AddImage(Id(texture), Low(area), High(area), {0, 0}, {1, 1}, IM_COL32(255, 255, 255, alpha));
}

void Painter::PictureRightOf(unsigned texture, const cv::Rect2d& area, double from) {
  const cv::Rect2d right(area.x + from * area.width, area.y, (1 - from) * area.width, area.height);
  Canvas().AddImage(Id(texture), Low(right), High(right), {static_cast<float>(from), 0}, {1, 1});
}

void Painter::Draw(const Overlay& overlay, const Placement& placement) {
  ImDrawList& list = Canvas();
  list.PushClipRect(Low(placement.Area()), High(placement.Area()), true);
  // Text shrinks with a small window; lines do not, because thin lines fade.
  ShapeDrawer drawer(list, placement, std::max(1.0, pixels_per_point_));
  for (const OverlayShape& shape : overlay) std::visit(drawer, shape);
  list.PopClipRect();
}

void Painter::Box(const cv::Rect2d& area, const Rgba& color, double corner_points) {
  Canvas().AddRectFilled(Low(area), High(area), Packed(color),
                         static_cast<float>(corner_points * pixels_per_point_));
}

void Painter::Gradient(const cv::Rect2d& area, const Rgba& left, const Rgba& right) {
  Canvas().AddRectFilledMultiColor(Low(area), High(area), Packed(left), Packed(right), Packed(right),
                                   Packed(left));
}

void Painter::Disc(const Eigen::Vector2d& middle, double radius_points, const Rgba& color) {
  Canvas().AddCircleFilled(Vec(middle), static_cast<float>(radius_points * pixels_per_point_), Packed(color));
}

void Painter::Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_points,
                   const Rgba& color) {
  Canvas().AddLine(Vec(from), Vec(to), Packed(color), static_cast<float>(width_points * pixels_per_point_));
}

void Painter::Text(const Eigen::Vector2d& upper_left, const std::string& text, TextSize size,
                   const Rgba& color, double wrap_px) {
  ImFont* font = Font(size);
  // Letters are sharp at whole pixels.
  Canvas().AddText(font, font->FontSize, Vec(Eigen::Vector2d(upper_left.array().round())), Packed(color),
                   text.c_str(), nullptr, static_cast<float>(wrap_px));
}

Eigen::Vector2d Painter::Extent(const std::string& text, TextSize size, double wrap_px) const {
  ImFont* font = Font(size);
  const ImVec2 extent =
      font->CalcTextSizeA(font->FontSize, FLT_MAX, static_cast<float>(wrap_px), text.c_str());
  return {std::ceil(extent.x), extent.y};
}

void Painter::End() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace ulf::render
