#include "render/output/texture_atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <unordered_map>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/image/image.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using CornerIndices = std::array<std::uint32_t, 3>;

constexpr double kShownWell = 0.5;   // share of the largest area at which any view shows a triangle. Guessed.
constexpr double kLeastSeen = 0.25;  // of a triangle's middle. Guessed.
constexpr int kNoChart = -1;

std::array<Vector3d, 3> CornersOf(const TriangleMesh& mesh, const CornerIndices& triangle) {
  return {mesh.vertices[triangle[0]].cast<double>(), mesh.vertices[triangle[1]].cast<double>(),
          mesh.vertices[triangle[2]].cast<double>()};
}

// Returns twice the signed area in the view's image, px; none if the view does not show the whole triangle.
std::optional<double> AreaIn(const SceneView& view, const std::array<Vector3d, 3>& corners) {
  std::array<Vector2d, 3> img;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto seen = view.Project(corners[i]);
    if (!seen) return std::nullopt;
    img[i] = seen->img;
  }
  const Vector2d a = img[1] - img[0], b = img[2] - img[0];
  return a.x() * b.y() - a.y() * b.x();
}

struct ShownBy {
  int view;
  bool flipped;  // seen from behind
};

// Returns the views that show a triangle well.
std::vector<ShownBy> ShownWell(const RenderScene& scene, const std::array<Vector3d, 3>& corners) {
  const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3;
  std::vector<std::pair<int, double>> areas;
  double most = 0;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const auto area = AreaIn(scene.views[i], corners);
    if (!area || !(std::abs(*area) > 0)) continue;
    const auto seen = scene.views[i].ProjectVisible(middle);
    if (!seen || seen->feather < kLeastSeen) continue;
    areas.emplace_back(static_cast<int>(i), *area);
    most = std::max(most, std::abs(*area));
  }
  std::vector<ShownBy> shown;
  for (const auto& [view, area] : areas)
    if (std::abs(area) >= kShownWell * most) shown.push_back({view, area < 0});
  return shown;
}

// Returns the view of each triangle's chart, times two, odd if it is seen from behind; or kNoChart.
std::vector<int> LabelsOf(const RenderScene& scene, const TriangleMesh& mesh) {
  std::vector<std::vector<ShownBy>> shown(mesh.triangles.size());
  std::vector<double> area(shown.size());
  const auto look = [&](std::size_t i) {
    const auto corners = CornersOf(mesh, mesh.triangles[i]);
    shown[i] = ShownWell(scene, corners);
    area[i] = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
  };
  ParallelFor(shown.size(), look, static_cast<double>(shown.size()) / 1024);
  std::vector<double> gain(scene.views.size(), 0);
  std::vector<std::vector<std::uint32_t>> of_view(scene.views.size());
  for (std::size_t i = 0; i < shown.size(); ++i)
    for (const ShownBy& by : shown[i]) {
      gain[At(by.view)] += area[i];
      of_view[At(by.view)].push_back(static_cast<std::uint32_t>(i));
    }
  std::vector<int> labels(shown.size(), kNoChart);
  std::vector<bool> is_used(scene.views.size(), false);
  for (std::size_t round = 0; round < scene.views.size(); ++round) {
    int best = -1;
    for (std::size_t v = 0; v < gain.size(); ++v)
      if (!is_used[v] && (best < 0 || gain[v] > gain[At(best)])) best = static_cast<int>(v);
    is_used[At(best)] = true;
    for (const std::uint32_t i : of_view[At(best)]) {
      if (labels[i] != kNoChart) continue;
      for (const ShownBy& by : shown[i]) {
        gain[At(by.view)] -= area[i];
        if (by.view == best) labels[i] = 2 * best + by.flipped;
      }
    }
  }
  return labels;
}

