#include "tracking/tracker/photograph_locator.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::tracking {
namespace {

// Search radii about the expected pose, tried in turn, because the hand moves on after the release. Pixels
// here are for images 640 px wide. Guessed.
constexpr double kNearRadiusPx = 15, kFarRadiusPx = 60;
constexpr int kPhotographMaxDistance = 70;   // bits of a match's descriptors. Guessed
constexpr double kPhotographGateSigmas = 3;  // of the first refinement. Guessed
// A pose that was refined in the full photograph is kept where at least this share of the points agrees: a
// photograph that is sharp only when it is small keeps the pose of the small one. Guessed.
constexpr double kMinSharpShare = 0.5;
// If the points lie farther (median) from where the expected pose projects them, that pose does not say
// which of several like things the photograph shows. Guessed.
constexpr double kUnmovedPx = 4;

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

std::shared_ptr<const FiducialObservation> ResizedTo(const FiducialObservation& fiducials,
                                                     const cv::Mat& from, const CameraModel& camera) {
  return std::make_shared<const FiducialObservation>(Scaled(
      fiducials,
      {static_cast<double>(camera.width) / from.cols, static_cast<double>(camera.height) / from.rows}));
}

}  // namespace

PhotographLocator::PhotographLocator(const CameraModel& live, const CameraModel& photograph,
                                     const SharedMap& shared, const KeyframeIndex& index, int features,
                                     unsigned seed)
    : features_(features),
      seed_(seed),
      photograph_px_(photograph.width, photograph.height),
      // A patch is aligned on the pyramid level where its pixels are as large as the image's: more pixels
      // than the pyramid spans would not be used.
      full_(Reduced(photograph, LevelScale(kPyramidLevels - 1) * live.MeanFocalPx())),
      small_(Reduced(photograph, live.MeanFocalPx())),
      shared_(shared),
      index_(index),
      locator_(small_, shared, features) {}

std::optional<FramePose> PhotographLocator::Locate(
    const cv::Mat& gray, const std::optional<Rigid3>& near,
    const std::optional<FiducialObservation>& fiducials) const {
  const cv::Mat full = ResizedTo(gray, full_);
  TrackedImage image;
  if (fiducials) image.fiducials = ResizedTo(*fiducials, gray, small_);
  image.pyramid = std::make_shared<const Pyramid>(BuildPyramid(ResizedTo(full, small_)));
  FeatureExtractor extractor(small_);
  extractor.Extract(*image.pyramid, features_);  // the corner threshold settles
  image.features = std::make_shared<const FeatureSet>(extractor.Extract(*image.pyramid, features_));
  std::optional<FramePose> frame_pose;
  if (near) frame_pose = LocateNear(image, *near);
  if (!frame_pose) frame_pose = locator_.Find(image, index_, seed_);
  if (!frame_pose) return std::nullopt;
  TrackedImage at_full;
  at_full.pyramid = std::make_shared<const Pyramid>(BuildPyramid(full));
  if (fiducials) at_full.fiducials = ResizedTo(*fiducials, gray, full_);
  FramePose at_photograph = RefineAtFull(std::move(at_full), std::move(*frame_pose));
  ScaleMatches(at_photograph.matches,
               photograph_px_.cwiseQuotient(Eigen::Vector2d(full_.width, full_.height)));
  return at_photograph;
}

std::optional<FramePose> PhotographLocator::LocateNear(const TrackedImage& image, const Rigid3& near) const {
  const double unit = PxAt640(small_.width);
  FramePose frame_pose;
  {
    const MapLock lock(shared_);
    frame_pose.candidates = GatherCandidates(shared_.map, small_, near, shared_.map.main_part());
  }
  for (const double radius_px : {kNearRadiusPx * unit, kFarRadiusPx * unit}) {
    const MapMatches coarse = MatchMap(small_, image, frame_pose.candidates, {}, near,
                                       {.radius_px = radius_px, .max_distance = kPhotographMaxDistance});
    const auto refined = RefinePose(small_, ToObservations(frame_pose.candidates, coarse.matches), near,
                                    {.gate_sigmas = kPhotographGateSigmas});
    if (!refined) continue;
    frame_pose.cam_from_world = refined->cam_from_world;
    std::optional<FramePose> found = locator_.RefineTwice(image, frame_pose);
    if (!found) continue;
    // The camera may have moved since `near`: then only unambiguous points tell similar things apart.
    ExcludedCandidates left_out;
    if (MedianShiftPx(small_, *found, near) > kUnmovedPx * unit)
      ExcludeAmbiguousMatches(small_, *image.features, *found, left_out);
    if (PoseLogOdds(small_, *found, left_out) > kRelocalizedLogOdds) return found;
  }
  return std::nullopt;
}

FramePose PhotographLocator::RefineAtFull(TrackedImage image, FramePose frame_pose) const {
  const Eigen::Vector2d full_by_small(static_cast<double>(full_.width) / small_.width,
                                      static_cast<double>(full_.height) / small_.height);
  ScaleMatches(frame_pose.matches, full_by_small);
  std::vector<PointMatch> matches = frame_pose.matches;
  AlignMatches(full_, image, frame_pose.candidates, frame_pose.cam_from_world, matches);
  std::vector<PointObservation> observations = ToObservations(frame_pose.candidates, matches);
  for (const PointObservation& corner : CornersOf(shared_, image, frame_pose.cam_from_world))
    observations.push_back(corner);
  const auto refined = RefinePose(full_, observations, frame_pose.cam_from_world);
  if (!refined) return frame_pose;
  std::vector<PointMatch> inliers = InliersOf(matches, *refined);
  if (static_cast<double>(inliers.size()) < kMinSharpShare * static_cast<double>(matches.size()))
    return frame_pose;
  frame_pose.cam_from_world = refined->cam_from_world;
  frame_pose.center_sigma = refined->center_sigma;
  frame_pose.matches = std::move(inliers);
  return frame_pose;
}

}  // namespace ulf::tracking
