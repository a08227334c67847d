#include "acquisition/calibration/color_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"
#include "core/image/color_difference.h"

namespace ulf::acquisition {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using ProfileParameters =
    Eigen::Matrix<double, 7, 1>;  // the matrix beside its diagonal, by rows; log of the exposure

struct Patch {
  int index = 0;
  Vector3d camera, lab, srgb;  // srgb: linear
};

struct Solution {
  Vector3d balance = Vector3d::Ones();
  Matrix3d matrix = Matrix3d::Identity();
  double exposure = 1;
  Vector3d Srgb(const Vector3d& camera) const { return exposure * (matrix * balance.cwiseProduct(camera)); }
};

Matrix3d MatrixOf(const ProfileParameters& p) {
  Matrix3d matrix;
  matrix << 1 - p[0] - p[1], p[0], p[1], p[2], 1 - p[2] - p[3], p[3], p[4], p[5], 1 - p[4] - p[5];
  return matrix;
}

// Differences from the published colour in L* a* b*, weighted as CIEDE2000 does for small ones.
Vector3d Difference(const Patch& patch, const Vector3d& srgb) {
  const Vector3d off = LabFromLinearSrgb(srgb) - patch.lab;
  const double of_color = 1 / (1 + 0.045 * patch.lab.tail<2>().norm());
  return {off[0], of_color * off[1], of_color * off[2]};
}

bool IsGrey(const Patch& patch) { return patch.index >= kFirstGrey; }

// None of the greys may be missing altogether.
Solution Balanced(const std::vector<Patch>& patches) {
  std::array<std::vector<double>, 3> factors;
  for (const Patch& patch : patches) {
    if (!IsGrey(patch)) continue;
    for (int c = 0; c < 3; ++c)
      factors[static_cast<std::size_t>(c)].push_back(std::log(patch.srgb[c] / patch.camera[c]));
  }
  Solution solution;
  Vector3d logs;
  for (int c = 0; c < 3; ++c) logs[c] = Median(std::move(factors[static_cast<std::size_t>(c)]));
  solution.exposure = std::exp(logs[1]);
  solution.balance = (logs.array() - logs[1]).exp();
  return solution;
}

// Minimises by Levenberg-Marquardt with numeric derivatives and Huber weights.
Solution SolveProfile(const std::vector<Patch>& patches) {
  Solution solution = Balanced(patches);
  constexpr double kHuber = 3;  // units of CIEDE2000. Guessed.
  const double start = std::log(solution.exposure);
  const auto solution_of = [&](const ProfileParameters& p) {
    Solution out = solution;
    out.matrix = MatrixOf(p);
    out.exposure = std::exp(start + p[6]);
    return out;
  };
  const auto residuals = [&](const ProfileParameters& p) {
    const Solution at = solution_of(p);
    Eigen::VectorXd out(3 * static_cast<Eigen::Index>(patches.size()));
    for (std::size_t i = 0; i < patches.size(); ++i)
      out.segment<3>(3 * static_cast<Eigen::Index>(i)) = Difference(patches[i], at.Srgb(patches[i].camera));
    return out;
  };
  const auto cost_and_weights = [&](const Eigen::VectorXd& r, Eigen::VectorXd& weights) {
    double cost = 0;
    weights.resize(r.size());
    for (Eigen::Index i = 0; i < r.size(); i += 3) {
      const double size = r.segment<3>(i).norm();
      cost += size <= kHuber ? 0.5 * size * size : kHuber * (size - 0.5 * kHuber);
      weights.segment<3>(i).setConstant(size <= kHuber ? 1 : kHuber / size);
    }
    return cost;
  };
  ProfileParameters p = ProfileParameters::Zero();
  Eigen::VectorXd r = residuals(p), weights;
  double cost = cost_and_weights(r, weights), damping = 1e-3;
  for (int step = 0; step < 100; ++step) {
    Eigen::MatrixXd jacobian(r.size(), p.size());
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      constexpr double kStep = 1e-5;
      ProfileParameters up = p, down = p;
      up[k] += kStep;
      down[k] -= kStep;
      jacobian.col(k) = (residuals(up) - residuals(down)) / (2 * kStep);
    }
    const Eigen::Matrix<double, 7, 7> normal = jacobian.transpose() * weights.asDiagonal() * jacobian;
    const ProfileParameters gradient = jacobian.transpose() * weights.cwiseProduct(r);
    bool better = false;
    while (!better && damping < 1e9) {
      Eigen::Matrix<double, 7, 7> damped = normal;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      const ProfileParameters next = p - damped.ldlt().solve(gradient);
      Eigen::VectorXd next_weights;
      const Eigen::VectorXd next_r = residuals(next);
      const double next_cost = cost_and_weights(next_r, next_weights);
      better = next_cost < cost;
      damping *= better ? 0.2 : 5;
      if (!better) continue;
      const bool settled = cost - next_cost < 1e-12 * cost;
      p = next, r = next_r, weights = next_weights, cost = next_cost;
      if (settled) return solution_of(p);
    }
    if (!better) break;
  }
  return solution_of(p);
}

