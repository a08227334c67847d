#include "coverage/measured/error_map.h"

#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

constexpr double kErrorMapPart = Radians(1.5);  // side of a part of the sphere, less than a disc of the bound
constexpr double kErrorMapReach =
    Radians(3);  // a measurement speaks for directions nearer than that. Guessed
constexpr double kErrorMapLeastAngle = Radians(0.5);  // nearer to a view the error no longer falls. Guessed.

}  // namespace

using Eigen::Vector3d;

bool MeasuredFrame::IsOfTheLightField() const {
  return cause != render::ErrorCause::kPose && cause != render::ErrorCause::kLight &&
         cause != render::ErrorCause::kFocus && cause != render::ErrorCause::kMoved;
}

ErrorMap::Key ErrorMap::KeyOf(const Vector3d& direction) {
  const Vector3d at = direction / kErrorMapPart;
  return {static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
          static_cast<int>(std::lround(at.z()))};
}

void ErrorMap::Add(const MeasuredFrame& frame) {
  parts_.insert_or_assign(KeyOf(frame.direction), Part{frame, frame.nearest_view_angle});
}

void ErrorMap::AddView(const Vector3d& direction) {
  for (auto& [key, part] : parts_)
    part.view_angle_now = std::min(
        part.view_angle_now, std::max(kErrorMapLeastAngle, AngleBetween(direction, part.frame.direction)));
}

void ErrorMap::RemoveView(const Vector3d& direction, double reach) {
  std::erase_if(
      parts_, [&](const auto& each) { return AngleBetween(direction, each.second.frame.direction) < reach; });
}

double ErrorMap::Part::DbNow() const {
  if (!(frame.nearest_view_angle > 0) || view_angle_now >= frame.nearest_view_angle) return frame.db;
  return frame.db + kDbPerHalving * std::log2(frame.nearest_view_angle / view_angle_now);
}

const ErrorMap::Part* ErrorMap::At(const Vector3d& direction) const {
  const Part* nearest = nullptr;
  double nearest_angle = kErrorMapReach;
  const Key middle = KeyOf(direction);
  const int reach = static_cast<int>(std::ceil(kErrorMapReach / kErrorMapPart));
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z) {
        const auto found = parts_.find({middle[0] + x, middle[1] + y, middle[2] + z});
        if (found == parts_.end()) continue;
        const double angle = AngleBetween(direction, found->second.frame.direction);
        if (angle > nearest_angle) continue;
        nearest_angle = angle;
        nearest = &found->second;
      }
  return nearest;
}

std::vector<const ErrorMap::Part*> ErrorMap::Parts() const {
  std::vector<const Part*> parts;
  for (const auto& [key, part] : parts_) parts.push_back(&part);
  return parts;
}

const char* QualityInWords(double db) { return db >= 31 ? "good" : db >= 25 ? "fair" : "poor"; }

ErrorSummary Summarize(const ErrorMap& map, double goal_db) {
  ErrorSummary summary;
  std::vector<double> db, db_outside, px;
  for (const ErrorMap::Part* part : map.Parts()) {
    if (!part->frame.measurable) continue;
    ++summary.directions;
    db.push_back(part->DbNow());
    db_outside.push_back(part->frame.db_outside);
    px.push_back(part->frame.misregistration_px);
    if (db.back() >= goal_db) continue;
    ++summary.failing;
    // A session with a lower goal found nothing to explain.
    const bool unexplained = part->frame.cause == render::ErrorCause::kNone;
    ++summary.causes[unexplained ? render::ErrorCause::kDetail : part->frame.cause];
  }
  constexpr double kWorstTenth = 0.1;
  summary.median_db = Median(db);
  summary.worst_tenth_db = Quantile(db, kWorstTenth);
  summary.median_outside_db = Median(db_outside);
  summary.median_px = Median(px);
  return summary;
}

MeasuredErrors ToMeasuredErrors(const ErrorMap& map, const std::string& cover, double goal_db,
                                std::uint64_t frames) {
  MeasuredErrors measured{.cover = cover, .goal_db = goal_db, .frames = frames, .directions = {}};
  for (const ErrorMap::Part* part : map.Parts())
    if (part->frame.measurable)
      measured.directions.push_back({part->frame.direction, part->view_angle_now, part->frame.one_sided,
                                     part->DbNow(), part->frame.db_outside, part->frame.misregistration_px,
                                     Name(part->frame.cause)});
  return measured;
}

ErrorMap ErrorMapOf(const MeasuredErrors& measured) {
  ErrorMap map;
  for (const MeasuredDirection& at : measured.directions) {
    MeasuredFrame frame;
    frame.direction = at.direction;
    frame.nearest_view_angle = at.nearest_view_angle;
    frame.one_sided = at.one_sided;
    frame.measurable = true;
    frame.db = frame.db_aligned = at.db;
    frame.db_outside = at.db_outside;
    frame.misregistration_px = at.misregistration_px;
    const auto cause = std::ranges::find_if(render::kErrorCauses,
                                            [&](render::ErrorCause each) { return at.cause == Name(each); });
    if (cause != render::kErrorCauses.end()) frame.cause = *cause;
    map.Add(frame);
  }
  return map;
}

std::optional<MeasuredErrors> ValidErrors(const LightField& light_field) {
  if (!light_field.measured || !light_field.subject) return std::nullopt;
  constexpr double kMoved = Radians(0.5);  // corrections of poses move views by less. Guessed.
  MeasuredErrors standing = *light_field.measured;
  std::erase_if(standing.directions, [&](const MeasuredDirection& at) {
    return std::ranges::none_of(light_field.views, [&](const View& view) {
      const Vector3d offset = view.CenterInWorld() - light_field.subject->center_in_world;
      return AngleBetween(offset, at.direction) <= at.nearest_view_angle + kMoved;
    });
  });
  return standing.directions.empty() ? std::nullopt : std::optional(standing);
}

}  // namespace ulf::coverage
