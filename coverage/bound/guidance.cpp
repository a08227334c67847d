#include "coverage/bound/guidance.h"

#include <algorithm>
#include <cmath>

#include "coverage/bound/capture_prediction.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Lengths in disc radii.
// A row of views one and a bit radius apart leaves nothing open within 0.8 of its path; a tenth is for the
// hand's wobble.
constexpr double kPathFromEdge = 0.75;
constexpr double kRowPitch = 1.55;   // two such halves
constexpr double kBesideRow = 1.0;   // what lies this far off the row's height is another row's
constexpr double kBehindDisc = 1.1;  // nearer columns are half painted by the view just taken
constexpr double kRowReach = 5;      // a row goes on across a painted stretch this long
constexpr double kLead = 3;          // `toward` ahead of the hand, at least,
constexpr double kLeadS = 0.6;       // and as far as it comes in so long
constexpr double kArrived = 0.35;
constexpr double kNear = 0.6;
// Shares of a disc.
constexpr double kWorthARow = 0.3, kWorthTheWay = 0.03, kFilled = 0.02;
// Time.
constexpr double kMovementS = 0.4, kMeansItS = 1.2;
constexpr double kPatienceThereS = 1.5, kPatienceOnTheWayS = 8, kLeftAloneS = 20;
constexpr double kRateOverS = 20;

