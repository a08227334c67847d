#include "tracking/refine/view_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/at.h"
#include "core/base/mutex.h"

namespace ulf::tracking {

namespace {

// Views with the lenses of their working resolution; nothing is read yet.
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
  }
  return scene;
}

void ReadView(Image image, int corners, const CameraModel& lens, FeatureExtractor& extractor, bool first,
              RefineView& view) {
  cv::Mat gray = GrayForTracking(image);
  cv::Mat color = image.mosaic == Mosaic::kNone && image.pixels.depth() == CV_8U ? image.pixels : gray;
  if (gray.cols != lens.width || gray.rows != lens.height) {
    cv::resize(gray, gray, {lens.width, lens.height}, 0, 0, cv::INTER_AREA);
    cv::resize(color, color, {lens.width, lens.height}, 0, 0, cv::INTER_AREA);
  }
  view.gray = gray.clone();
  const Pyramid pyramid = BuildPyramid(view.gray);
  if (first) extractor.Extract(pyramid, corners);  // the corner threshold settles
  view.features = extractor.Extract(pyramid, corners);
  for (const Feature& feature : view.features.all()) {
    const int x = static_cast<int>(feature.img.x()), y = static_cast<int>(feature.img.y());
    if (color.channels() == 3) {
      const cv::Vec3b bgr = color.at<cv::Vec3b>(y, x);
      view.feature_rgb.push_back({bgr[2], bgr[1], bgr[0]});
    } else {
      const std::uint8_t value = gray.at<std::uint8_t>(y, x);
      view.feature_rgb.push_back({value, value, value});
    }
  }
}

}  // namespace

RefineScene ReadScene(const RefineInput& input, int max_side_px, int corners, const RefineStage& stage) {
  RefineScene scene = SceneOf(input, max_side_px);
  // One extractor serves neighbouring views, whose images are alike, whatever the number of threads.
  constexpr int kChunk = 8;
  const int count = static_cast<int>(scene.views.size());
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } read;
  ForAll((count + kChunk - 1) / kChunk, [&](int chunk) {
    int lens = -1;
    std::optional<FeatureExtractor> extractor;
    for (int i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      RefineView& view = scene.views[At(i)];
      const bool first = view.lens != lens;
      if (first) extractor.emplace(scene.LensOf(view));
      lens = view.lens;
      try {
        ReadView(input.read(i), corners, scene.LensOf(view), *extractor, first, view);
      } catch (const std::exception& error) {
        view.registered = false;
        view.why = error.what();
      }
      const MutexLock lock(read.mutex);
      ++read.done;
      stage.Show(static_cast<double>(read.done) / count, fmt::format("reading view {}", read.done));
    }
  });
  return scene;
}

std::vector<PairMatches> MatchPairs(const RefineScene& scene, const std::vector<std::pair<int, int>>& pairs,
                                    double error_px, const RefineStage& stage) {
  constexpr double kLeastBandPx = 2, kBandErrors = 4;  // about an epipolar line. Guessed
  const double band_px = std::max(kLeastBandPx, kBandErrors * error_px);
  std::vector<PairMatches> matched(pairs.size());
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } shown;
  ForAll(static_cast<int>(pairs.size()), [&](int p) {
    const auto [first, second] = pairs[At(p)];
    PairMatches& pair = matched[At(p)];
    if (error_px < kGuidingErrorPx) {
      const RefineView &a = scene.view(first), &b = scene.view(second);
      pair = {first, second,
              MatchAlongEpipolarLines(a.features, b.features, b.cam_from_world * a.cam_from_world.Inverse(),
                                      scene.LensOf(a).MeanFocalPx(), band_px, kPairMatching),
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
