#include "render/output/surface_views.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kSharing = 4;  // views at a vertex. Guessed.
constexpr double kSharpness = 2;     // power of the shares: the best view leads. Guessed.

ViewShares SharesAt(const RenderScene& scene, const Vector3d& point, const Vector3d& normal) {
  struct Scored {
    int view;
    double score;
  };
  std::vector<Scored> scored;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SceneView& view = scene.views[i];
    const auto seen = view.ProjectVisible(point);
    if (!seen) continue;
    const Vector3d arm = view.center_in_world - point;
    const double distance = arm.norm();
    // Meshes are visible from both sides.
    const double squarely = normal.squaredNorm() > 0 ? std::abs(normal.dot(arm)) / distance : 1;
    scored.push_back({static_cast<int>(i), seen->feather * squarely * view.camera.MeanFocalPx() / distance});
  }
  std::ranges::sort(scored, std::ranges::greater(), &Scored::score);
  const double next = scored.size() > kSharing ? scored[kSharing].score : 0;
  scored.resize(std::min(scored.size(), kSharing));
  ViewShares shares;
  double sum = 0;
  for (const Scored& one : scored) {
    const double weight =
        std::pow(std::max(0.0, one.score - next) / std::max(1e-300, scored.front().score - next), kSharpness);
    if (!(weight > 0)) continue;
    shares.push_back({one.view, static_cast<float>(weight)});
    sum += weight;
  }
  // If very many views have equal scores, any of them is used.
  if (shares.empty() && !scored.empty()) return {{scored.front().view, 1.0f}};
  for (ViewShare& share : shares) share.weight /= static_cast<float>(sum);
  return shares;
}

double MedianEdge(const TriangleMesh& mesh) {
  std::vector<double> edges;
  for (const auto& triangle : mesh.triangles)
    edges.push_back((mesh.vertices[triangle[0]] - mesh.vertices[triangle[1]]).norm());
  return Median(std::move(edges));
}

// Gives unknown vertices the mean of their neighbours, ring by ring.
void SpreadColors(const TriangleMesh& mesh, std::vector<cv::Vec3f>& colors, std::vector<bool>& known) {
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<cv::Vec4f> sums(colors.size(), cv::Vec4f::all(0));
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t to : triangle)
        if (!known[to])
          for (const std::uint32_t from : triangle)
            if (known[from]) sums[to] += cv::Vec4f(colors[from][0], colors[from][1], colors[from][2], 1);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (!(sums[i][3] > 0)) continue;
      colors[i] = cv::Vec3f(sums[i][0], sums[i][1], sums[i][2]) / sums[i][3];
      known[i] = changed = true;
    }
  }
}

}  // namespace

std::vector<ViewShares> SharesOfVertices(const RenderScene& scene, const TriangleMesh& mesh) {
  const std::vector<Eigen::Vector3f> normals = VertexNormals(mesh);
  std::vector<ViewShares> shares(mesh.vertices.size());
  const auto share = [&](std::size_t i) {
    shares[i] = SharesAt(scene, mesh.vertices[i].cast<double>(), normals[i].cast<double>());
  };
  ParallelFor(shares.size(), share, static_cast<double>(shares.size()) / 1024);
  return shares;
}

std::vector<cv::Vec3f> ColorsOfVertices(const RenderScene& scene, const TriangleMesh& mesh,
                                        const std::vector<ViewShares>& shares) {
  const double edge = MedianEdge(mesh);
  std::vector<cv::Vec3f> colors(mesh.vertices.size(), cv::Vec3f::all(0.2f));
  std::vector<std::uint8_t> lit(colors.size(), 0);
  const auto color = [&](std::size_t i) {
    const Vector3d point = mesh.vertices[i].cast<double>();
    cv::Vec3f sum(0, 0, 0);
    float weights = 0;
    for (const auto& [index, weight] : shares[i]) {
      const SceneView& view = scene.views[At(index)];
      const Vector3d in_cam = view.cam_from_world * point;
      const auto img = view.camera.ImgFromCam(in_cam);
      if (!img) continue;
      const double edge_px = view.camera.MeanFocalPx() * edge / in_cam.z();
      const int level = std::clamp(static_cast<int>(std::lround(std::log2(std::max(1.0, edge_px)))), 0,
                                   view.photograph->LevelCount() - 1);
      const cv::Vec4f light = LightOfView(view, view.photograph->Level(level), *img);
      sum += cv::Vec3f(light[0], light[1], light[2]) * (weight * light[3]);
      weights += weight * light[3];
    }
    if (!(weights > 0)) return;
    colors[i] = sum / weights;
    lit[i] = 1;
  };
  ParallelFor(colors.size(), color, static_cast<double>(colors.size()) / 1024);
  std::vector<bool> known(lit.begin(), lit.end());
  SpreadColors(mesh, colors, known);
  return colors;
}

}  // namespace ulf::render
