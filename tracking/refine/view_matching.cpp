#include "tracking/refine/view_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/at.h"
#include "core/base/mutex.h"
#include "core/base/parallel_for.h"

namespace ulf::tracking {
namespace {

// Half width of the band about an epipolar line, in errors of the poses, and at least: a wider one holds
// more wrong matches, a narrower one misses right ones. Guessed.
constexpr double kBandErrors = 4, kLeastBandPx = 2;

// Levels of the pyramid on which corners are detected: the views of a set differ more in distance than frames
// that follow each other. Measured: docs/measured/tracking.md, "Published sets".
constexpr int kReadingLevels = kPyramidLevels;
// Neighbouring views whose corners share one adapting threshold, whatever the number of threads: more look
// less alike, fewer give each processor less to do. Guessed.
constexpr int kViewsInARow = 8;

// Views without images, with the lenses of their working resolution.
RefineScene SceneOf(const RefineInput& input, int max_side_px) {
  RefineScene scene;
  for (const CameraModel& lens : input.lenses) {
    const double share = std::min(1.0, static_cast<double>(max_side_px) / std::max(lens.width, lens.height));
    scene.lenses.push_back(lens.ScaledTo(static_cast<int>(std::lround(share * lens.width)),
                                         static_cast<int>(std::lround(share * lens.height))));
  }
  for (const RefineInput::View& given : input.views) {
    RefineView& view = scene.views.emplace_back();
    view.name = given.name;
    view.lens = given.lens;
    view.start = view.cam_from_world = given.cam_from_world;
    view.is_recorded = given.is_recorded;
  }
  return scene;
}

// Returns the corners that `mask` (any size, 0: excluded) shows.
FeatureSet ShownFeatures(const FeatureSet& features, const cv::Mat& mask, const CameraModel& lens) {
  std::vector<Feature> shown;
  for (const Feature& feature : features.all()) {
    const auto pixel = [](double at, int size, int mask_size) {
      return std::clamp(static_cast<int>(at * mask_size / size), 0, mask_size - 1);
    };
    const int x = pixel(feature.img.x(), lens.width, mask.cols),
              y = pixel(feature.img.y(), lens.height, mask.rows);
    if (mask.at<std::uint8_t>(y, x) != 0) shown.push_back(feature);
  }
  return {std::move(shown), lens.width, lens.height};
}

// Returns a number of which `corners` remain where the mask allows, at most four times as many (guessed).
int CornersFor(int corners, const cv::Mat& mask) {
  const double shown = static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
  return static_cast<int>(corners / std::max(0.25, shown));
}

// `mask`: empty where nothing is masked.
void ReadView(Image image, const cv::Mat& mask, int corners, const CameraModel& lens,
              FeatureExtractor& extractor, bool first, RefineView& view) {
  cv::Mat gray = GrayForTracking(image);
  cv::Mat color = image.mosaic == Mosaic::kNone && image.pixels.type() == CV_8UC3 ? image.pixels : gray;
  if (gray.cols != lens.width || gray.rows != lens.height) {
    cv::resize(gray, gray, {lens.width, lens.height}, 0, 0, cv::INTER_AREA);
    cv::resize(color, color, {lens.width, lens.height}, 0, 0, cv::INTER_AREA);
  }
  view.gray = gray.clone();
  const Pyramid pyramid = BuildPyramid(view.gray);
  if (!mask.empty()) corners = CornersFor(corners, mask);
  if (first) extractor.Extract(pyramid, corners);  // the corner threshold settles
  view.features = extractor.Extract(pyramid, corners);
  if (!mask.empty()) view.features = ShownFeatures(view.features, mask, lens);
  for (const Feature& feature : view.features.all()) view.feature_rgb.push_back(RgbAt(color, feature.img));
}

}  // namespace

RefineScene ReadScene(const RefineInput& input, const ReadingOptions& options, const RefineStage& stage) {
  RefineScene scene = SceneOf(input, options.max_side_px);
  const std::size_t count = scene.views.size(), in_a_row = At(kViewsInARow);
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } read;
  ParallelFor((count + in_a_row - 1) / in_a_row, [&](std::size_t row) {
    int lens = -1;
    std::optional<FeatureExtractor> extractor;
    for (std::size_t i = row * in_a_row; i < std::min(count, (row + 1) * in_a_row); ++i) {
      RefineView& view = scene.views[i];
      const bool first = view.lens != lens;
      if (first) extractor.emplace(scene.LensOf(view), FeatureOptions{.levels = kReadingLevels});
      lens = view.lens;
      try {
        const int index = static_cast<int>(i);
        ReadView(input.read(index),
                 options.keeps_masked || !input.read_mask ? cv::Mat() : input.read_mask(index),
                 options.corners, scene.LensOf(view), *extractor, first, view);
      } catch (const std::exception& error) {
        view.registered = false;
        view.why = error.what();
      }
      const MutexLock lock(read.mutex);
      ++read.done;
      stage.Show(static_cast<double>(read.done) / static_cast<double>(count),
                 fmt::format("reading view {}", read.done));
    }
  });
  return scene;
}

std::vector<PairMatches> MatchPairs(const RefineScene& scene, const std::vector<std::pair<int, int>>& pairs,
                                    double error_px, const RefineStage& stage) {
  const double band_px = std::max(kLeastBandPx, kBandErrors * error_px);
  std::vector<PairMatches> matched(pairs.size());
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } shown;
  ParallelFor(pairs.size(), [&](std::size_t p) {
    const auto [first, second] = pairs[p];
    PairMatches& pair = matched[p];
    if (error_px < kGuidingErrorPx) {
      const RefineView &a = scene.view(first), &b = scene.view(second);
      pair = {first, second,
              MatchAlongEpipolarLines(a.features, b.features, b.cam_from_world * a.cam_from_world.Inverse(),
                                      scene.LensOf(a).MeanFocalPx(), band_px),
              0};
      pair.alike = static_cast<int>(pair.matches.size());
    } else {
      pair = MatchAroundPose(scene, first, second, error_px, kMinPairMatches);
    }
    if (static_cast<int>(pair.matches.size()) < kMinPairMatches) pair.matches.clear();
    const MutexLock lock(shown.mutex);
    ++shown.done;
    stage.Show(static_cast<double>(shown.done) / static_cast<double>(pairs.size()),
               fmt::format("comparing views, pair {} of {}", shown.done, pairs.size()));
  });
  return matched;
}

}  // namespace ulf::tracking
