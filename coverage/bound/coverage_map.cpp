#include "coverage/bound/coverage_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/up_direction.h"
#include "coverage/bound/criterion.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;

// Limits the memory; guessed. Only thresholds barely above two pixels over the whole sphere reach it.
constexpr double kMostCells = 4e6;

// Returns the radius for views at `distance`, limited so that the grid stays usable if they cover nothing or
// everything.
double DiscRadiusFor(const CriterionView& camera, const Subject& subject, double distance,
                     double threshold_px) {
  constexpr double kSmallest = 1e-4, kLargest = 0.3;
  if (distance <= subject.radius) return kSmallest;
  const auto radius = DiscRadius({.focal_px = std::max(camera.fx, camera.fy),
                                  .distance = distance,
                                  .radius = subject.radius,
                                  .threshold_px = threshold_px});
  return std::clamp(radius.value_or(kSmallest), kSmallest, kLargest);
}

}  // namespace

Cap Cap::ParseDegrees(const std::string& text) {
  double width_deg = 0, height_deg = 0;
  int used = 0;
  if (std::sscanf(text.c_str(), "%lfx%lf%n", &width_deg, &height_deg, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || !(width_deg > 0 && width_deg <= 360) ||
      !(height_deg > 0 && height_deg <= 180))
    throw Refusal("", text, fmt::format("'{}' is not a cap", text),
                  "write width x height in degrees, up to 360x180, for example 60x40");
  return FromDegrees({width_deg, height_deg});
}

CapGoal CapGoal::Parse(const std::string& text) {
  const std::size_t colon = text.find(':');
  CapGoal goal{Cap::ParseDegrees(text.substr(0, colon)), {}};
  if (colon == std::string::npos) return goal;
  const std::string share = text.substr(colon + 1);
  double value = 0;
  int used = 0;
  if (std::sscanf(share.c_str(), "%lf%n", &value, &used) == 1) {
    const std::string rest = share.substr(static_cast<std::size_t>(used));
    if (rest == "%") value /= 100;
    if ((rest.empty() || rest == "%") && value > 0 && value <= 1) goal.share = value;
  }
  if (!goal.share) throw Refusal(text, "", fmt::format("'{}' is not a share", share), "write 0.95 or 95%");
  return goal;
}

Cap Cap::FromDegrees(const Eigen::Vector2d& width_and_height) {
  return {Radians(width_and_height.x()), Radians(width_and_height.y())};
}

Eigen::Vector2d Cap::Degrees() const { return {ulf::Degrees(width), ulf::Degrees(height)}; }

Cap Cap::WholeSphere() { return {2 * M_PI, M_PI}; }

double Cap::SolidAngle() const { return width * 2 * std::sin(height / 2); }

CapFrame::CapFrame(const Vector3d& first_direction, const Vector3d& up_in_world)
    : forward_(first_direction.normalized()) {
  // To the right of a person who stands at the first view and looks at the subject.
  right_ = (-forward_).cross(up_in_world);
  if (right_.norm() < 1e-9 * up_in_world.norm()) right_ = forward_.unitOrthogonal();
  right_.normalize();
  up_ = right_.cross(-forward_);
}

CapFrame::Angles CapFrame::Of(const Vector3d& direction) const {
  return {std::atan2(direction.dot(right_), direction.dot(forward_)),
          std::asin(std::clamp(direction.dot(up_), -1.0, 1.0))};
}

Vector3d CapFrame::Direction(double azimuth, double elevation) const {
  return std::cos(elevation) * (std::cos(azimuth) * forward_ + std::sin(azimuth) * right_) +
         std::sin(elevation) * up_;
}

bool CapFrame::Holds(const Cap& cap, const Vector3d& direction) const {
  const Angles angles = Of(direction);
  return std::abs(angles.azimuth) <= cap.width / 2 && std::abs(angles.elevation) <= cap.height / 2;
}

void SubjectViews::Add(const CriterionView& view) {
  views_.push_back(view);
  directions_.push_back((view.center_in_world - subject_.center_in_world).normalized());
}

Vector3d SubjectViews::Up() const {
  std::vector<Eigen::Matrix3d> rotations;
  for (const CriterionView& view : views_) rotations.push_back(view.cam_from_world);
  return UpOfCameras(rotations);
}

CoveringView SubjectViews::Best(const CriterionView& candidate) const {
  CoveringView best;
  if (views_.empty()) return best;
  const Vector3d direction = (candidate.center_in_world - subject_.center_in_world).normalized();
  double min_squared_cosine = 0;
  const auto consider = [&](std::size_t i) {
    const double bound = BoundPx(views_[i], candidate, subject_, best.bound_px);
    if (bound >= best.bound_px) return;
    best = {bound, static_cast<int>(i)};
    const double sine = std::min(1.0, MaxCoveringSine(candidate, subject_, bound));
    min_squared_cosine = 1 - sine * sine;
  };
  std::size_t nearest = 0;
  double nearest_cosine = -2;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const double cosine = direction.dot(directions_[i]);
    if (cosine > nearest_cosine) nearest_cosine = cosine, nearest = i;
  }
  consider(nearest);
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const double cosine = direction.dot(directions_[i]);
    if (i != nearest && cosine * cosine >= min_squared_cosine) consider(i);
  }
  return best;
}