double Wrap(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace

Guidance Guide::After(const CoverageMap* map, const std::optional<CriterionView>& camera, double time_s) {
  Guidance guidance;
  if (!map || subject_ != map->subject()) {
    *this = Guide();
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
  Expect(*map, time_s, guidance);
  if (!offset || !(offset->norm() > 0)) {
    seen_.clear();
    if (last_) guidance.toward = open_.frame().Direction(last_->azimuth, last_->elevation);
    return guidance;
  }
  Follow(offset->normalized(), time_s);
  const CapFrame::Angles at = open_.frame().Of(offset->normalized());
  const Place hand{at.azimuth, at.elevation};
  last_ = Next(hand, time_s);
  if (!last_) return guidance;
  NoteProgress(hand, *last_, time_s);
  guidance.toward = open_.frame().Direction(last_->azimuth, last_->elevation);
  if (!goal_) {
    guidance.row = Offset(*map, hand, *last_);
    guidance.left_open = LeftOpen(hand);
  }
  return guidance;
}

void Guide::Follow(const Vector3d& direction, double time_s) {
  seen_.push_back({time_s, direction});
  while (seen_.size() > 2 && seen_.front().time_s < time_s - kMovementS) seen_.pop_front();
  const Seen& first = seen_.front();
  speed_.setZero();
  if (!(time_s > first.time_s) || time_s - first.time_s > 2 * kMovementS) return;
  const CapFrame::Angles from = open_.frame().Of(first.direction), to = open_.frame().Of(direction);
  speed_ = Vector2d(Wrap(to.azimuth - from.azimuth) * std::cos(to.elevation), to.elevation - from.elevation) /
           (time_s - first.time_s);
  if (std::abs(speed_.x()) < std::max(0.5 * open_.disc_radius(), std::abs(speed_.y()))) return;
  // A row's direction is kept while the hand comes to rest and turns; who goes against it for long means it.
  const int moves = speed_.x() > 0 ? 1 : -1;
  if (moves == heading_ || goal_ || !last_ || time_s - with_heading_s_ > kMeansItS) heading_ = moves;
  if (moves == heading_) with_heading_s_ = time_s;
}

double Guide::Angle(const Place& a, const Place& b) const {
  return std::acos(std::clamp(
      open_.frame().Direction(a.azimuth, a.elevation).dot(open_.frame().Direction(b.azimuth, b.elevation)),
      -1.0, 1.0));
}

// Where a row at about `level` runs through an open stretch: at its own height while both sides are wide
// open, else beside the nearer edge; through the middle of what one row fills.
double Guide::Path(const OpenDirections::Run& run, double level) const {
  const double radius = open_.disc_radius();
  if (run.high - run.low <= 2 * kPathFromEdge * radius) return 0.5 * (run.low + run.high);
  const double lowest = run.low + kPathFromEdge * radius, highest = run.high - kPathFromEdge * radius;
  const double at = std::clamp(level, lowest, highest);
  const double above_low = at - lowest, below_high = highest - at;
  if (std::min(above_low, below_high) >= kRowPitch * radius) return at;
  return above_low <= below_high ? lowest : highest;
}

bool Guide::IsLeftAlone(const Place& place) const {
  const Vector3d direction = open_.frame().Direction(place.azimuth, place.elevation);
  const double cosine = std::cos(kNear * open_.disc_radius());
  return std::any_of(left_alone_.begin(), left_alone_.end(),
                     [&](const LeftAlone& alone) { return alone.direction.dot(direction) > cosine; });
}

std::optional<Guide::Place> Guide::Next(const Place& hand, double time_s) {
  std::erase_if(left_alone_, [&](const LeftAlone& alone) { return alone.until_s <= time_s; });
  if (goal_) {
    const double gain = open_.Gain(goal_->azimuth, goal_->elevation);
    const bool there = Angle(hand, *goal_) < kArrived * open_.disc_radius();
    if (gain >= kFilled && !there && !IsLeftAlone(*goal_)) return goal_;
    level_ = goal_->elevation;
    goal_.reset();
  }
  if (!level_) level_ = hand.elevation;
  const int first = heading_ != 0 ? heading_ : 1;
  for (const int heading : {first, -first}) {
    auto place = AlongTheRow(hand, heading);
    if (!place) place = ToTheRim(hand, heading);
    if (!place) continue;
    if (heading != heading_) with_heading_s_ = time_s;
    heading_ = heading;
    level_ = place->elevation;
    return place;
  }
  goal_ = BestPerDistance(hand);
  if (goal_) level_ = goal_->elevation;
  return goal_;
}

std::optional<Guide::Place> Guide::AlongTheRow(const Place& hand, int heading) const {
  const double radius = open_.disc_radius();
  const double lead = std::max(kLead * radius, kLeadS * speed_.norm());
  const double cosine = std::max(0.02, std::cos(hand.elevation));
  const int here = open_.ColumnOf(hand.azimuth);
  std::optional<Place> ahead;
  for (int step = 1; step < open_.columns(); ++step) {
    const auto column = open_.Wrapped(here + heading * step);
    const double away = step * open_.column_width() * cosine;
    if (away > kRowReach * radius || (ahead && away > lead)) break;
    if (!column && open_.Wrapped(here)) break;  // beyond the rim
    if (!column || away < kBehindDisc * radius) continue;
    const double level = ahead ? ahead->elevation : *level_;
    std::optional<Place> best;
    for (const OpenDirections::Run& run : open_.Runs(*column)) {
      const Place place{open_.Azimuth(*column), Path(run, level)};
      if (std::abs(place.elevation - level) > kBesideRow * radius ||
          std::abs(place.elevation - hand.elevation) > 2 * kBesideRow * radius || IsLeftAlone(place) ||
          open_.Gain(place.azimuth, place.elevation) < kWorthARow)
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

// The last view of a row may leave less than a disc open before the rim.
std::optional<Guide::Place> Guide::ToTheRim(const Place& hand, int heading) const {
  const double radius = open_.disc_radius();
  const double cosine = std::max(0.02, std::cos(hand.elevation));
  const int here = open_.ColumnOf(hand.azimuth);
  if (!open_.Wrapped(here) || std::abs(hand.elevation - *level_) > kBesideRow * radius) return std::nullopt;
  std::optional<Place> rim;
  for (int step = 0;; ++step) {
    const auto column = open_.Wrapped(here + heading * step);
    if (!column) return rim;
    if (step * open_.column_width() * cosine > 1.5 * radius) return std::nullopt;
    for (const OpenDirections::Run& run : open_.Runs(*column)) {
      const double inside =
          std::min(run.high, *level_ + 0.6 * radius) - std::max(run.low, *level_ - 0.6 * radius);
      const Place place{open_.Azimuth(*column), *level_};
      if (inside > 0.4 * radius && !IsLeftAlone(place)) rim = place;
    }
  }
}

std::optional<Guide::Place> Guide::BestPerDistance(const Place& hand) const {
  constexpr double kTurn = 1;  // what a change of course costs, in disc radii of way
  const double radius = open_.disc_radius();
  const Vector3d here = open_.frame().Direction(hand.azimuth, hand.elevation);
  std::optional<Place> best;
  double least = std::numeric_limits<double>::infinity();
  for (int column = 0; column < open_.columns(); ++column)
    for (const OpenDirections::Run& run : open_.Runs(column)) {
      const Place place{open_.Azimuth(column), Path(run, hand.elevation)};
      const double way =
          std::acos(std::clamp(here.dot(open_.frame().Direction(place.azimuth, place.elevation)), -1.0, 1.0));
      if ((way / radius + kTurn) >= least) continue;  // no gain is more than one
      const double gain = std::min(1.0, open_.Gain(place.azimuth, place.elevation));
      if (gain < kWorthTheWay || IsLeftAlone(place)) continue;
      const double cost = (way / radius + kTurn) / gain;
      if (cost >= least) continue;
      least = cost;
      best = place;
    }
  return best;
}

// Nothing is asked for ever: a place that the hand does not set out for, or that stays open although the hand
// is there, is left alone.
void Guide::NoteProgress(const Place& hand, const Place& place, double time_s) {
  const double radius = open_.disc_radius();
  const double away = Angle(hand, place);
  const bool painted = std::abs(open_.CoveredSr() - progress_sr_) > 0.05 * M_PI * radius * radius;
  if (painted || Angle(hand, progress_at_) > radius) {
    progress_at_ = hand;
    progress_s_ = time_s;
    progress_sr_ = open_.CoveredSr();
    return;
  }
  const double patience_s = away < kNear * radius ? kPatienceThereS : kPatienceOnTheWayS;
  if (time_s - progress_s_ < patience_s) return;
  left_alone_.push_back({open_.frame().Direction(place.azimuth, place.elevation), time_s + kLeftAloneS});
  goal_.reset();
  progress_s_ = time_s;
}

// The row beside: recorded views across from the hand, on the side that the path keeps away from.
std::optional<Guidance::RowOffset> Guide::Offset(const CoverageMap& map, const Place& hand,
                                                 const Place& to) const {
  const double radius = open_.disc_radius();
  const Vector3d here = open_.frame().Direction(hand.azimuth, hand.elevation);
  const double reach = std::cos(3 * radius);
  double nearest = std::numeric_limits<double>::infinity(), side = 0;
  for (const CriterionView& view : map.views()) {
    const Vector3d direction = (view.center_in_world - map.subject().center_in_world).normalized();
    if (direction.dot(here) < reach) continue;
    const CapFrame::Angles at = open_.frame().Of(direction);
    const double across = hand.elevation - at.elevation;
    const double along = Wrap(hand.azimuth - at.azimuth) * std::cos(hand.elevation);
    if (std::abs(along) > radius || std::abs(across) < 0.6 * radius || std::abs(across) >= nearest) continue;
    nearest = std::abs(across);
    side = across > 0 ? 1 : -1;
  }
  if (side == 0) return std::nullopt;
  return Guidance::RowOffset{nearest, std::max(0.0, nearest + side * (to.elevation - hand.elevation))};
}

// Strips too narrow for a row of their own, between where this movement goes and what is painted.
std::vector<Vector3d> Guide::LeftOpen(const Place& hand) const {
  constexpr double kAhead = 6, kHalfStrip = 0.8, kNarrow = 0.9;
  std::vector<Vector3d> left_open;
  const double radius = open_.disc_radius();
  if (speed_.norm() < radius || std::abs(speed_.x()) < std::abs(speed_.y())) return left_open;
  const double cosine = std::max(0.02, std::cos(hand.elevation));
  const double slope = speed_.y() / std::abs(speed_.x());
  const int here = open_.ColumnOf(hand.azimuth), heading = speed_.x() > 0 ? 1 : -1;
  for (int step = 1; step * open_.column_width() * cosine < kAhead * radius && step < open_.columns();
       ++step) {
    const auto column = open_.Wrapped(here + heading * step);
    if (!column) break;
    const double level = hand.elevation + slope * step * open_.column_width() * cosine;
    const double low = level - kHalfStrip * radius, high = level + kHalfStrip * radius;
    for (const OpenDirections::Run& run : open_.Runs(*column)) {
      if (run.high < low || run.low > high) continue;  // the strip does not touch it
      const auto leave = [&](double from, double to) {
        if (to - from > kNarrow * radius) return;
        for (double at = from + 0.125 * radius; at < to; at += 0.25 * radius)
          left_open.push_back(open_.frame().Direction(open_.Azimuth(*column), at));
      };
      leave(run.low, std::min(run.high, low));
      leave(std::max(run.low, high), run.high);
    }
  }
  return left_open;
}

void Guide::Expect(const CoverageMap& map, double time_s, Guidance& guidance) {
  painted_.push_back({time_s, open_.CoveredSr(), map.views().size()});
  while (painted_.size() > 2 && painted_.front().time_s < time_s - kRateOverS) painted_.pop_front();
  if (!map.options().cap) return;
  // What one view has painted so far; at first as a hand is known to do it.
  constexpr double kWorth = 20;  // views that the estimate weighs
  const double usual =
      map.options().cap->SolidAngle() / ViewsEstimate::Of(*map.options().cap, open_.disc_radius()).usual;
  const double sr_per_view =
      (open_.CoveredSr() + kWorth * usual) / (static_cast<double>(map.views().size()) + kWorth);
  guidance.views_left = open_.OpenSr() / sr_per_view;
  const Painted& before = painted_.front();
  const double seconds = time_s - before.time_s, sr = open_.CoveredSr() - before.sr;
  // A sliver that was painted on the way says nothing of how fast a hand fills a cap.
  if (seconds > 2 && sr > sr_per_view) guidance.seconds_left = open_.OpenSr() * seconds / sr;
}

}  // namespace ulf::coverage
