#include "render/output/texture_baking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/image/image.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Texels whose middles are so far from a triangle still show its plane.
constexpr double kBeyondEdge = 1.5;

// A view at a triangle, with its shares at the corners.
struct BlendedView {
  int view = 0;
  std::array<float, 3> share{};
  cv::Mat level;
};

struct BakedTexel {
  cv::Point at;
  Vector3d corners;  // barycentric; a little below 0 outside the triangle
};

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// A chart's part of the page.
struct ChartPatch {
  cv::Rect box;
  cv::Mat linear;  // CV_32FC3
  cv::Mat state;   // CV_8U
  enum : std::uint8_t { kEmpty, kBeyond, kInside };
};

class ChartBaker {
 public:
  ChartBaker(const RenderScene& scene, const TextureAtlas& atlas, const std::vector<ViewShares>& shares)
      : scene_(scene), atlas_(atlas), shares_(shares) {}

  ChartPatch Bake(std::size_t chart) const {
    const std::size_t begin = atlas_.chart_begins[chart];
    const std::size_t end = chart + 1 < atlas_.chart_begins.size() ? atlas_.chart_begins[chart + 1]
                                                                   : atlas_.mesh.triangles.size();
    Eigen::Vector2f low = Eigen::Vector2f::Constant(1e30f), high = -low;
    for (std::size_t i = begin; i < end; ++i)
      for (const std::uint32_t corner : atlas_.mesh.triangles[i]) {
        low = low.cwiseMin(atlas_.texel[corner]);
        high = high.cwiseMax(atlas_.texel[corner]);
      }
    ChartPatch patch;
    const cv::Point from(static_cast<int>(std::floor(low.x())) - kChartPadding,
                         static_cast<int>(std::floor(low.y())) - kChartPadding);
    const cv::Point to(static_cast<int>(std::floor(high.x())) + kChartPadding + 1,
                       static_cast<int>(std::floor(high.y())) + kChartPadding + 1);
    patch.box = cv::Rect(from, to) & cv::Rect(0, 0, atlas_.width, atlas_.height);
    patch.linear = cv::Mat(patch.box.size(), CV_32FC3, cv::Scalar::all(0));
    patch.state = cv::Mat(patch.box.size(), CV_8U, cv::Scalar(ChartPatch::kEmpty));
    for (std::size_t i = begin; i < end; ++i) BakeTriangle(i, patch);
    return patch;
  }

