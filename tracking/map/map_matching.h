// Finds which map points a frame sees, and where: for tracking, relocalisation and seeding.
//
// Candidates are copied out of the map once a frame, so that matching needs no lock. A match starts from a
// feature with a similar descriptor near the projection; then the point's patch, if any, is aligned.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/features/features.h"
#include "tracking/features/matching.h"
#include "tracking/map/map.h"
#include "tracking/map/tracked_image.h"

namespace ulf::tracking {

// A map point that could be in view: a copy of the MapPoint's members.
struct Candidate {
  int id = -1;
  Eigen::Vector3d position;
  Eigen::Vector3d mean_direction;
  Descriptor descriptor{};
  double reference_distance = 0;
  double nearest = 0, farthest = 0;
  double find_rate = 0.5;  // MapPoint::found over expected, drawn to one half while those are few
  std::shared_ptr<const ReferencePatch> patch;
  PatchAxes patch_axes;
  int times_expected = 0;  // MapPoint::expected
  // At least three keyframes see it: two alone cannot expose a point that moved along their epipolar lines.
  bool confirmed = true;
};

// Returns the living points of a part of the map that a camera near this pose may see. The caller holds the
// map's lock, as for the next function.
std::vector<Candidate> GatherCandidates(const Map& map, const CameraModel& camera,
                                        const Rigid3& cam_from_world, int part = 0);

// Does the same at a cost that does not grow with the map: searches the points of the keyframes that share
// most with the frame before (`seen_before` has its points by id), and of all others kSweptPoints a frame, in
// turn. So what was seen long ago and comes into view again is found within a sweep. A smaller map is
// searched whole. `sweep`, 0 at first, keeps where the next call goes on. Measured: BM_GatherCandidatesNear.
inline constexpr int kSweptPoints = 8192;
std::vector<Candidate> GatherCandidatesNear(const Map& map, const CameraModel& camera,
                                            const Rigid3& cam_from_world,
                                            const std::unordered_map<int, Eigen::Vector2d>& seen_before,
                                            int& sweep, int part = 0);

struct PointMatch {
  int candidate = -1;  // index into the candidates
  int feature = -1;    // index; -1: no corner was detected there, the patch alone was found
  Eigen::Vector2d img;
  double sigma_px = 1;
  bool aligned = false;  // `img` is where the patch was aligned
};

struct MapMatchOptions {
  double radius_px = 4;              // for corners of level 0; grows with the level's scale
  int max_distance = kSureDistance;  // of descriptors, bits
};

struct MapMatches {
  std::vector<PointMatch> matches;
  std::vector<int> expected;  // indices of candidates that this pose should see, found or not
};

// Matches candidates (indices in `only`; empty: all) with the image's corners near their projections.
MapMatches MatchMap(const CameraModel& camera, const TrackedImage& image,
                    std::span<const Candidate> candidates, std::span<const int> only,
                    const Rigid3& cam_from_world, const MapMatchOptions& options);

// Aligns the patches of matches with the image, from the features on. Matches whose patch fails stay.
void AlignMatches(const CameraModel& camera, const TrackedImage& image, std::span<const Candidate> candidates,
                  const Rigid3& cam_from_world, std::vector<PointMatch>& matches);

// Searches up to `most` of the expected points that no detected corner matched, by their patches alone, under
// a pose that is good to a pixel or two: corner detection repeats for about half of the points only. Prefers
// points with a high find rate, and parts of the image with few matches. Appends to `matches`. Returns the
// indices of the expected points that were searched in every way: a dense map has more points in view than a
// frame has corners and patches to try, and those that were not searched say nothing about the pose.
std::vector<int> AlignUndetected(const CameraModel& camera, const TrackedImage& image,
                                 std::span<const Candidate> candidates, std::span<const int> expected,
                                 const Rigid3& cam_from_world, int most, std::vector<PointMatch>& matches);

// Returns the matched points and where the image shows them, for RefinePose().
std::vector<PointObservation> ToObservations(std::span<const Candidate> candidates,
                                             std::span<const PointMatch> matches);

// Returns the fiducial corners without the rolling shutter's shift; none unless SharedMap::world_given.
std::vector<PointObservation> CornersOf(const SharedMap& shared, const TrackedImage& image,
                                        const Rigid3& cam_from_world);

// A frame's pose and the matches with the map that support it.
struct FramePose {
  Rigid3 cam_from_world;  // of the middle row
  // From the middle row's camera to the one that explains the image best (Track::cam_from_world).
  Rigid3 picture_from_cam;
  Twist twist = Twist::Zero();  // the camera's velocity while the rows were read
  std::vector<Candidate> candidates;
  std::vector<PointMatch> matches;  // that support the pose
  std::vector<int> in_view;         // indices of candidates that the pose should see
  std::vector<int> looked_for;      // those of `in_view` that matching had a chance to find
  double expected = 0;              // how many of `looked_for` should be found, by their find rates
  double center_sigma = 0;          // one standard deviation of the camera's centre, world units

  const Candidate& CandidateOf(const PointMatch& match) const {
    return candidates[static_cast<std::size_t>(match.candidate)];
  }
};

// Returns the matches that a refinement kept. They were its first observations; others may have followed.
std::vector<PointMatch> InliersOf(const std::vector<PointMatch>& matches, const PoseRefinement& refined);

// Returns the matches' median distance from their points' projections, px; infinite without matches.
double MedianShiftPx(const CameraModel& camera, const FramePose& frame_pose, const Rigid3& cam_from_world);

}  // namespace ulf::tracking