bool SubjectViews::Covers(const CriterionView& candidate, double threshold_px) const {
  const Vector3d direction = (candidate.center_in_world - subject_.center_in_world).normalized();
  const double sine = std::min(1.0, MaxCoveringSine(candidate, subject_, threshold_px));
  const double min_squared_cosine = 1 - sine * sine;
  const double give_up_px = std::nextafter(threshold_px, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const double cosine = direction.dot(directions_[i]);
    if (cosine * cosine < min_squared_cosine) continue;
    if (BoundPx(views_[i], candidate, subject_, give_up_px) <= threshold_px) return true;
  }
  return false;
}

double SubjectViews::MedianDistance() const {
  return Median(DistancesTo(subject_, views_, &CriterionView::center_in_world));
}

CoverageMap::CoverageMap(const Subject& subject, const CoverageMapOptions& options,
                         std::span<const CriterionView> views)
    : subject_(subject), options_(options), recorded_(subject) {
  for (const CriterionView& view : views) recorded_.Add(view);
  if (!views.empty()) Rebuild();
}

void CoverageMap::Add(const CriterionView& view) {
  recorded_.Add(view);
  if (IsGridStale())
    Rebuild();
  else
    Paint(static_cast<int>(views().size()) - 1);
}

double CoverageMap::FinestDiscRadius(const Cap& cap) { return 3 * std::sqrt(cap.SolidAngle() / kMostCells); }

double CoverageMap::CoveredShare() const {
  if (cells_.empty()) return 0;
  constexpr double kNearlyAll = 1 - 1e-9;  // rounding may bring the sum over cells to 1
  return open_cells_ == 0 ? 1 : std::min(kNearlyAll, painted_sr_ / total_sr_);
}

bool CoverageMap::IsGridStale() const {
  constexpr double kDistanceChange = 0.01;
  constexpr double kUpCosine = 0.99996;  // of half a degree
  if (!frame_) return true;
  if (std::abs(recorded_.MedianDistance() / reference_distance_ - 1) > kDistanceChange) return true;
  if (options_.up_in_world) return false;
  const CapFrame now((views()[0].center_in_world - subject_.center_in_world).normalized(), recorded_.Up());
  return now.Up().dot(frame_->Up()) < kUpCosine;
}

