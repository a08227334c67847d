#include "tracking/sources/marker_locator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/fiducials/board_detector.h"
#include "core/fiducials/marker_detector.h"
#include "core/geometry/small_matrices.h"
#include "tracking/map/pose_error.h"
#include "tracking/tracker/working_size.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Usual error of a corner; many corners show their own. Guessed.
constexpr double kMarkerCornerSigmaPx = 0.15;
// The usual error counts as so many residuals beside the frame's own. Guessed.
constexpr double kMarkerUsualWeight = 10;
// Neighbouring corners share errors (lens, light, print) that no number of them averages out: a board
// counts as so many independent corners. Guessed.
constexpr double kMarkerIndependentCorners = 8;
constexpr double kMarkerSameRad = 1e-3;  // two poses that differ by less are one
// Centres this close, of the distance: it does not matter which pose is chosen. Guessed.
constexpr double kMarkerCloseShare = 0.01;
// The history decides when one pose is this much nearer to it than the other. Guessed.
constexpr double kMarkerHistoryRatio = 0.5;
constexpr double kMarkerHistoryS = 0.5;  // a pose older than this decides nothing. Guessed
constexpr double kMarkerMaxRmsPx = 2.5;  // above it the corners are no marker, or not this board. Guessed
// A wrong corner among more than so many is dropped beyond this gate; fewer can spare none. Guessed.
constexpr std::size_t kMarkerFewCorners = 8;
constexpr double kMarkerGateSigmas = 10;
// The part of the image that is searched first: this share of the markers' box and of the image's width
// around the box, and at least so many pixels. Every so many frames the whole image is searched for
// markers without a place. Guessed.
constexpr double kMarkerBoxMargin = 1.0 / 3, kMarkerWidthMargin = 1.0 / 24;
constexpr int kMarkerLeastPartPx = 32;
constexpr int kMarkerSearchAllEvery = 10;

double SquaredSigmas(const CameraModel& camera, std::span<const PointObservation> corners, const Rigid3& pose,
                     double sigma_px) {
  double sum = 0;
  for (const PointObservation& corner : corners) {
    const auto img = camera.ImgFromCam(pose * corner.point_in_world);
    sum += img ? (*img - corner.img).squaredNorm() / (sigma_px * sigma_px) : 1e6;
  }
  return sum;
}

// Returns the two poses of a plane that holds the points; for points in space those of a general method.
std::vector<Rigid3> FirstGuesses(const CameraModel& camera, std::span<const PointObservation> corners) {
  constexpr double kLeastForward = 0.05;        // of a ray's z: IPPE takes points of a plane z = 1. Guessed
  constexpr double kFlat = 1e-4, kThin = 1e-3;  // ratios of variances: a plane, a line. Guessed
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> normalized;
  Vector3d mean = Vector3d::Zero();
  for (const PointObservation& corner : corners) mean += corner.point_in_world;
  mean /= static_cast<double>(corners.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const PointObservation& corner : corners) {
    const auto ray = camera.RayFromImg(corner.img);
    if (!ray || ray->z() < kLeastForward) continue;
    const Vector3d p = corner.point_in_world - mean;
    scatter += p * p.transpose();
    points.emplace_back(p.x(), p.y(), p.z());
    normalized.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  if (points.size() < 4) return {};
  // The plane that holds the points, as z = 0 of a frame of its own.
  const Eigenvalues3 axes = EigenvaluesOf(scatter);
  const bool planar = axes.values[0] < kFlat * axes.values[1];
  if (axes.values[1] < kThin * axes.values[2]) return {};  // a line
  Eigen::Matrix3d plane_from_world;
  plane_from_world.row(0) = axes.vectors.col(2);
  plane_from_world.row(1) = axes.vectors.col(1);
  plane_from_world.row(2) = plane_from_world.row(0).cross(plane_from_world.row(1));
  for (cv::Point3d& point : points) {
    const Vector3d turned = plane_from_world * Vector3d(point.x, point.y, point.z);
    point = {turned.x(), turned.y(), planar ? 0 : turned.z()};
  }
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solvePnPGeneric(points, normalized, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations,
                        translations, false, planar ? cv::SOLVEPNP_IPPE : cv::SOLVEPNP_SQPNP);
  } catch (const cv::Exception&) {
    return {};  // a degenerate homography
  }
  std::vector<Rigid3> guesses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const cv::Vec3d turn(rotations[i]), shift(translations[i]);
    const Vector3d axis(turn[0], turn[1], turn[2]);
    const double angle = axis.norm();
    const Eigen::Quaterniond cam_from_plane(angle > 1e-12 ? Eigen::AngleAxisd(angle, axis / angle)
                                                          : Eigen::AngleAxisd::Identity());
    Rigid3 guess;
    guess.rotation = cam_from_plane * Eigen::Quaterniond(plane_from_world);
    guess.translation = Vector3d(shift[0], shift[1], shift[2]) - guess.rotation * mean;
    if (guess.translation.allFinite() && guess.rotation.coeffs().allFinite()) guesses.push_back(guess);
  }
  return guesses;
}

}  // namespace

