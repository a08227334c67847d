#include "coverage/bound/guidance.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "coverage/bound/capture_prediction.h"
#include "coverage/bound/criterion.h"

namespace ulf::coverage {
namespace {

// Tuned together with simulated people (seeds 1 to 5); docs/capture.md#guidance has the results with other
// seeds.
// Lengths, in radii of the disc that one view covers.
constexpr double kGuideNear = 0.6;   // nearer to a place it is the same place: skipped, waited for
constexpr double kGuideStrip = 0.8;  // a movement covers so much on both sides of its path
// From a new row's middle to what is painted beside it; more than 0.8 leaves gaps even without any wobble,
// less takes more rows.
constexpr double kGuidePathFromEdge = 0.75;
// A stretch with so much room on both sides keeps the row's own height.
constexpr double kGuideRowPitch = 1.55;
constexpr double kGuideBesideRow = 1.0;   // what lies farther off the row's height is another row's
constexpr double kGuideBehindDisc = 1.1;  // nearer places are half painted by the view just taken: no goals
constexpr double kGuideRowReach = 5;      // a row goes on across a painted stretch this long, no longer
constexpr double kGuideLead = 3;          // `toward` runs so far ahead of the hand, at least (see lead_s)
constexpr double kGuideArrived = 0.35;    // nearer to the goal the hand is there
constexpr double kGuideRimReach = 1.5;    // a row goes on to a rim no farther than this
constexpr double kGuideRimStrip = 0.6;  // of what is open at the rim so much above and below the row counts,
constexpr double kGuideRimOpen = 0.4;   // and less than this is not worth going there
constexpr double kGuideTurnCost = 1;    // what a change of course costs, in way
// A recorded view across from the hand is of the row beside from here on.
constexpr double kGuideBesideLeast = 0.6;
constexpr double kGuideBesideMost = 3;     // and no farther away than this
constexpr double kGuideNarrowStrip = 0.9;  // what it leaves open is told when it is narrower than this,
constexpr double kGuideStripAhead = 6;     // up to so far ahead
// Radii a second along a row; less is not a movement.
constexpr double kGuideRowSpeed = 0.5;    // sets the row's direction
constexpr double kGuideStripSpeed = 1.0;  // tells what it leaves open
// Shares of a disc that a view would newly cover.
constexpr double kGuideFilled = 0.02;       // a goal with no more than this is done
constexpr double kGuideProgress = 0.05;     // newly painted: the hand gets on
constexpr double kGuideWorthARow = 0.3;     // a place where less is open does not keep a row going
constexpr double kGuideWorthTheWay = 0.03;  // and is not gone to for itself
// Seconds.
constexpr double kGuideLead_s = 0.6;      // `toward` is ahead by what the hand comes in this time
constexpr double kGuideMovement_s = 0.4;  // over which the hand's speed is measured
constexpr double kGuideHeading_s = 1.2;   // against the row's direction for longer turns the row round
// A place that stays open with the hand there is skipped after,.
constexpr double kGuidePatienceThere_s = 1.5;
constexpr double kGuidePatienceOnTheWay_s = 8;  // one that the hand does not set out for after,
constexpr double kGuideSkip_s = 20;             // for so long
constexpr double kGuideEstimatedViews = 20;  // of a view's usual worth, that weigh against what was measured

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLeastCosine = 0.02;  // of an elevation: next to the poles azimuths mean nothing

double Wrap(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace

Guidance Guide::Update(const CoverageMap* map, const std::optional<CriterionView>& camera, double time_s) {
  Guidance guidance;
  if (!map || subject_ != map->subject()) {
    *this = Guide(enough_);
    if (!map) return guidance;
    subject_ = map->subject();
  }
  const auto offset =
      camera ? std::optional<Vector3d>(camera->center_in_world - subject_->center_in_world) : std::nullopt;
  if (!map->frame()) {
    if (!offset || offset->norm() <= subject_->radius) return guidance;
    guidance.distance = offset->norm();
    guidance.disc_radius = DiscRadius({.focal_px = std::max(camera->fx, camera->fy),
                                       .distance = guidance.distance,
                                       .radius = subject_->radius,
                                       .threshold_px = map->options().threshold_px})
                               .value_or(0);
    return guidance;
  }
  open_.Follow(*map);
  guidance.distance = map->reference_distance();
  guidance.disc_radius = open_.disc_radius();
  const bool stands_somewhere = offset && offset->norm() > 0;
  pace_.Update(time_s, open_.CoveredSr(), map->views().size(),
               stands_somewhere ? std::optional<Vector3d>(offset->normalized()) : std::nullopt,
               guidance.disc_radius);
  EstimateRest(*map, guidance);
  if (!stands_somewhere) {
    seen_.clear();
    if (last_) guidance.toward = DirectionOf(*last_);
    return guidance;
  }
  UpdateSpeed(offset->normalized(), time_s);
  const CapFrame::Angles at = open_.frame().Of(offset->normalized());
  const Place hand{at.azimuth, at.elevation};
  last_ = Next(hand, time_s);
  if (!last_) return guidance;
  UpdateProgress(hand, *last_, time_s);
  guidance.toward = DirectionOf(*last_);
  if (!goal_) {
    guidance.row = Offset(*map, hand, *last_);
    guidance.left_open = LeftOpen(hand);
  }
  return guidance;
}

void Guide::UpdateSpeed(const Vector3d& direction, double time_s) {
  seen_.push_back({time_s, direction});
  while (seen_.size() > 2 && seen_.front().time_s < time_s - kGuideMovement_s) seen_.pop_front();
  const Seen& first = seen_.front();
  speed_.setZero();
  if (!(time_s > first.time_s) || time_s - first.time_s > 2 * kGuideMovement_s) return;
  const CapFrame::Angles from = open_.frame().Of(first.direction), to = open_.frame().Of(direction);
  speed_ = Vector2d(Wrap(to.azimuth - from.azimuth) * std::cos(to.elevation), to.elevation - from.elevation) /
           (time_s - first.time_s);
  if (std::abs(speed_.x()) < std::max(kGuideRowSpeed * open_.disc_radius(), std::abs(speed_.y()))) return;
  // A row keeps its direction while the hand stops and turns; only a longer movement against it turns the
  // row.
  const int moves = speed_.x() > 0 ? 1 : -1;
  if (moves == heading_ || goal_ || !last_ || time_s - with_heading_s_ > kGuideHeading_s) heading_ = moves;
  if (moves == heading_) with_heading_s_ = time_s;
}

double Guide::Angle(const Place& a, const Place& b) const {
  return AngleBetween(DirectionOf(a), DirectionOf(b));
}

// Returns the elevation at which a row at about `level` passes an open run: its own level while there is room
// for another row on both sides, else beside the nearer edge; the middle of a run that one row fills.
double Guide::Path(const OpenDirections::Run& run, double level) const {
  const double radius = open_.disc_radius();
  if (run.high - run.low <= 2 * kGuidePathFromEdge * radius) return 0.5 * (run.low + run.high);
  const double lowest = run.low + kGuidePathFromEdge * radius,
               highest = run.high - kGuidePathFromEdge * radius;
  const double at = std::clamp(level, lowest, highest);
  const double above_low = at - lowest, below_high = highest - at;
  if (std::min(above_low, below_high) >= kGuideRowPitch * radius) return at;
  return above_low <= below_high ? lowest : highest;
}

bool Guide::IsSkipped(const Place& place) const {
  const Vector3d direction = DirectionOf(place);
  const double cosine = std::cos(kGuideNear * open_.disc_radius());
  return std::ranges::any_of(
      skipped_, [&](const Skipped& skipped) { return skipped.direction.dot(direction) > cosine; });
}

std::optional<Guide::Place> Guide::Next(const Place& hand, double time_s) {
  std::erase_if(skipped_, [&](const Skipped& skipped) { return skipped.until_s <= time_s; });
  if (goal_) {
    const double gain = open_.Gain(goal_->azimuth, goal_->elevation);
    const bool there = Angle(hand, *goal_) < kGuideArrived * open_.disc_radius();
    if (gain >= kGuideFilled && !there && !IsSkipped(*goal_)) return goal_;
    level_ = goal_->elevation;
    goal_.reset();
  }
  if (!level_) level_ = hand.elevation;
  const int first = heading_ != 0 ? heading_ : 1;
  for (const int heading : {first, -first}) {
    auto place = RowPlace(hand, heading);
    if (!place) place = RimPlace(hand, heading);
    if (!place) continue;
    if (heading != heading_) with_heading_s_ = time_s;
    heading_ = heading;
    level_ = place->elevation;
    return place;
  }
  goal_ = BestPlace(hand);
  if (goal_) level_ = goal_->elevation;
  return goal_;
}

std::optional<Guide::Place> Guide::RowPlace(const Place& hand, int heading) const {
  const double radius = open_.disc_radius();
  const double lead = std::max(kGuideLead * radius, kGuideLead_s * speed_.norm());
  const double cosine = std::max(kLeastCosine, std::cos(hand.elevation));
  const int here = open_.ColumnOf(hand.azimuth);
  std::optional<Place> ahead;
  for (int step = 1; step < open_.columns(); ++step) {
    const auto column = open_.Wrapped(here + heading * step);
    const double away = step * open_.column_width() * cosine;
    if (away > kGuideRowReach * radius || (ahead && away > lead)) break;
    if (!column && open_.Wrapped(here)) break;  // beyond the rim
    if (!column || away < kGuideBehindDisc * radius) continue;
    const double level = ahead ? ahead->elevation : *level_;
    std::optional<Place> best;
    for (const OpenDirections::Run& run : open_.Runs(*column)) {
      const Place place{open_.Azimuth(*column), Path(run, level)};
      if (std::abs(place.elevation - level) > kGuideBesideRow * radius ||
          std::abs(place.elevation - hand.elevation) > 2 * kGuideBesideRow * radius || IsSkipped(place) ||
          open_.Gain(place.azimuth, place.elevation) < kGuideWorthARow)
        continue;
      if (!best || std::abs(place.elevation - level) < std::abs(best->elevation - level)) best = place;
    }
    if (best)
      ahead = best;
    else if (ahead)
      break;
  }
  return ahead;
}

// Returns the rim of the cap, while less than a disc is open between it and the last view of the row.
std::optional<Guide::Place> Guide::RimPlace(const Place& hand, int heading) const {
  const double radius = open_.disc_radius();
  const double cosine = std::max(kLeastCosine, std::cos(hand.elevation));
  const int here = open_.ColumnOf(hand.azimuth);
  if (!open_.Wrapped(here) || std::abs(hand.elevation - *level_) > kGuideBesideRow * radius)
    return std::nullopt;
  std::optional<Place> rim;
  for (int step = 0;; ++step) {
    const auto column = open_.Wrapped(here + heading * step);
    if (!column) return rim;
    if (step * open_.column_width() * cosine > kGuideRimReach * radius) return std::nullopt;
    for (const OpenDirections::Run& run : open_.Runs(*column)) {
      const double inside = std::min(run.high, *level_ + kGuideRimStrip * radius) -
                            std::max(run.low, *level_ - kGuideRimStrip * radius);
      const Place place{open_.Azimuth(*column), *level_};
      if (inside > kGuideRimOpen * radius && !IsSkipped(place)) rim = place;
    }
  }
}

std::optional<Guide::Place> Guide::BestPlace(const Place& hand) const {
  const double radius = open_.disc_radius();
  const Vector3d here = DirectionOf(hand);
  std::optional<Place> best;
  double least = std::numeric_limits<double>::infinity();
  for (int column = 0; column < open_.columns(); ++column)
    for (const OpenDirections::Run& run : open_.Runs(column)) {
      const Place place{open_.Azimuth(column), Path(run, hand.elevation)};
      const double way = AngleBetween(here, DirectionOf(place));
      if ((way / radius + kGuideTurnCost) >= least) continue;  // no gain is more than one
      const double gain = std::min(1.0, open_.Gain(place.azimuth, place.elevation));
      if (gain < kGuideWorthTheWay || IsSkipped(place)) continue;
      const double cost = (way / radius + kGuideTurnCost) / gain;
      if (cost >= least) continue;
      least = cost;
      best = place;
    }
  return best;
}

// Skips a place that the hand does not go to, or that stays open although the hand is there.
void Guide::UpdateProgress(const Place& hand, const Place& place, double time_s) {
  const double radius = open_.disc_radius();
  const double away = Angle(hand, place);
  const bool painted = std::abs(open_.CoveredSr() - progress_sr_) > kGuideProgress * M_PI * radius * radius;
  if (painted || Angle(hand, progress_at_) > radius) {
    progress_at_ = hand;
    progress_s_ = time_s;
    progress_sr_ = open_.CoveredSr();
    return;
  }
  const double patience_s = away < kGuideNear * radius ? kGuidePatienceThere_s : kGuidePatienceOnTheWay_s;
  if (time_s - progress_s_ < patience_s) return;
  skipped_.push_back({DirectionOf(place), time_s + kGuideSkip_s});
  goal_.reset();
  progress_s_ = time_s;
}

// Measures to the nearest recorded views above or below the camera.
std::optional<Guidance::RowOffset> Guide::Offset(const CoverageMap& map, const Place& hand,
                                                 const Place& to) const {
  const double radius = open_.disc_radius();
  const Vector3d here = DirectionOf(hand);
  const double reach = std::cos(kGuideBesideMost * radius);
  double nearest = std::numeric_limits<double>::infinity(), side = 0;
  for (const CriterionView& view : map.views()) {
    const Vector3d direction = (view.center_in_world - map.subject().center_in_world).normalized();
    if (direction.dot(here) < reach) continue;
    const CapFrame::Angles at = open_.frame().Of(direction);
    const double across = hand.elevation - at.elevation;
    const double along = Wrap(hand.azimuth - at.azimuth) * std::cos(hand.elevation);
    if (std::abs(along) > radius || std::abs(across) < kGuideBesideLeast * radius ||
        std::abs(across) >= nearest)
      continue;
    nearest = std::abs(across);
    side = across > 0 ? 1 : -1;
  }
  if (side == 0) return std::nullopt;
  return Guidance::RowOffset{nearest, std::max(0.0, nearest + side * (to.elevation - hand.elevation))};
}

// Finds strips too narrow for a separate row, between this movement's path and the painted cells.
std::vector<Vector3d> Guide::LeftOpen(const Place& hand) const {
  constexpr double kMarkSpacing = 0.25;  // disc radii, along the elevation
  std::vector<Vector3d> left_open;
  const double radius = open_.disc_radius();
  if (speed_.norm() < kGuideStripSpeed * radius || std::abs(speed_.x()) < std::abs(speed_.y()))
    return left_open;
  const double cosine = std::max(kLeastCosine, std::cos(hand.elevation));
  const double slope = speed_.y() / std::abs(speed_.x());
  const int here = open_.ColumnOf(hand.azimuth), heading = speed_.x() > 0 ? 1 : -1;
  for (int step = 1;
       step * open_.column_width() * cosine < kGuideStripAhead * radius && step < open_.columns(); ++step) {
    const auto column = open_.Wrapped(here + heading * step);
    if (!column) break;
    const double level = hand.elevation + slope * step * open_.column_width() * cosine;
    const double low = level - kGuideStrip * radius, high = level + kGuideStrip * radius;
    for (const OpenDirections::Run& run : open_.Runs(*column)) {
      if (run.high < low || run.low > high) continue;
      const auto mark = [&](double from, double to) {
        if (to - from > kGuideNarrowStrip * radius) return;
        for (double at = from + 0.5 * kMarkSpacing * radius; at < to; at += kMarkSpacing * radius)
          left_open.push_back(open_.frame().Direction(open_.Azimuth(*column), at));
      };
      mark(run.low, std::min(run.high, low));
      mark(std::max(run.low, high), run.high);
    }
  }
  return left_open;
}

void Guide::EstimateRest(const CoverageMap& map, Guidance& guidance) const {
  if (!map.options().cap) return;
  // What one view has painted so far, mixed with the usual value while there are few views.
  const double usual =
      map.options().cap->SolidAngle() / ViewsEstimate::Of(*map.options().cap, open_.disc_radius()).usual;
  const double sr_per_view = (open_.CoveredSr() + kGuideEstimatedViews * usual) /
                             (static_cast<double>(map.views().size()) + kGuideEstimatedViews);
  const double all_sr = open_.OpenSr() + open_.CoveredSr();
  const double open_sr = std::max(0.0, open_.OpenSr() - (1 - enough_) * all_sr);
  guidance.views_left = open_sr / sr_per_view;
  guidance.seconds_left = pace_.SecondsFor(open_sr, sr_per_view);
}

}  // namespace ulf::coverage