double DifferenceOf(const Patch& patch, const Vector3d& srgb) {
  return ColorDifference2000(LabFromLinearSrgb(srgb), patch.lab);
}

MeasuredChart MedianOf(const std::vector<MeasuredChart>& charts) {
  MeasuredChart median = charts.front();
  for (std::size_t i = 0; i < median.patches.size(); ++i) {
    std::array<std::vector<double>, 4> values;
    for (const MeasuredChart& chart : charts) {
      for (int c = 0; c < 3; ++c) values[static_cast<std::size_t>(c)].push_back(chart.patches[i].rgb[c]);
      values[3].push_back(chart.patches[i].unevenness);
      median.patches[i].clipped |= chart.patches[i].clipped;
    }
    for (int c = 0; c < 3; ++c)
      median.patches[i].rgb[c] = Median(std::move(values[static_cast<std::size_t>(c)]));
    median.patches[i].unevenness = Median(std::move(values[3]));
  }
  return median;
}

}  // namespace

double ColorFit::Mean(double PatchDifference::*which) const {
  double sum = 0;
  for (const PatchDifference& patch : patches) sum += patch.*which;
  return patches.empty() ? 0 : sum / static_cast<double>(patches.size());
}

double ColorFit::Most(double PatchDifference::*which) const {
  double most = 0;
  for (const PatchDifference& patch : patches) most = std::max(most, patch.*which);
  return most;
}

