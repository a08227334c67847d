// Views of the usual board in front of a lens that is known, without pictures.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "acquisition/calibration/calibrate.h"
#include "core/geometry/small_matrices.h"

namespace ulf::test {

struct SyntheticBoardViews {
  CameraModel camera = {};
  int views = 20;
  double noise_px = 0.1;
  unsigned seed = 1;
  bool moves = true;
  double largest_tilt = 0.7;
  double outlier_share = 0;
};

// Corners straight from the model with noise: no pictures, so that many cases are cheap.
inline std::vector<BoardView> MakeViews(const SyntheticBoardViews& s) {
  std::mt19937 random(s.seed);
  std::normal_distribution<double> normal(0, s.noise_px);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto points = Board().Points();
  const Eigen::Vector3d middle(0.5 * Board().WidthMm(), 0.5 * Board().HeightMm(), 0);
  std::vector<BoardView> views;
  for (int v = 0; v < s.views; ++v) {
    const int place = s.moves ? v : 0;
    const Eigen::Vector2d target((0.2 + 0.6 * ((place * 3) % 5) / 4.0) * s.camera.width,
                                 (0.2 + 0.6 * ((place * 5) % 4) / 3.0) * s.camera.height);
    const Eigen::Vector3d ray = *s.camera.RayFromImg(target);
    const double about = place * M_PI / 2 + 0.3 * (s.moves ? unit(random) : 0);
    const double tilt = s.largest_tilt * (s.moves ? 0.3 + 0.7 * unit(random) : 0.5);
    const double turn = s.moves ? 0.5 * (unit(random) - 0.5) : 0;
    const Eigen::Quaterniond facing =
        s.largest_tilt > 0 ? TurnBetween(Eigen::Vector3d::UnitZ(), ray) : Eigen::Quaterniond::Identity();
    const Eigen::Quaterniond rotation =
        facing * Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(about), std::sin(about), 0)) *
        Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ());
    const double distance =
        (s.moves ? 1 + unit(random) : 1.5) * s.camera.fx * Board().WidthMm() / (0.8 * s.camera.width);
    const Rigid3 pose{rotation, distance * ray - rotation * middle};
    BoardView view{"view " + std::to_string(v), {}, {}};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto img = s.camera.ImgFromCam(pose * points[i]);
      if (!img || !s.camera.Contains(*img)) continue;
      const bool outlier = unit(random) < s.outlier_share;
      view.ids.push_back(static_cast<int>(i));
      view.img.push_back(*img + Eigen::Vector2d(normal(random), normal(random)) +
                         (outlier ? Eigen::Vector2d(6, -4) : Eigen::Vector2d(0, 0)));
    }
    if (view.ids.size() >= kLeastCorners) views.push_back(view);
  }
  return views;
}

}  // namespace ulf::test
