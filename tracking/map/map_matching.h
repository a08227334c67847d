// Which map points a frame sees, and where: shared by tracking, relocalisation and seeding.
//
// Candidates are copied out of the map once per frame, so that matching needs no lock. A match starts from a
// feature with a fitting descriptor near the projection and is then aligned with the point's reference patch
// where it has one.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/features/features.h"
#include "tracking/features/matching.h"
#include "tracking/map/fiducial_observation.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// A frame as tracking sees it.
struct TrackedImage {
  double time_s = 0;
  std::shared_ptr<const Pyramid> pyramid;
  std::shared_ptr<const FeatureSet> features;
  std::shared_ptr<const FiducialObservation> fiducials = {};  // what it shows of a given world
};

// A map point that could be in view.
struct Candidate {
  int id = -1;
  Eigen::Vector3d position;
  Eigen::Vector3d mean_direction;
  Descriptor descriptor{};
  double reference_distance = 0;
  double nearest = 0, farthest = 0;
  double find_rate = 0.5;  // how often it was found when it should have been
  std::shared_ptr<const ReferencePatch> patch;
  PatchAxes patch_axes;
  int times_expected = 0;  // before this frame
  // A third keyframe saw it where two had put it. Two alone agree about anything that moved along their
  // lines.
  bool confirmed = true;
};

struct CandidateOptions {
  double margin_px = 60;            // how far outside the image a projection may lie
  double max_view_change_deg = 60;  // from the mean direction it was seen in
};

// Living points that a camera near this pose may see.
std::vector<Candidate> GatherCandidates(const Map& map, const CameraModel& camera,
                                        const Rigid3& cam_from_world, const CandidateOptions& options = {});

// The same for every frame, at a cost that does not grow with the map: the points of the keyframes that share
// most with the frame before (`seen_before`: its points), and of all others kSweptPoints a frame, in turn.
// What was seen long ago and comes into view again is met within a sweep, and its keyframes with it; a map
// smaller than that is looked at whole. `sweep` keeps the place.
inline constexpr int kSweptPoints = 8192;
std::vector<Candidate> GatherCandidatesNear(const Map& map, const CameraModel& camera,
                                            const Rigid3& cam_from_world,
                                            const std::unordered_map<int, Eigen::Vector2d>& seen_before,
                                            int& sweep, const CandidateOptions& options = {});

struct PointMatch {
  int candidate = -1;  // index
  int feature = -1;    // -1: no corner was detected there, the patch alone was found
  Eigen::Vector2d img;
  double sigma_px = 1;
  bool aligned = false;
};

struct MapMatchOptions {
  double radius_px = 4;  // on level 0; grows with the level
  int max_distance = kSureDistance;
  double max_ratio = 0.9;
  bool align = true;
};

struct MapMatches {
  std::vector<PointMatch> matches;
  std::vector<int> expected;  // candidates that this pose should see, matched or not
};

// Matches candidates (those in `only`, all when empty) against the image under a pose.
MapMatches MatchMap(const CameraModel& camera, const TrackedImage& image,
                    std::span<const Candidate> candidates, std::span<const int> only,
                    const Rigid3& cam_from_world, const MapMatchOptions& options);

// Aligns matches with their patches, in place, starting from where the features are.
void AlignMatches(const CameraModel& camera, const TrackedImage& image, std::span<const Candidate> candidates,
                  const Rigid3& cam_from_world, std::vector<PointMatch>& matches);

// Looks for expected points that no detected corner matched, by their patches alone, under a pose that is
// already good to a pixel or two: corner detection repeats for about half of the points only. Poorly covered
// parts of the image come first, reliable points before others, at most `most`. Appends to `matches`. Returns
// which of the expected were looked for in every way there is: a dense map has more points in view than a
// frame has corners and patches to try, and those passed over say nothing about the pose.
std::vector<int> AlignUndetected(const CameraModel& camera, const TrackedImage& image,
                                 std::span<const Candidate> candidates, std::span<const int> expected,
                                 const Rigid3& cam_from_world, int most, std::vector<PointMatch>& matches);

std::vector<PointObservation> ToObservations(std::span<const Candidate> candidates,
                                             std::span<const PointMatch> matches);

// The frame's corners of the map's world, where that is given, brought to its time under a pose.
std::vector<PointObservation> CornersOf(const SharedMap& shared, const TrackedImage& image,
                                        const Rigid3& cam_from_world);

}  // namespace ulf::tracking