MarkerLocator::MarkerLocator(const CameraModel& camera, const MarkerSpec& spec, double sure_difference)
    : camera_(camera), spec_(spec), sure_difference_(sure_difference), map_(camera, spec.side_m) {
  camera.Validate("markers");
  if (spec_.kind == MarkerSpec::Kind::kOne) map_.Begin(spec_.id);
}

MarkerLocator MarkerLocator::For(const CameraModel& camera) const {
  MarkerLocator other = *this;
  other.camera_ = camera;
  other.last_seen_.reset();
  other.last_pose_.reset();
  return other;
}

std::string MarkerLocator::WorldInWords() const {
  if (spec_.kind != MarkerSpec::Kind::kSeveral || map_.First() < 0) return {};
  return fmt::format("the world is the frame of marker {} (marker:{:g}:{}:{}), {} learnt", map_.First(),
                     1000 * spec_.side_m, spec_.dictionary, map_.First(), Counted(map_.Size(), "marker"));
}

MarkerLocator::Detections MarkerLocator::Detect(const cv::Mat& gray, bool is_part) const {
  Detections found;
  // Tags of an AprilGrid are found by the board alone, whose squares touch them.
  const bool april = spec_.kind == MarkerSpec::Kind::kBoard && spec_.board.kind == BoardKind::kAprilGrid;
  const bool charuco = spec_.kind == MarkerSpec::Kind::kBoard && spec_.board.kind == BoardKind::kCharuco;
  if (charuco || april) {
    const auto points = spec_.board.Points();
    const BoardView view = DetectBoard(spec_.board, gray);
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      found.board.push_back({0.001 * points[At(view.ids[i])], view.img[i], kMarkerCornerSigmaPx});
      found.all.emplace_back(static_cast<float>(view.img[i].x()), static_cast<float>(view.img[i].y()));
    }
    // If something stands on the board, hardly any of its squares meet in sight: the markers' own corners,
    // which are less exact, have to do.
    constexpr std::size_t kEnough = 4;  // for a pose
    if (is_part || april || view.ids.size() >= kEnough) return found;
  }
  const bool board = spec_.kind == MarkerSpec::Kind::kBoard;
  const auto points = board ? spec_.board.MarkerPoints() : std::vector<Vector3d>();
  std::map<int, int> times;
  for (const auto& [seen_id, img] : DetectMarkers(spec_.dictionary, gray)) {
    const int id = board ? seen_id - spec_.board.first_marker : seen_id;
    if (board && (id < 0 || At(4 * id) + 4 > points.size())) continue;  // of another board
    if (spec_.kind == MarkerSpec::Kind::kOne && id != spec_.id) continue;
    ++times[id];
    found.markers[id] = img;
  }
  // Two markers of one number cannot be told apart.
  std::erase_if(found.markers, [&](const auto& marker) { return times[marker.first] > 1; });
  for (const auto& [id, img] : found.markers)
    for (std::size_t k = 0; k < 4; ++k) {
      found.all.emplace_back(static_cast<float>(img[k].x()), static_cast<float>(img[k].y()));
      if (board) found.board.push_back({0.001 * points[At(4 * id) + k], img[k], kMarkerCornerSigmaPx});
    }
  return found;
}

