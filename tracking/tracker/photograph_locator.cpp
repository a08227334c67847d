#include "tracking/tracker/photograph_locator.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::tracking {
namespace {

CameraModel Reduced(const CameraModel& camera, double focal_px) {
  const double share = std::min(1.0, focal_px / camera.MeanFocalPx());
  return camera.ScaledTo(static_cast<int>(std::lround(share * camera.width)),
                         static_cast<int>(std::lround(share * camera.height)));
}

cv::Mat ResizedTo(const cv::Mat& gray, const CameraModel& camera) {
  if (gray.cols == camera.width && gray.rows == camera.height) return gray;
  cv::Mat resized;
  cv::resize(gray, resized, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  return resized;
}

void ScaleMatches(std::vector<PointMatch>& matches, const Eigen::Vector2d& scale) {
  for (PointMatch& match : matches) {
    match.img = match.img.cwiseProduct(scale);
    match.sigma_px *= scale.mean();
  }
}

std::shared_ptr<const FiducialObservation> ResizedTo(FiducialObservation fiducials, const cv::Mat& from,
                                                     const CameraModel& camera) {
  const Eigen::Vector2d scale(static_cast<double>(camera.width) / from.cols,
                              static_cast<double>(camera.height) / from.rows);
  for (PointObservation& corner : fiducials.corners) {
    corner.img = corner.img.cwiseProduct(scale);
    corner.sigma_px *= scale.mean();
  }
  return std::make_shared<const FiducialObservation>(std::move(fiducials));
}

}  // namespace

PhotographLocator::PhotographLocator(const CameraModel& live, const CameraModel& photograph,
                                     const SharedMap& shared, const KeyframeIndex& index,
                                     const Options& options)
    : options_(options),
      photograph_px_(photograph.width, photograph.height),
      // A patch of the map is found on the pyramid level where its pixels are the image's: more than the
      // pyramid spans would not be used.
      full_(Reduced(photograph, LevelScale(kPyramidLevels - 1) * live.MeanFocalPx())),
      small_(Reduced(photograph, live.MeanFocalPx())),
      shared_(shared),
      index_(index),
      locator_(small_, shared, options.features / 5) {}

std::optional<FramePose> PhotographLocator::Locate(
    const cv::Mat& gray, const std::optional<Rigid3>& near,
    const std::optional<FiducialObservation>& fiducials) const {
  const cv::Mat full = ResizedTo(gray, full_);
  TrackedImage image;
  if (fiducials) image.fiducials = ResizedTo(*fiducials, gray, small_);
  image.pyramid = std::make_shared<const Pyramid>(BuildPyramid(ResizedTo(full, small_)));
  FeatureExtractor extractor(small_);
  extractor.Extract(*image.pyramid, options_.features);  // the corner threshold settles
  image.features = std::make_shared<const FeatureSet>(extractor.Extract(*image.pyramid, options_.features));
  std::optional<FramePose> located;
  if (near) located = LocateNear(image, *near);
  if (!located) located = locator_.Find(image, index_, options_.seed);
  if (!located) return std::nullopt;
  TrackedImage at_full;
  at_full.pyramid = std::make_shared<const Pyramid>(BuildPyramid(full));
  if (fiducials) at_full.fiducials = ResizedTo(*fiducials, gray, full_);
  FramePose at_photograph = RefineAtFull(std::move(at_full), std::move(*located));
  ScaleMatches(at_photograph.matches,
               photograph_px_.cwiseQuotient(Eigen::Vector2d(full_.width, full_.height)));
  return at_photograph;
}

std::optional<FramePose> PhotographLocator::LocateNear(const TrackedImage& image, const Rigid3& near) const {
  const double unit = small_.width / 640.0;
  StageTimes ignored;
  FramePose located;
  {
    const MapLock lock(shared_);
    located.candidates = GatherCandidates(shared_.map, small_, near);
  }
  for (const double radius_px : {15 * unit, 60 * unit}) {
    const MapMatches coarse = MatchMap(small_, image, located.candidates, {}, near,
                                       {.radius_px = radius_px, .max_distance = 70, .align = false});
    const auto refined =
        RefinePose(small_, ToObservations(located.candidates, coarse.matches), near, {.gate_sigmas = 3});
    if (!refined) continue;
    located.cam_from_world = refined->cam_from_world;
    std::optional<FramePose> wide = locator_.Refine(image, located, 10 * unit, ignored);
    if (!wide) continue;
    std::optional<FramePose> found = locator_.Refine(image, std::move(*wide), 4 * unit, ignored);
    if (!found) continue;
    // `near` is of another moment: unless nothing has moved, it does not say which of several like things
    // this is.
    LeftOut left_out;
    if (MedianShiftPx(small_, *found, near) > 4 * unit)
      ExcludeAmbiguousMatches(small_, *image.features, *found, left_out);
    if (PoseLogOdds(small_, *found, left_out) > kRelocalizedLogOdds) return found;
  }
  return std::nullopt;
}

FramePose PhotographLocator::RefineAtFull(TrackedImage image, FramePose located) const {
  const Eigen::Vector2d full_by_small(static_cast<double>(full_.width) / small_.width,
                                      static_cast<double>(full_.height) / small_.height);
  ScaleMatches(located.matches, full_by_small);
  std::vector<PointMatch> matches = located.matches;
  AlignMatches(full_, image, located.candidates, located.cam_from_world, matches);
  std::vector<PointObservation> observations = ToObservations(located.candidates, matches);
  for (const PointObservation& corner : CornersOf(shared_, image, located.cam_from_world))
    observations.push_back(corner);
  const auto refined = RefinePose(full_, observations, located.cam_from_world);
  // A photograph that is sharp when it is small only keeps what the small one said.
  const auto fits = [&] {
    return 2 * std::count(refined->inlier.begin(),
                          refined->inlier.begin() + static_cast<std::ptrdiff_t>(matches.size()), true) >=
           static_cast<std::ptrdiff_t>(matches.size());
  };
  if (!refined || !fits()) return located;
  located.cam_from_world = refined->cam_from_world;
  located.center_sigma = refined->center_sigma;
  located.matches.clear();
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (refined->inlier[i]) located.matches.push_back(matches[i]);
  return located;
}

}  // namespace ulf::tracking
