#include "acquisition/calibration/lens_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace ulf::acquisition {
namespace {

// A better candidate has a BIC lower by more than this: "very strong" evidence (Kass and Raftery 1995) ...
constexpr double kBicMargin = 10;
// A rival's squared error on left-out views must also be lower by so many standard errors. Guessed.
constexpr double kStandardErrors = 2;
// With up to so many views each view is a fold of its own, else there are so many folds. Guessed.
constexpr int kMostSingleFolds = 8, kFolds = 5;

using Eigen::Vector3d;

constexpr double kNoPosePx2 = 1e6;  // mean squared error of a view without a pose or fit; guessed

std::array<double, 9> Parameters(const CameraModel& camera) {
  std::array<double, 9> all{camera.fx, camera.fy, camera.cx, camera.cy};
  std::copy(camera.coefficients.begin(), camera.coefficients.end(), all.begin() + 4);
  return all;
}

double Bic(const LensFit& fit) {
  const double n = 2.0 * static_cast<double>(fit.corners);
  const double parameters = fit.candidate.Parameters() + 6.0 * static_cast<double>(fit.cam_from_board.size());
  return n * std::log(std::max(fit.squared_px, 1e-12) / n) + parameters * std::log(n);
}

bool FoldsInside(const CameraModel& camera) {
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = camera.width * static_cast<double>(i) / kSteps,
                 y = camera.height * static_cast<double>(i) / kSteps;
    for (const Eigen::Vector2d& img : {Eigen::Vector2d(x, 0), Eigen::Vector2d(x, camera.height),
                                       Eigen::Vector2d(0, y), Eigen::Vector2d(camera.width, y)})
      if (!camera.RayFromImg(img)) return true;
  }
  return false;
}

double MeanSquaredPx(const std::vector<Vector3d>& board_points, const BoardView& view,
                     const CameraModel& camera) {
  const auto pose = PoseOfBoard(board_points, view, camera);
  if (!pose) return kNoPosePx2;
  double sum = 0;
  for (const Eigen::Vector2d& residual : Residuals(board_points, view, camera, *pose))
    sum += residual.squaredNorm();
  return sum / static_cast<double>(view.ids.size());
}

// Fits without each fold in turn: sets the errors of the left-out views and the spread of the parameters.
void LeaveOut(const std::vector<Vector3d>& board_points, const std::vector<BoardView>& views, int folds,
              CandidateResult& result) {
  result.left_out_px2.assign(views.size(), kNoPosePx2);
  std::vector<std::array<double, 9>> estimates;
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<BoardView> kept;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (static_cast<int>(v) % folds != fold) kept.push_back(views[v]);
    const LensFit fit = FitLens(board_points, kept, result.fit.candidate, result.fit.camera,
                                {.max_iterations = 30, .with_sigma = false});
    if (!fit.usable) continue;
    estimates.push_back(Parameters(fit.camera));
    for (std::size_t v = 0; v < views.size(); ++v)
      if (static_cast<int>(v) % folds == fold)
        result.left_out_px2[v] = MeanSquaredPx(board_points, views[v], fit.camera);
  }
  if (estimates.size() < 2) {
    result.spread.fill(std::numeric_limits<double>::infinity());
    return;
  }
  const auto count = static_cast<double>(estimates.size());
  for (std::size_t i = 0; i < 9; ++i) {
    double mean = 0, squares = 0;
    for (const auto& estimate : estimates) mean += estimate[i] / count;
    for (const auto& estimate : estimates) squares += std::pow(estimate[i] - mean, 2);
    result.spread[i] = std::sqrt((count - 1) / count * squares);
  }
}

bool IsClearlyBetter(const CandidateResult& other, const CandidateResult& than) {
  if (other.bic > than.bic - kBicMargin) return false;
  const auto count = static_cast<double>(than.left_out_px2.size());
  double mean = 0, squares = 0;
  for (std::size_t v = 0; v < than.left_out_px2.size(); ++v)
    mean += (than.left_out_px2[v] - other.left_out_px2[v]) / count;
  for (std::size_t v = 0; v < than.left_out_px2.size(); ++v)
    squares += std::pow(than.left_out_px2[v] - other.left_out_px2[v] - mean, 2);
  const double standard_error = std::sqrt(squares / (count - 1) / count);
  return mean > kStandardErrors * standard_error;
}

}  // namespace

double CandidateResult::LeftOutRmsPx() const {
  double sum = 0;
  for (const double value : left_out_px2) sum += value;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, left_out_px2.size())));
}

LensChoice ChooseLens(const std::vector<Vector3d>& board_points, const std::vector<BoardView>& views,
                      const CameraModel& start) {
  LensChoice choice;
  const int count = static_cast<int>(views.size());
  choice.folds = count <= kMostSingleFolds ? count : kFolds;
  for (const LensCandidate& candidate : LensCandidates()) {
    // The last fit of the same family is the best start; the given one is tried as well.
    std::optional<LensFit> best;
    std::vector<CameraModel> starts = {start};
    for (auto known = choice.table.rbegin(); known != choice.table.rend(); ++known)
      if (known->fit.candidate.distortion == candidate.distortion) {
        starts.push_back(known->fit.camera);
        break;
      }
    for (const CameraModel& from : starts) {
      LensFit fit = FitLens(board_points, views, candidate, from);
      if (fit.usable && (!best || fit.squared_px < best->squared_px)) best = std::move(fit);
    }
    if (!best) continue;
    CandidateResult result;
    result.fit = std::move(*best);
    result.bic = Bic(result.fit);
    result.folds_inside_image = FoldsInside(result.fit.camera);
    LeaveOut(board_points, views, choice.folds, result);
    choice.table.push_back(std::move(result));
  }
  if (choice.table.empty()) return choice;

  for (CandidateResult& result : choice.table)
    result.explains =
        std::none_of(choice.table.begin(), choice.table.end(), [&](const CandidateResult& other) {
          return !other.folds_inside_image && IsClearlyBetter(other, result);
        });
  const auto rank = [&](const CandidateResult& result) {
    const LensCandidate& candidate = result.fit.candidate;
    return std::make_tuple(!result.explains, result.folds_inside_image, candidate.Parameters(),
                           candidate.distortion == Distortion::kFisheye, result.bic);
  };
  for (std::size_t i = 1; i < choice.table.size(); ++i)
    if (rank(choice.table[i]) < rank(choice.table[choice.chosen])) choice.chosen = i;
  return choice;
}

}  // namespace ulf::acquisition