 private:
  std::vector<BlendedView> ViewsOf(const std::array<std::uint32_t, 3>& triangle, double texel_area) const {
    std::vector<BlendedView> views;
    for (std::size_t c = 0; c < 3; ++c)
      for (const auto& [view, weight] : shares_[atlas_.source[triangle[c]]]) {
        auto found = std::ranges::find(views, view, &BlendedView::view);
        if (found == views.end()) found = views.insert(views.end(), BlendedView{view, {}, {}});
        found->share[c] = weight;
      }
    for (BlendedView& blended : views) {
      const SceneView& view = scene_.views[At(blended.view)];
      std::array<Vector2d, 3> img;
      double pixels = texel_area;
      bool all = true;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at =
            view.camera.ImgFromCam(view.cam_from_world * atlas_.mesh.vertices[triangle[c]].cast<double>());
        if (at) img[c] = *at;
        all = all && at;
      }
      if (all) pixels = std::abs(Cross(img[1] - img[0], img[2] - img[0]));
      const double ratio = pixels / std::max(texel_area, 1e-9);
      const int level = static_cast<int>(std::lround(0.5 * std::log2(std::max(1.0, ratio))));
      blended.level = view.photograph->Level(std::min(level, view.photograph->LevelCount() - 1));
    }
    return views;
  }

  std::vector<BakedTexel> TexelsOf(const std::array<Vector2d, 3>& place, const ChartPatch& patch) const {
    const double area = Cross(place[1] - place[0], place[2] - place[0]);
    std::vector<BakedTexel> texels;
    Vector2d low = place[0].cwiseMin(place[1]).cwiseMin(place[2]),
             high = place[0].cwiseMax(place[1]).cwiseMax(place[2]);
    low.array() -= kBeyondEdge;
    high.array() += kBeyondEdge;
    std::array<double, 3> beyond{};  // in barycentric coordinates
    for (std::size_t c = 0; c < 3; ++c)
      beyond[c] =
          kBeyondEdge * (place[(c + 2) % 3] - place[(c + 1) % 3]).norm() / std::max(std::abs(area), 1e-12);
    for (int y = std::max(patch.box.y, static_cast<int>(std::floor(low.y())));
         y < std::min(patch.box.y + patch.box.height, static_cast<int>(std::ceil(high.y()))); ++y)
      for (int x = std::max(patch.box.x, static_cast<int>(std::floor(low.x())));
           x < std::min(patch.box.x + patch.box.width, static_cast<int>(std::ceil(high.x()))); ++x) {
        const Vector2d middle(x + 0.5, y + 0.5);
        Vector3d corners = Vector3d::Constant(1.0 / 3);
        if (std::abs(area) > 1e-9)
          corners = Vector3d(Cross(place[1] - middle, place[2] - middle),
                             Cross(place[2] - middle, place[0] - middle),
                             Cross(place[0] - middle, place[1] - middle)) /
                    area;
        if (corners[0] >= -beyond[0] && corners[1] >= -beyond[1] && corners[2] >= -beyond[2])
          texels.push_back({cv::Point(x, y) - patch.box.tl(), corners});
      }
    return texels;
  }

  void BakeTriangle(std::size_t index, ChartPatch& patch) const {
    const auto& triangle = atlas_.mesh.triangles[index];
    std::array<Vector2d, 3> place;
    std::array<Vector3d, 3> point;
    for (std::size_t c = 0; c < 3; ++c) {
      place[c] = atlas_.texel[triangle[c]].cast<double>();
      point[c] = atlas_.mesh.vertices[triangle[c]].cast<double>();
    }
    std::vector<BlendedView> views;
    for (const auto& [at, corners] : TexelsOf(place, patch)) {
      const std::uint8_t state = corners.minCoeff() >= -1e-9 ? ChartPatch::kInside : ChartPatch::kBeyond;
      std::uint8_t& known = patch.state.at<std::uint8_t>(at);
      if (known >= state) continue;
      if (views.empty()) views = ViewsOf(triangle, std::abs(Cross(place[1] - place[0], place[2] - place[0])));
      // Slivers reach far beyond their edges: no farther than their corners' shares.
      const Vector3d inside = corners.cwiseMax(0) / corners.cwiseMax(0).sum();
      const Vector3d surface = corners[0] * point[0] + corners[1] * point[1] + corners[2] * point[2];
      if (const auto light = LightAt(views, surface, inside)) {
        patch.linear.at<cv::Vec3f>(at) = *light;
        known = state;
      }
    }
  }

  std::optional<cv::Vec3f> LightAt(const std::vector<BlendedView>& views, const Vector3d& surface,
                                   const Vector3d& corners) const {
    cv::Vec3f sum(0, 0, 0);
    float weights = 0;
    for (const BlendedView& blended : views) {
      const float share = static_cast<float>(corners[0]) * blended.share[0] +
                          static_cast<float>(corners[1]) * blended.share[1] +
                          static_cast<float>(corners[2]) * blended.share[2];
      if (!(share > 0)) continue;
      const SceneView& view = scene_.views[At(blended.view)];
      const auto img = view.camera.ImgFromCam(view.cam_from_world * surface);
      if (!img || !view.camera.Contains(*img)) continue;
      const cv::Vec4f light = LightOfView(view, blended.level, *img);
      sum += cv::Vec3f(light[0], light[1], light[2]) * (share * light[3]);
      weights += share * light[3];
    }
    if (!(weights > 0)) return std::nullopt;
    return sum / weights;
  }

  const RenderScene& scene_;
  const TextureAtlas& atlas_;
  const std::vector<ViewShares>& shares_;
};

// The rest of the patch repeats what is nearest.
void FillRest(ChartPatch& patch) {
  const cv::Mat unknown = patch.state == ChartPatch::kEmpty;
  const int holes = cv::countNonZero(unknown);
  if (holes == 0 || holes == static_cast<int>(unknown.total())) return;
  cv::Mat distance, nearest;
  cv::distanceTransform(unknown, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Point> of_label(unknown.total() + 1);
  for (int y = 0; y < unknown.rows; ++y)
    for (int x = 0; x < unknown.cols; ++x)
      if (!unknown.at<std::uint8_t>(y, x)) of_label[At(nearest.at<int>(y, x))] = {x, y};
  for (int y = 0; y < unknown.rows; ++y)
    for (int x = 0; x < unknown.cols; ++x)
      if (unknown.at<std::uint8_t>(y, x))
        patch.linear.at<cv::Vec3f>(y, x) = patch.linear.at<cv::Vec3f>(of_label[At(nearest.at<int>(y, x))]);
}

}  // namespace

cv::Mat BakeTexture(const RenderScene& scene, const TextureAtlas& atlas,
                    const std::vector<ViewShares>& shares) {
  const ChartBaker baker(scene, atlas, shares);
  cv::Mat page(atlas.height, atlas.width, CV_8UC3, cv::Scalar::all(128));
  // Boxes of charts do not overlap.
  ParallelFor(atlas.Charts(), [&](std::size_t chart) {
    ChartPatch patch = baker.Bake(chart);
    FillRest(patch);
    Srgb8FromLinear(patch.linear).copyTo(page(patch.box));
  });
  return page;
}

}  // namespace ulf::render