MarkerLocator::Detections MarkerLocator::DetectNearLast(const cv::Mat& gray) const {
  const cv::Rect part = *last_seen_ & cv::Rect({}, gray.size());
  if (std::min(part.width, part.height) < kMarkerLeastPartPx) return {};
  Detections found = Detect(gray(part), true);
  const Vector2d shift(part.x, part.y);
  for (PointObservation& corner : found.board) corner.img += shift;
  for (auto& [id, img] : found.markers)
    for (Vector2d& corner : img) corner += shift;
  for (cv::Point2f& corner : found.all) corner += cv::Point2f(part.tl());
  return found;
}

std::vector<PointObservation> MarkerLocator::KnownCorners(const Detections& detections) const {
  return spec_.kind == MarkerSpec::Kind::kBoard ? detections.board
                                                : map_.Corners(detections.markers, kMarkerCornerSigmaPx);
}

std::optional<Rigid3> MarkerLocator::Predicted(double time_s) const {
  if (!last_pose_ || std::abs(time_s - last_pose_->time_s) > kMarkerHistoryS) return std::nullopt;
  return last_pose_->cam_from_world;
}

std::optional<MarkerPose> MarkerLocator::Solve(std::vector<PointObservation> corners,
                                               const std::optional<Rigid3>& history, bool* ambiguous) const {
  if (corners.size() < 4) return std::nullopt;
  struct Candidate {
    PoseRefinement refined;
    double error;
  };
  std::vector<Candidate> candidates;
  constexpr double kNoGate = 1e6;
  const RefinePoseOptions refine{
      .gate_sigmas = corners.size() > kMarkerFewCorners ? kMarkerGateSigmas : kNoGate, .max_iterations = 20};
  for (const Rigid3& guess : FirstGuesses(camera_, corners))
    if (auto refined = RefinePose(camera_, corners, guess, refine)) {
      const double error = SquaredSigmas(camera_, corners, refined->cam_from_world, kMarkerCornerSigmaPx);
      candidates.push_back({std::move(*refined), error});
    }
  if (candidates.empty()) return std::nullopt;
  std::ranges::sort(candidates, {}, &Candidate::error);
  // The corners' variance over the usual one.
  const auto freedom = 2 * static_cast<double>(corners.size()) - 6;
  const double worse = (kMarkerUsualWeight + candidates[0].error) / (kMarkerUsualWeight + freedom);
  std::size_t chosen = 0;
  MarkerPose pose;
  double between = 0;
  if (candidates.size() > 1) {
    const auto apart = [](const Rigid3& a, const Rigid3& b) {
      return RotationAngle(a.rotation * b.rotation.conjugate());
    };
    const Rigid3 &first = candidates[0].refined.cam_from_world,
                 &second = candidates[1].refined.cam_from_world;
    const bool sure = candidates[1].error - candidates[0].error > sure_difference_ * worse;
    if (!sure && apart(first, second) > kMarkerSameRad)
      between = 0.5 * (first.OriginInSource() - second.OriginInSource()).norm();
    // If the centres are close, either pose will do: the predicted error covers both.
    if (between > kMarkerCloseShare * first.translation.norm()) {
      const double to_first = history ? apart(first, *history) : 1;
      const double to_second = history ? apart(second, *history) : 1;
      if (std::min(to_first, to_second) > kMarkerHistoryRatio * std::max(to_first, to_second)) {
        if (ambiguous) *ambiguous = true;
        return std::nullopt;
      }
      chosen = to_first <= to_second ? 0 : 1;
      pose.by_history = true;
      between = 0;  // the history decided
    }
  }
  const Candidate& best = candidates[chosen];
  pose.cam_from_world = best.refined.cam_from_world;
  Vector3d mean = Vector3d::Zero();
  double squared = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!best.refined.inlier[i]) continue;
    const auto img = camera_.ImgFromCam(pose.cam_from_world * corners[i].point_in_world);
    if (!img) return std::nullopt;
    squared += (*img - corners[i].img).squaredNorm();
    mean += pose.cam_from_world * corners[i].point_in_world;
    pose.corners.push_back(corners[i]);
  }
  const auto count = static_cast<double>(pose.corners.size());
  pose.rms_px = std::sqrt(squared / count);
  pose.distance = (mean / count).norm();
  if (pose.corners.size() < 4 || 2 * pose.corners.size() < corners.size() || pose.rms_px > kMarkerMaxRmsPx ||
      (pose.cam_from_world * corners.front().point_in_world).z() <= 0)
    return std::nullopt;
  const double alike = std::max(1.0, count / kMarkerIndependentCorners);
  pose.center_sigma = std::max(between, best.refined.center_sigma * std::sqrt(worse * alike));
  for (PointObservation& corner : pose.corners) corner.sigma_px *= std::sqrt(worse * alike);
  return pose;
}

