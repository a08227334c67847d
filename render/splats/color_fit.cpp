#include "render/splats/color_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "render/splats/splat_renderer.h"

namespace ulf::render {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Eigen::Vector4f;

// Pixels of full weight that speak for no change: few pixels of few views move a colour little.
constexpr float kStaying = 0.3f;
// Share of a Gaussian's weight that speaks against a change of colour with direction.
constexpr float kEvenness = 0.01f;
// A Gaussian that differs less from what is behind it keeps its shape, of full scale. Guessed.
constexpr float kShapeContrast = 0.05f;
constexpr float kShapeStaying = 0.003f;  // pixels of full contrast that speak for no change of a shape
// A step is right for small changes only: those of opacity, and of the logarithm of size.
constexpr float kLargestShapeStep = 0.2f;
constexpr float kLeastOpacity = 0.02f, kMostOpacity = 0.98f;

// A Gaussian's normal equations for the change of its harmonics, in units of colour, and what
// SplatShare tells of its shape.
struct ColorEquations {
  Matrix4f products = Matrix4f::Zero();
  Eigen::Matrix<float, 4, 3> right = Eigen::Matrix<float, 4, 3>::Zero();
  Eigen::Vector2f shape_slope = Eigen::Vector2f::Zero(), shape_curvature = Eigen::Vector2f::Zero();
};

const Vector4f kHarmonicUnits(kConstantHarmonic, kLinearHarmonic, kLinearHarmonic, kLinearHarmonic);

void Correct(const ColorEquations& equations, Gaussian& gaussian) {
  const float weight = equations.products(0, 0);
  if (!(weight > 0)) return;
  const Vector4f against(0, kEvenness * weight, kEvenness * weight, kEvenness * weight);
  Eigen::Matrix<float, 4, 3> right = equations.right;
  for (int h = 1; h < 4; ++h)
    right.row(h) -= against[h] * kHarmonicUnits[h] * gaussian.harmonics[At(h)].transpose();
  Matrix4f products = equations.products;
  products.diagonal() += against + Vector4f::Constant(kStaying);
  const Eigen::Matrix<float, 4, 3> change = products.ldlt().solve(right);
  for (int h = 0; h < 4; ++h) gaussian.harmonics[At(h)] += change.row(h).transpose() / kHarmonicUnits[h];
}

void Reshape(const ColorEquations& equations, Gaussian& gaussian) {
  const float weight = equations.products(0, 0);
  if (!(weight > 0)) return;
  const float staying = kShapeContrast * kShapeContrast * weight + kShapeStaying;
  const Eigen::Array2f change =
      (equations.shape_slope.array() / (equations.shape_curvature.array() + staying))
          .max(-kLargestShapeStep)
          .min(kLargestShapeStep);
  gaussian.opacity = std::clamp(gaussian.opacity + change[0], kLeastOpacity, kMostOpacity);
  gaussian.scale *= std::exp(change[1]);
}

// Corrects the Gaussians from `first` to `end`.
void CorrectSome(const std::vector<SplatComparison>& comparisons, const std::vector<Vector3f>& centers,
                 std::size_t first, std::size_t end, Gaussians& gaussians, std::vector<float>& weights,
                 bool with_shapes) {
  std::vector<ColorEquations> equations(end - first);
  for (std::size_t v = 0; v < comparisons.size(); ++v) {
    const auto& shares = comparisons[v].shares;
    auto share =
        std::ranges::lower_bound(shares, static_cast<std::uint32_t>(first), {}, &SplatShare::gaussian);
    for (; share != shares.end() && share->gaussian < end; ++share) {
      const Vector3f direction = (gaussians[share->gaussian].position_in_world - centers[v]).normalized();
      const Vector4f basis = HarmonicsAt(direction).cwiseQuotient(kHarmonicUnits);
      ColorEquations& own = equations[share->gaussian - first];
      own.products += share->weight * basis * basis.transpose();
      own.right += basis * share->difference.transpose();
      own.shape_slope += share->shape_slope;
      own.shape_curvature += share->shape_curvature;
      weights[share->gaussian] += share->weight;
    }
  }
  for (std::size_t i = first; i < end; ++i) {
    Correct(equations[i - first], gaussians[i]);
    if (with_shapes) Reshape(equations[i - first], gaussians[i]);
  }
}

}  // namespace

ColorFitSummary FitColors(const std::vector<ColorFitView>& views, Gaussians& gaussians,
                          const ColorFitOptions& options) {
  ColorFitSummary summary;
  constexpr std::size_t kFewestBatches = 3;
  const std::size_t at_once = std::clamp<std::size_t>(views.size() / kFewestBatches, 1, At(options.at_once));
  const std::size_t batches = (views.size() + at_once - 1) / at_once;
  std::size_t done = 0;
  for (int round = 0; round < options.rounds; ++round) {
    double squared_error = 0, values = 0;
    const bool with_shapes = options.shapes && round > 0 && round + 1 < options.rounds;
    summary.weights.assign(gaussians.size(), 0);
    for (std::size_t batch = 0; batch < batches; ++batch) {
      std::vector<const ColorFitView*> chosen;
      for (std::size_t v = batch; v < views.size(); v += batches) chosen.push_back(&views[v]);
      std::vector<SplatComparison> comparisons(chosen.size());
      ParallelFor(chosen.size(), [&](std::size_t i) {
        comparisons[i] = CompareSplats(gaussians, chosen[i]->camera, chosen[i]->cam_from_world,
                                       chosen[i]->photograph, with_shapes);
      });
      std::vector<Vector3f> centers;
      for (const ColorFitView* view : chosen)
        centers.push_back(view->cam_from_world.OriginInSource().cast<float>());
      constexpr std::size_t kSome = 4096;
      ParallelFor((gaussians.size() + kSome - 1) / kSome, [&](std::size_t part) {
        CorrectSome(comparisons, centers, part * kSome, std::min(gaussians.size(), (part + 1) * kSome),
                    gaussians, summary.weights, with_shapes);
      });
      for (const SplatComparison& comparison : comparisons) {
        squared_error += comparison.squared_error;
        values += 3.0 * static_cast<double>(comparison.pixels);
      }
      done += chosen.size();
      if (options.progress)
        options.progress(static_cast<double>(done) / static_cast<double>(At(options.rounds) * views.size()));
    }
    summary.psnr_db.push_back(squared_error > 0 ? 10 * std::log10(values / squared_error) : 100);
  }
  return summary;
}

}  // namespace ulf::render