void CoverageMap::Rebuild() {
  const CriterionView& first = views()[0];
  frame_.emplace((first.center_in_world - subject_.center_in_world).normalized(),
                 options_.up_in_world.value_or(recorded_.Up()));
  reference_distance_ = recorded_.MedianDistance();
  const Cap cap = extent();
  spacing_ = DiscRadiusFor(first, subject_, reference_distance_, options_.threshold_px) /
             options_.cells_per_disc_radius;
  spacing_ = std::max(spacing_, std::sqrt(cap.SolidAngle() / kMostCells));
  const int row_count = std::max(1, static_cast<int>(std::ceil(cap.height / spacing_)));
  row_height_ = cap.height / row_count;
  rows_.clear();
  std::size_t cell_count = 0;
  total_sr_ = painted_sr_ = 0;
  for (int i = 0; i < row_count; ++i) {
    const double low = -cap.height / 2 + i * row_height_;
    const double middle = low + row_height_ / 2;
    Row row{.elevation = middle, .cell_sr = 0, .columns = 0, .first_cell = cell_count};
    row.columns = std::max(1, static_cast<int>(std::ceil(cap.width * std::cos(middle) / spacing_)));
    row.cell_sr = cap.width * (std::sin(low + row_height_) - std::sin(low)) / row.columns;
    total_sr_ += row.cell_sr * row.columns;
    cell_count += static_cast<std::size_t>(row.columns);
    rows_.push_back(row);
  }
  cells_.assign(cell_count,
                {std::numeric_limits<float>::infinity(), static_cast<float>(options_.threshold_px), -1});
  if (threshold_factor_)
    for (const Row& row : rows_)
      for (int column = 0; column < row.columns; ++column)
        cells_[Index(row, column)].threshold_px = ThresholdOf(DirectionOf(row, column));
  open_cells_ = cell_count;
  for (std::size_t i = 0; i < views().size(); ++i) Paint(static_cast<int>(i));
}

float CoverageMap::ThresholdOf(const Vector3d& direction) const {
  constexpr double kRounding = 1 + 1e-6;  // of the bounds that cells keep
  return static_cast<float>(ThresholdAt(direction) * kRounding);
}

double CoverageMap::ThresholdAt(const Vector3d& direction) const {
  const double factor = threshold_factor_ ? threshold_factor_(direction) : 1;
  return options_.threshold_px * std::min(factor, options_.most_threshold_factor);
}

void CoverageMap::SetThresholdFactor(ThresholdFactor factor) {
  threshold_factor_ = std::move(factor);
  painted_sr_ = 0;
  open_cells_ = 0;
  for (const Row& row : rows_)
    for (int column = 0; column < row.columns; ++column) {
      Cell& cell = cells_[Index(row, column)];
      cell.threshold_px = ThresholdOf(DirectionOf(row, column));
      if (cell.IsPainted())
        painted_sr_ += row.cell_sr;
      else
        ++open_cells_;
    }
}

bool CoverageMap::Covers(const CriterionView& candidate) const {
  return recorded_.Covers(candidate,
                          ThresholdAt((candidate.center_in_world - subject_.center_in_world).normalized()));
}

CriterionView CoverageMap::Hypothetical(const Vector3d& direction) const {
  return views()[0].AimedAt(subject_.center_in_world,
                            subject_.center_in_world + reference_distance_ * direction, frame_->Up());
}

void CoverageMap::Paint(int view_index) {
  const Vector3d offset =
      views()[static_cast<std::size_t>(view_index)].center_in_world - subject_.center_in_world;
  if (!(offset.norm() > 0)) return;
  const CapFrame::Angles at = frame_->Of(offset.normalized());
  const double sine = MaxCoveringSine(Hypothetical(offset.normalized()), subject_,
                                      options_.threshold_px * options_.most_threshold_factor);
  const double reach = sine >= 1 ? M_PI : std::asin(sine);
  const double min_cosine = std::cos(std::min(M_PI, reach));
  // How far the disc reaches in azimuth: everywhere once it holds a pole.
  const double half_width = std::abs(at.elevation) + reach >= M_PI / 2 - 1e-9
                                ? M_PI
                                : std::asin(std::min(1.0, std::sin(reach) / std::cos(at.elevation)));
  const double bottom = -extent().height / 2;
  const int last_row = static_cast<int>(rows_.size()) - 1;
  const int from = std::clamp(static_cast<int>((at.elevation - reach - bottom) / row_height_), 0, last_row);
  const int to = std::clamp(static_cast<int>((at.elevation + reach - bottom) / row_height_), 0, last_row);
  for (int i = from; i <= to; ++i)
    PaintRow(rows_[static_cast<std::size_t>(i)], view_index, at.azimuth, half_width, min_cosine);
}