class ChartSets {
 public:
  explicit ChartSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t Find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::uint32_t a, std::uint32_t b) { parent_[Find(a)] = Find(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

// Returns the triangles of each chart: of one label, connected along edges.
std::vector<std::vector<std::uint32_t>> ChartsOf(const TriangleMesh& mesh, const std::vector<int>& labels) {
  ChartSets sets(mesh.triangles.size());
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> at_edge;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (labels[i] == kNoChart) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = mesh.triangles[i][c], b = mesh.triangles[i][(c + 1) % 3];
      auto& others = at_edge[(static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b)];
      for (const std::uint32_t other : others)
        if (labels[other] == labels[i]) sets.Join(i, other);
      others.push_back(i);
    }
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> charts;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (labels[i] != kNoChart) charts[sets.Find(i)].push_back(i);
  std::vector<std::vector<std::uint32_t>> lists;
  for (auto& [first, triangles] : charts) lists.push_back(std::move(triangles));
  return lists;
}

// A chart before it is placed.
struct ChartPiece {
  std::uint32_t first_vertex = 0, vertices = 0;
  Vector2d low = Vector2d::Zero(), high = Vector2d::Zero();  // px of its photograph
  int left = 0, top = 0;                                     // of its box on the page, padding included
  cv::Size BoxAt(double scale) const {
    const Vector2d size = scale * (high - low);
    return {static_cast<int>(std::ceil(size.x())) + 1 + 2 * kChartPadding,
            static_cast<int>(std::ceil(size.y())) + 1 + 2 * kChartPadding};
  }
};

// Packs in shelves, highest first; returns false if they do not fit.
bool Pack(std::vector<ChartPiece>& pieces, double scale, int width, int height) {
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](std::size_t i) { return pieces[i].BoxAt(scale).height; });
  int left = 0, top = 0, shelf = 0;
  for (const std::size_t i : order) {
    const cv::Size box = pieces[i].BoxAt(scale);
    if (left + box.width > width) {
      left = 0;
      top += shelf;
      shelf = 0;
    }
    if (box.width > width || top + box.height > height) return false;
    shelf = std::max(shelf, box.height);
    pieces[i].left = left;
    pieces[i].top = top;
    left += box.width;
  }
  return true;
}

// Uses the smallest page at full size, or the largest page at the scale that fits.
void PackOnPage(std::vector<ChartPiece>& pieces, int most_px, TextureAtlas& atlas) {
  constexpr int kLeastPage = 64;
  for (int side = kLeastPage; side <= most_px; side *= 2)
    for (const int height : {side / 2, side})
      if (Pack(pieces, 1, side, height)) {
        atlas.width = side;
        atlas.height = height;
        return;
      }
  atlas.width = atlas.height = most_px;
  double fits = 0, too_large = 1;
  if (!Pack(pieces, 0, most_px, most_px))
    throw Error(
        "a texture of {0}x{0} pixels is too small for {1} pieces of surface: give a larger {2}, or fewer {3}",
        most_px, pieces.size(), Parameter("texture"), Parameter("triangles"));
  for (int step = 0; step < 12; ++step) {
    const double middle = 0.5 * (fits + too_large);
    (Pack(pieces, middle, most_px, most_px) ? fits : too_large) = middle;
  }
  atlas.scale = fits;
  Pack(pieces, fits, most_px, most_px);
}

}  // namespace

TextureAtlas MakeTextureAtlas(const RenderScene& scene, const TriangleMesh& mesh, int most_page_px) {
  const std::vector<int> labels = LabelsOf(scene, mesh);
  TextureAtlas atlas;
  atlas.unseen = static_cast<std::size_t>(std::ranges::count(labels, kNoChart));
  if (atlas.unseen == labels.size())
    throw Error("no view sees any of the mesh's {} triangles: is it in the light field's world?",
                labels.size());
  std::vector<ChartPiece> pieces;
  std::vector<Vector2d> in_photograph;
  for (const std::vector<std::uint32_t>& chart : ChartsOf(mesh, labels)) {
    ChartPiece& piece = pieces.emplace_back();
    piece.first_vertex = static_cast<std::uint32_t>(atlas.source.size());
    piece.low = Vector2d::Constant(1e300);
    piece.high = -piece.low;
    atlas.chart_begins.push_back(static_cast<std::uint32_t>(atlas.mesh.triangles.size()));
    const SceneView& view = scene.views[At(labels[chart.front()] / 2)];
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    for (const std::uint32_t i : chart) {
      CornerIndices corners;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t from = mesh.triangles[i][c];
        const auto [at, is_new] = number.try_emplace(from, static_cast<std::uint32_t>(atlas.source.size()));
        corners[c] = at->second;
        if (!is_new) continue;
        atlas.source.push_back(from);
        atlas.mesh.vertices.push_back(mesh.vertices[from]);
        const Vector2d img = view.Project(mesh.vertices[from].cast<double>())->img;
        in_photograph.push_back(img);
        piece.low = piece.low.cwiseMin(img);
        piece.high = piece.high.cwiseMax(img);
      }
      atlas.mesh.triangles.push_back(corners);
    }
    piece.vertices = static_cast<std::uint32_t>(atlas.source.size()) - piece.first_vertex;
  }
  PackOnPage(pieces, most_page_px, atlas);
  atlas.texel.resize(atlas.source.size());
  for (const ChartPiece& piece : pieces)
    for (std::uint32_t i = piece.first_vertex; i < piece.first_vertex + piece.vertices; ++i)
      atlas.texel[i] = (atlas.scale * (in_photograph[i] - piece.low) +
                        Vector2d(piece.left + kChartPadding + 0.5, piece.top + kChartPadding + 0.5))
                           .cast<float>();
  return atlas;
}

namespace {

// Texels with centres up to this distance from a triangle still show its plane.
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
      // Slivers extend far beyond their edges, so shares are limited to those of the corners.
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

// Fills the rest of the patch with the nearest texels.
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