void MarkerLocator::Learn(const Detections& detections, const std::optional<MarkerPose>& pose) {
  if (spec_.kind != MarkerSpec::Kind::kSeveral) return;
  const auto local = MarkerCorners(spec_.side_m);
  std::map<int, Rigid3> alone;  // poses of markers that are not ambiguous
  for (const auto& [id, img] : detections.markers) {
    if (map_.Knows(id)) continue;
    std::vector<PointObservation> corners;
    for (std::size_t k = 0; k < 4; ++k) corners.push_back({local[k], img[k], kMarkerCornerSigmaPx});
    if (const auto own = Solve(std::move(corners), std::nullopt)) alone[id] = own->cam_from_world;
  }
  if (map_.Size() == 0) {
    if (!alone.empty()) map_.Begin(alone.begin()->first);
  } else if (pose && !pose->by_history) {
    map_.Add(pose->cam_from_world, detections.markers, alone);
  }
}

std::optional<MarkerPose> MarkerLocator::Locate(const cv::Mat& gray, double time_s) {
  RequireSize("markers: an image", gray.size(), camera_);
  Detections found;
  if (last_seen_ && (spec_.kind != MarkerSpec::Kind::kSeveral || frames_near_ < kMarkerSearchAllEvery)) {
    found = DetectNearLast(gray);
    ++frames_near_;
  }
  if (found.all.empty()) {
    found = Detect(gray, false);
    frames_near_ = 0;
  }
  last_seen_.reset();
  if (!found.all.empty()) {
    const cv::Rect box = cv::boundingRect(found.all);
    // The margin covers a hand's motion between frames, and parts of the board that were hidden.
    const int margin = static_cast<int>(kMarkerBoxMargin * std::max(box.width, box.height)) +
                       static_cast<int>(kMarkerWidthMargin * gray.cols);
    last_seen_ = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin);
  }
  bool ambiguous = false;
  if (spec_.kind == MarkerSpec::Kind::kSeveral && map_.Size() == 0) Learn(found, std::nullopt);
  const auto pose = Solve(KnownCorners(found), Predicted(time_s), &ambiguous);
  ambiguous_frames_ += ambiguous;
  Learn(found, pose);
  if (!pose) return std::nullopt;
  last_pose_ = {time_s, pose->cam_from_world};
  return pose;
}

std::optional<MarkerPose> MarkerLocator::Locate(const Frame& frame) {
  if (frame.status != FrameStatus::kComplete || frame.image.empty()) return std::nullopt;
  return Locate(GrayForTracking(frame.image), frame.device_time_s);
}

void Describe(const MarkerPose& pose, Track& track) {
  track.state = TrackState::kTracking;
  track.cam_from_world = pose.cam_from_world;
  track.matched_points = static_cast<int>(pose.corners.size());
  track.center_sigma = pose.center_sigma;
  track.rows_sigma = track.lens_error_share = 0;
  track.distance = pose.distance;
  track.quality = QualityOf(pose.center_sigma, pose.distance);
}

std::vector<VisiblePoint> VisibleCorners(const MarkerPose& pose) {
  std::vector<VisiblePoint> visible;
  for (const PointObservation& corner : pose.corners)
    visible.push_back({corner.point_in_world, corner.img, (pose.cam_from_world * corner.point_in_world).z()});
  return visible;
}

Frame WithPose(const Frame& frame, const std::optional<MarkerPose>& pose) {
  Frame posed = frame;
  posed.known_cam_from_world.reset();
  if (pose) posed.known_cam_from_world = pose->cam_from_world;
  return posed;
}

std::optional<MarkerPose> LocateByMarkers(const MarkerLocator& locator, const Frame& photograph,
                                          const CameraModel& camera) {
  MarkerLocator other = locator.For(camera);
  return other.Locate(GrayForTracking(photograph.image), 0);
}

}  // namespace ulf::tracking