void CoverageMap::PaintRow(const Row& row, int view_index, double azimuth, double half_width,
                           double min_cosine) {
  const CriterionView& view = views()[static_cast<std::size_t>(view_index)];
  const Vector3d direction = (view.center_in_world - subject_.center_in_world).normalized();
  const double cell_width = extent().width / row.columns;
  const double left = -extent().width / 2;
  for (const double turn : {-2 * M_PI, 0.0, 2 * M_PI}) {  // the disc may reach across the back
    const double from_azimuth = std::max(azimuth + turn - half_width, left);
    const double to_azimuth = std::min(azimuth + turn + half_width, left + extent().width);
    if (from_azimuth > to_azimuth) continue;
    const int from = std::clamp(static_cast<int>((from_azimuth - left) / cell_width), 0, row.columns - 1);
    const int to = std::clamp(static_cast<int>((to_azimuth - left) / cell_width), 0, row.columns - 1);
    for (int column = from; column <= to; ++column) {
      Cell& cell = cells_[Index(row, column)];
      if (cell.view == view_index) continue;
      const Vector3d cell_direction = frame_->Direction(left + (column + 0.5) * cell_width, row.elevation);
      if (cell_direction.dot(direction) < min_cosine) continue;
      const double limit =
          std::min<double>(cell.bound_px, options_.threshold_px * options_.most_threshold_factor + 1e-9);
      const double bound = BoundPx(view, Hypothetical(cell_direction), subject_, limit);
      if (bound >= limit) continue;
      const bool was_painted = cell.IsPainted();
      cell.bound_px = static_cast<float>(bound);
      cell.view = view_index;
      if (!was_painted && cell.IsPainted()) painted_sr_ += row.cell_sr, --open_cells_;
    }
  }
}

std::optional<CoveringView> CoverageMap::At(const Vector3d& direction) const {
  if (!frame_ || !frame_->Holds(extent(), direction)) return std::nullopt;
  const CapFrame::Angles angles = frame_->Of(direction);
  const int last_row = static_cast<int>(rows_.size()) - 1;
  const int row_index =
      std::clamp(static_cast<int>((angles.elevation + extent().height / 2) / row_height_), 0, last_row);
  const Row& row = rows_[static_cast<std::size_t>(row_index)];
  const int column =
      std::clamp(static_cast<int>((angles.azimuth + extent().width / 2) / extent().width * row.columns), 0,
                 row.columns - 1);
  return Shown(cells_[Index(row, column)]);
}

void CoverageMap::ForEachCell(const std::function<void(const CellView&)>& look) const {
  for (const Row& row : rows_)
    for (int column = 0; column < row.columns; ++column) {
      look({DirectionOf(row, column), row.cell_sr, Shown(cells_[Index(row, column)])});
    }
}

std::vector<CoverageMap::PaintedRun> CoverageMap::PaintedRuns(double widest) const {
  std::vector<PaintedRun> runs;
  const double left = -extent().width / 2;
  for (const Row& row : rows_) {
    const double cell_width = extent().width / row.columns;
    int first = 0;  // column of the present run
    for (int column = 1; column <= row.columns; ++column) {
      const int view = Shown(cells_[Index(row, first)]).index;
      const bool goes_on = column < row.columns && (column + 1 - first) * cell_width <= widest &&
                           Shown(cells_[Index(row, column)]).index == view;
      if (goes_on) continue;
      if (view >= 0)
        runs.push_back({left + first * cell_width, left + column * cell_width,
                        row.elevation - row_height_ / 2, row.elevation + row_height_ / 2, view});
      first = column;
    }
  }
  return runs;
}