ColorFit FitColorProfile(const std::vector<MeasuredChart>& charts) {
  ColorFit fit;
  if (charts.empty()) {
    fit.refusal =
        "no chart of 24 patches was found; fill at least a third of the picture with it, flat, evenly lit, "
        "without reflections, and expose so that its white is bright but not clipped";
    return fit;
  }
  const MeasuredChart chart = MedianOf(charts);
  std::vector<Patch> patches;
  for (int i = 0; i < kChartPatches; ++i) {
    const ChartPatch& measured = chart.patches[static_cast<std::size_t>(i)];
    if (measured.clipped)
      fit.clipped.push_back(i);
    else if (!measured.usable())
      fit.uneven.push_back(i);
    else
      patches.push_back({i, measured.rgb, ChartLab()[static_cast<std::size_t>(i)],
                         LinearSrgbFromLab(ChartLab()[static_cast<std::size_t>(i)])});
  }
  constexpr std::size_t kLeastPatches = 15;
  constexpr std::ptrdiff_t kLeastGreys = 3;  // Guessed, both.
  if (patches.size() < kLeastPatches || std::ranges::count_if(patches, IsGrey) < kLeastGreys) {
    fit.refusal =
        fmt::format("only {} of the 24 patches can be used ({} are clipped, {} uneven or dark); {}",
                    patches.size(), fit.clipped.size(), fit.uneven.size(),
                    fit.clipped.size() >= fit.uneven.size() ? "expose less"
                                                            : "light the chart evenly, without reflections");
    return fit;
  }
  const Solution solution = SolveProfile(patches);
  std::array<Solution, kChartColumns> without;
  for (int column = 0; column < kChartColumns; ++column) {
    std::vector<Patch> others;
    std::ranges::copy_if(patches, std::back_inserter(others),
                         [&](const Patch& patch) { return patch.index % kChartColumns != column; });
    without[static_cast<std::size_t>(column)] = SolveProfile(others);
  }
  for (const Patch& patch : patches)
    fit.patches.push_back(
        {.patch = patch.index,
         .as_recorded = DifferenceOf(patch, solution.exposure * patch.camera),
         .balanced = DifferenceOf(patch, solution.exposure * solution.balance.cwiseProduct(patch.camera)),
         .profiled = DifferenceOf(patch, solution.Srgb(patch.camera)),
         .held_out = DifferenceOf(
             patch, without[static_cast<std::size_t>(patch.index % kChartColumns)].Srgb(patch.camera))});
  for (int c = 0; c < 3; ++c) fit.profile.white_balance[static_cast<std::size_t>(c)] = solution.balance[c];
  for (int i = 0; i < 9; ++i) fit.profile.matrix[static_cast<std::size_t>(i)] = solution.matrix(i / 3, i % 3);
  fit.profile.delta_e = fit.Mean(&PatchDifference::held_out);
  return fit;
}

GreyCard BalanceOfGreyCard(const Image& image, double black_level, const cv::Mat& clipped) {
  // Guessed, all: a card is no darker, no more uneven in colour, and not clipped.
  constexpr double kLeastLight = 0.03, kMostClipped = 0.002, kMostUneven = 0.05;
  GreyCard card;
  const cv::Mat light = LinearFloat(image);
  const cv::Rect middle(light.cols / 3, light.rows / 3, light.cols / 3, light.rows / 3);
  if (!clipped.empty() &&
      static_cast<double>(cv::countNonZero(clipped(middle))) > kMostClipped * middle.area()) {
    card.refusal =
        "the card in the middle of the picture is clipped; expose less, so that it is at half of full scale";
    return card;
  }
  // Means over cells: the colour of single pixels is noise.
  constexpr int kCells = 12;
  std::vector<double> red, green, blue;
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column) {
      const cv::Rect cell(middle.x + column * middle.width / kCells, middle.y + row * middle.height / kCells,
                          std::max(1, middle.width / kCells), std::max(1, middle.height / kCells));
      const cv::Scalar mean = cv::mean(light(cell));
      if (!(std::min({mean[0], mean[1], mean[2]}) > black_level)) continue;
      green.push_back(mean[1] - black_level);
      red.push_back((mean[2] - black_level) / green.back());
      blue.push_back((mean[0] - black_level) / green.back());
    }
  card.light = green.empty() ? 0 : Median(green);
  if (card.light < kLeastLight) {
    card.refusal = fmt::format(
        "the middle of the picture is dark ({:.1f} % of full scale); expose more, so that the card is at "
        "half of full scale",
        100 * card.light);
    return card;
  }
  const double red_over_green = Median(red), blue_over_green = Median(blue);
  std::vector<double> off;
  for (std::size_t i = 0; i < red.size(); ++i)
    off.push_back(std::max(std::abs(red[i] / red_over_green - 1), std::abs(blue[i] / blue_over_green - 1)));
  constexpr double kNearlyAll = 0.9;
  card.unevenness = Quantile(std::move(off), kNearlyAll);
  if (card.unevenness > kMostUneven) {
    card.refusal = fmt::format(
        "the colour of the picture's middle third is uneven (by {:.0f} %): is it filled by a grey card, in "
        "one light?",
        100 * card.unevenness);
    return card;
  }
  card.white_balance = {1 / red_over_green, 1, 1 / blue_over_green};
  return card;
}

}  // namespace ulf::acquisition
