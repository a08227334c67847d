// Where to move next. The coverage map knows what is missing; guidance turns that into one place to go to,
// how far away to stay, and how long it will take. (Beyond the thesis, which shows the map and leaves the
// rest to the operator; its section 2.2 says what is hard: the offset from the previous scan line, and the
// distance.)
//
// How: the cap is scanned in rows. While something is open ahead at the row's height the row goes on, at the
// offset from what is painted beside it that leaves no gap; `toward` then runs ahead of the hand by what a
// hand covers in its reaction time, so that following it keeps the row straight. When nothing is, the place
// that covers most for the way there is next, and stays so until it is reached: at the rim that is the next
// row, later the largest of the holes that are left. A place that the hand does not set out for, or that
// stays open although the hand was there, is left alone for a while. Without a cap, what is recorded is
// extended evenly on all sides.
//
// Directions are unit vectors from the subject's centre in world coordinates; angles are radians.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "coverage/bound/coverage_map.h"
#include "coverage/bound/open_directions.h"

namespace ulf::coverage {

struct Guidance {
  // The viewpoint to fill next lies in this direction; none: nothing is missing, or nothing is known yet.
  std::optional<Eigen::Vector3d> toward;
  double distance = 0;     // to keep from the subject's centre, world units; 0: not known yet
  double disc_radius = 0;  // what one view covers around it at that distance
  // How far the present movement keeps from the row beside it that was scanned before, and how far it may;
  // none without such a row.
  struct RowOffset {
    double now = 0, wanted = 0;
  };
  std::optional<RowOffset> row;
  // What the present movement, kept up, passes by and leaves uncovered between itself and what is covered.
  std::vector<Eigen::Vector3d> left_open;
  std::optional<double> views_left,
      seconds_left;  // expected; none without a cap or before any speed is known
};

class Guide {
 public:
  // After every frame: the map as it now is (null: no subject yet), the camera where it now is (none: no
  // pose) and the device's time. The same calls give the same guidance.
  Guidance After(const CoverageMap* map, const std::optional<CriterionView>& camera, double time_s);

 private:
  struct Place {
    double azimuth = 0, elevation = 0;
  };
  struct Seen {
    double time_s = 0;
    Eigen::Vector3d direction;
  };
  struct Painted {
    double time_s = 0, sr = 0;
    std::size_t views = 0;
  };
  struct LeftAlone {
    Eigen::Vector3d direction;
    double until_s = 0;
  };

  void Follow(const Eigen::Vector3d& direction, double time_s);
  std::optional<Place> Next(const Place& hand, double time_s);
  std::optional<Place> AlongTheRow(const Place& hand, int heading) const;
  std::optional<Place> ToTheRim(const Place& hand, int heading) const;
  std::optional<Place> BestPerDistance(const Place& hand) const;
  void NoteProgress(const Place& hand, const Place& place, double time_s);
  double Path(const OpenDirections::Run& run, double level) const;
  double Angle(const Place& a, const Place& b) const;
  bool IsLeftAlone(const Place& place) const;
  std::optional<Guidance::RowOffset> Offset(const CoverageMap& map, const Place& hand, const Place& to) const;
  std::vector<Eigen::Vector3d> LeftOpen(const Place& hand) const;
  void Expect(const CoverageMap& map, double time_s, Guidance& guidance);

  std::optional<Subject> subject_;
  OpenDirections open_;
  std::deque<Seen> seen_;        // of late, for the hand's movement
  Eigen::Vector2d speed_{0, 0};  // along azimuth and elevation, radians per second
  int heading_ = 0;              // along azimuth: the present row's, or the last one's
  std::optional<double> level_;  // of the present row
  std::optional<Place> goal_;    // gone to until it is reached; none while a row goes on
  std::optional<Place> last_;    // what was said last
  double with_heading_s_ = 0;    // when the hand last went that way
  Place progress_at_;            // where the hand was when something was last painted or it had gone on
  double progress_s_ = 0, progress_sr_ = 0;
  std::vector<LeftAlone> left_alone_;
  std::deque<Painted> painted_;
};

}  // namespace ulf::coverage