Vector3d CoverageMap::DirectionOf(const Row& row, int column) const {
  return frame_->Direction(extent().width * ((column + 0.5) / row.columns - 0.5), row.elevation);
}

void CoverageMap::ForEachNeighbour(std::size_t row, int column,
                                   const std::function<void(std::size_t, int)>& look) const {
  const int columns = rows_[row].columns;
  const bool round = extent().width >= 2 * M_PI - 1e-9;
  for (const int step : {-1, 1}) {
    const int beside = column + step;
    if (beside >= 0 && beside < columns)
      look(row, beside);
    else if (round)
      look(row, (beside + columns) % columns);
    if (step < 0 ? row == 0 : row + 1 == rows_.size()) continue;
    // Rows have different numbers of columns: several cells of the next one may touch this cell.
    const std::size_t next = step < 0 ? row - 1 : row + 1;
    const double per_column = static_cast<double>(rows_[next].columns) / columns;
    const int last = rows_[next].columns - 1;
    const int from = std::clamp(static_cast<int>(column * per_column + 1e-9), 0, last);
    const int to = std::clamp(static_cast<int>((column + 1) * per_column - 1e-9), 0, last);
    for (int k = from; k <= to; ++k) look(next, k);
  }
}

CoverageHole CoverageMap::GatherHole(std::size_t row, int column, std::vector<bool>& seen) const {
  std::vector<std::pair<std::size_t, int>> open, frontier{{row, column}};
  const auto take = [&](std::size_t r, int c) {
    const std::size_t cell = Index(rows_[r], c);
    if (seen[cell] || cells_[cell].IsPainted()) return;
    seen[cell] = true;
    frontier.push_back({r, c});
  };
  seen[Index(rows_[row], column)] = true;
  CoverageHole hole{.solid_angle_sr = 0, .direction = DirectionOf(rows_[row], column)};
  Vector3d sum = Vector3d::Zero();
  while (!frontier.empty()) {
    const auto [r, c] = frontier.back();
    frontier.pop_back();
    open.push_back({r, c});
    hole.solid_angle_sr += rows_[r].cell_sr;
    sum += rows_[r].cell_sr * DirectionOf(rows_[r], c);
    ForEachNeighbour(r, c, take);
  }
  for (const auto& [r, c] : open)
    if (const Vector3d direction = DirectionOf(rows_[r], c); direction.dot(sum) > hole.direction.dot(sum))
      hole.direction = direction;
  return hole;
}

std::vector<CoverageHole> CoverageMap::Holes() const {
  std::vector<CoverageHole> holes;
  std::vector<bool> seen(cells_.size());
  for (std::size_t row = 0; row < rows_.size(); ++row)
    for (int column = 0; column < rows_[row].columns; ++column)
      if (const std::size_t cell = Index(rows_[row], column); !seen[cell] && !cells_[cell].IsPainted())
        holes.push_back(GatherHole(row, column, seen));
  std::ranges::stable_sort(holes, std::ranges::greater{}, &CoverageHole::solid_angle_sr);
  return holes;
}

std::vector<CriterionView> CriterionViews(const LightField& light_field) {
  std::vector<CriterionView> views;
  for (const View& view : light_field.views)
    views.push_back(
        CriterionView::From(light_field.CameraOf(view), view.cam_from_world, light_field.coverage_width_px));
  return views;
}

CoverageMap CoverageOf(const LightField& light_field, const Subject& subject, const std::optional<Cap>& cap,
                       double threshold_px) {
  return CoverageMap(subject,
                     {.cap = cap, .up_in_world = light_field.up_in_world, .threshold_px = threshold_px},
                     CriterionViews(light_field));
}

}  // namespace ulf::coverage
