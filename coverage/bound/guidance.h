// Guides the operator from the coverage map: where to move the camera next, at which distance, and how long
// it will take. (Beyond the thesis, which shows the map and leaves the rest to the operator; its section 2.2
// names what is hard: the offset from the previous scan line, and the distance.) Measurements are in
// docs/capture.md#guidance.
//
// The cap is scanned in rows. While cells are open ahead at the row's height, the row goes on, at the offset
// from the painted row beside it that leaves no gap; `toward` then runs ahead of the hand by what a hand
// covers in its reaction time, so that following it keeps the row straight. At the end of a row a goal is
// chosen, and kept until the hand reaches it: the place where a view gains most area for the way to go. At
// the rim this is the next row, later the largest of the remaining holes. A goal that the hand does not
// approach, or that stays open although the hand was there, is skipped for a while. Without a cap, the
// recorded area is extended evenly on all sides.
//
// Directions are unit vectors from the subject's centre in world coordinates; angles are radians.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "coverage/bound/capture_pace.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/open_directions.h"

namespace ulf::coverage {

struct Guidance {
  // The direction of the next viewpoint; none: nothing is open, or nothing is known yet.
  std::optional<Eigen::Vector3d> toward;
  double distance = 0;     // to keep from the subject's centre, world units; 0: not known yet
  double disc_radius = 0;  // the angle around its direction that one view covers from that distance
  // The angle between the hand and the recorded views above or below it, and the angle that leaves no gap;
  // none without such views, and on the way to a goal.
  struct RowOffset {
    double now = 0, wanted = 0;
  };
  std::optional<RowOffset> row;
  // Directions that the present movement, if it goes on, leaves uncovered beside its path.
  std::vector<Eigen::Vector3d> left_open;
  // Views and time expected until enough of the cap is covered; none without a cap, the time also without a
  // known pace (capture_pace.h).
  std::optional<double> views_left, seconds_left;
};

// Remembers row, goal and pace from frame to frame, and begins again with another subject. A running capture
// has one, and calls it in its own thread.
class Guide {
 public:
  // `enough`: the share of the cap at which the capture ends.
  explicit Guide(double enough) : enough_(enough) {}
  Guide() = default;
  // Call it after every frame, with the present map (null: no subject yet), the present camera (none: no
  // pose) and the device's time, on which alone the result depends.
  Guidance Update(const CoverageMap* map, const std::optional<CriterionView>& camera, double time_s);

 private:
  struct Place {
    double azimuth = 0, elevation = 0;
  };
  struct Seen {
    double time_s = 0;
    Eigen::Vector3d direction;
  };
  struct Skipped {
    Eigen::Vector3d direction;
    double until_s = 0;
  };

  void UpdateSpeed(const Eigen::Vector3d& direction, double time_s);
  std::optional<Place> Next(const Place& hand, double time_s);
  std::optional<Place> RowPlace(const Place& hand, int heading) const;
  std::optional<Place> RimPlace(const Place& hand, int heading) const;
  std::optional<Place> BestPlace(const Place& hand) const;
  void UpdateProgress(const Place& hand, const Place& place, double time_s);
  double Path(const OpenDirections::Run& run, double level) const;
  Eigen::Vector3d DirectionOf(const Place& place) const {
    return open_.frame().Direction(place.azimuth, place.elevation);
  }
  double Angle(const Place& a, const Place& b) const;
  bool IsSkipped(const Place& place) const;
  std::optional<Guidance::RowOffset> Offset(const CoverageMap& map, const Place& hand, const Place& to) const;
  std::vector<Eigen::Vector3d> LeftOpen(const Place& hand) const;
  void EstimateRest(const CoverageMap& map, Guidance& guidance) const;

  double enough_ = 1;
  std::optional<Subject> subject_;
  OpenDirections open_;
  std::deque<Seen> seen_;        // recent directions, for the hand's speed
  Eigen::Vector2d speed_{0, 0};  // along azimuth and elevation, radians per second
  int heading_ = 0;              // along azimuth: the present row's, or the last one's
  std::optional<double> level_;  // of the present row
  std::optional<Place> goal_;    // kept until it is reached; none while a row goes on
  std::optional<Place> last_;    // the place that Update() returned last
  double with_heading_s_ = 0;    // when the hand last moved in the row's direction
  Place progress_at_;  // where the hand last made progress: painted cells, or moved by a disc radius
  double progress_s_ = 0, progress_sr_ = 0;
  std::vector<Skipped> skipped_;
  CapturePace pace_;
};

}  // namespace ulf::coverage
