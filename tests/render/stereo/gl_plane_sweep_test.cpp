// Tests: render/stereo/gl_plane_sweep.
#include "render/stereo/gl_plane_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/stereo/depth_range.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf::gl_plane_sweep_test {
namespace {

using test::Draw;
using test::Drawn;
using test::Mottled;
using test::Patch;

std::vector<Patch> WallAndBoard(unsigned seed) {
  return {{{-8, -6, 4}, {16, 0, 2}, {0, 12, 0}, Mottled(0.02, seed)},
          {{-0.4, -0.4, 2}, {0.8, 0, 0}, {0, 0.8, 0}, Mottled(0.2, seed + 1)}};
}

// Neighbours on all sides, each with a picture of another size.
std::vector<Drawn> Photographs(unsigned seed, int count) {
  std::vector<Drawn> photographs{Draw(WallAndBoard(seed), {0, 0, 0}, {0, 0, 3})};
  for (int i = 0; i < count; ++i) {
    const double around = 2 * M_PI * i / count;
    photographs.push_back(Draw(WallAndBoard(seed), {0.3 * std::cos(around), 0.3 * std::sin(around), 0.1 * i},
                               {0, 0, 3}, 100 + 8 * i, 90 - 6 * i, 100 + 5 * i));
  }
  return photographs;
}

struct Difference {
  double share_within_one = 0;
  int most = 0;
};

Difference Compare(const CostVolume& a, const CostVolume& b) {
  EXPECT_EQ(a.width(), b.width());
  EXPECT_EQ(a.height(), b.height());
  EXPECT_EQ(a.labels(), b.labels());
  Difference difference;
  double within = 0, all = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x)
      for (int label = 0; label < a.labels(); ++label) {
        const int off = std::abs(int{a.At(x, y)[label]} - int{b.At(x, y)[label]});
        within += off <= 1;
        difference.most = std::max(difference.most, off);
        ++all;
      }
  difference.share_within_one = within / all;
  return difference;
}

// Few neighbours and many, an odd number of planes, every size of window.
TEST(GlPlaneSweep, CostsAreThoseOfTheProcessor) {
  GlPlaneSweep gl(100000);  // bands of some twenty rows
  for (const auto& [neighbours, radius, seed] : {std::tuple{1, 2, 1u}, {2, 1, 2u}, {5, 2, 3u}, {6, 3, 4u}}) {
    const std::vector<Drawn> photographs = Photographs(seed, neighbours);
    std::vector<const StereoView*> others;
    for (std::size_t i = 1; i < photographs.size(); ++i) others.push_back(&photographs[i].view);
    const InverseDepthRange range{1 / 12.0, 1 / 1.2, 37};
    const SweepOptions options{.window_radius_px = radius};
    const CostVolume truth = MatchingCosts(photographs[0].view, others, range, options);
    const CostVolume drawn = gl.MatchingCosts(photographs[0].view, others, range, options);
    int least = 255, most = 0;
    for (int label = 0; label < truth.labels(); ++label) {
      least = std::min<int>(least, truth.At(60, 45)[label]);
      most = std::max<int>(most, truth.At(60, 45)[label]);
    }
    ASSERT_GT(most, least + 20) << "nothing to compare";
    const Difference difference = Compare(truth, drawn);
    // What a rounding moves across a photograph's edge is seen by one and not by the other.
    EXPECT_GT(difference.share_within_one, 0.9995)
        << neighbours << " neighbours, radius " << radius << ", at most " << difference.most;
  }
}

TEST(GlPlaneSweep, FindsTheDepthThatTheProcessorFinds) {
  const std::vector<Drawn> photographs = Photographs(7, 5);
  std::vector<const StereoView*> others;
  for (std::size_t i = 1; i < photographs.size(); ++i) others.push_back(&photographs[i].view);
  const InverseDepthRange range = PixelSpacedRange(photographs[0].view, others, 1.5, 12);
  GlPlaneSweep gl;
  const StereoView& view = photographs[0].view;
  const DepthMap drawn = DepthOfLeastCost(gl.MatchingCosts(view, others, range), view, range);
  const DepthMap swept = SweepPlanes(view, others, range);
  int same = 0, all = 0;
  const double step = (range.most - range.least) / (range.planes - 1);
  for (int y = 0; y < view.grey.rows; ++y)
    for (int x = 0; x < view.grey.cols; ++x) {
      if (!(swept.depth.at<float>(y, x) > 0)) continue;
      ++all;
      same += drawn.depth.at<float>(y, x) > 0 &&
              std::abs(1 / drawn.depth.at<float>(y, x) - 1 / swept.depth.at<float>(y, x)) < 0.1 * step;
    }
  EXPECT_GT(all, 5000);
  EXPECT_GT(same, 0.99 * all);
  EXPECT_NEAR(drawn.depth.at<float>(45, 60), 2, 0.05);
}

}  // namespace
}  // namespace ulf::gl_plane_sweep_test
