#include "coverage/bound/open_directions.h"

#include <algorithm>
#include <cmath>

namespace ulf::coverage {
namespace {

// The cost of a call was measured (docs/capture.md#guidance), the values are guessed.
// Disc radii: around a new view, where a disc that other views' distances enlarge still fits; around the
// recorded views of a grid without a cap.
constexpr double kOpenReach = 1.2, kOpenMargin = 3;
constexpr double kOpenCellWidth = 0.5, kOpenCellHeight = 0.25;  // finer finds narrower strips and costs more
constexpr double kOpenMostCells = 2e5;                          // the grid gets coarser beyond
// Cells that one call reads besides those around new views: all of them in so many calls, within these
// limits.
constexpr double kOpenCallsForAll = 16;
constexpr std::size_t kOpenFewestInTurn = 100, kOpenMostInTurn = 1500;
// The share of the disc's radius that Gain() counts: nobody covers its very rim on purpose.
constexpr double kOpenGainReach = 0.9;
constexpr double kOpenDiscChange = 0.05;         // of the map's disc radius, share; more lays the grid anew
constexpr double kOpenNearlyFull = 0.97;         // covered share from which the grid grows
constexpr double kOpenNearlyRound = 1.7 * M_PI;  // of azimuth, radians, from which it goes all round

using Eigen::Vector3d;

constexpr double kLeastRayCosine = 0.02;  // of an elevation: next to the poles azimuths mean nothing

}  // namespace

void OpenDirections::Follow(const CoverageMap& map) {
  const bool other =
      !frame_ || subject_ != map.subject() || cap_.has_value() != map.options().cap.has_value() ||
      std::abs(map.DiscRadius() / disc_radius_ - 1) > kOpenDiscChange || map.views().size() < known_views_;
  if (other) {
    subject_ = map.subject();
    cap_ = map.options().cap;
    disc_radius_ = map.DiscRadius();
    left_ = width_ = bottom_ = height_ = 0;
  }
  frame_ = map.frame();
  if (GrowGrid(map) || other) return BuildGrid(map);
  for (; known_views_ < map.views().size(); ++known_views_) UpdateAround(map, map.views()[known_views_]);
  const std::size_t in_turn =
      std::clamp(static_cast<std::size_t>(static_cast<double>(open_.size()) / kOpenCallsForAll),
                 kOpenFewestInTurn, kOpenMostInTurn);
  for (std::size_t i = 0; i < std::min(in_turn, open_.size()); ++i, ++next_cell_) {
    next_cell_ %= open_.size();
    const auto rows = static_cast<std::size_t>(rows_);
    UpdateCell(map, static_cast<int>(next_cell_ / rows), static_cast<int>(next_cell_ % rows));
  }
}

// Returns true when the grid has to be laid anew, except for another cap, which Follow() detects.
bool OpenDirections::GrowGrid(const CoverageMap& map) {
  if (cap_) {
    left_ = -cap_->width / 2, width_ = cap_->width;
    bottom_ = -cap_->height / 2, height_ = cap_->height;
    return false;
  }
  const double margin = kOpenMargin * disc_radius_;
  double left = left_, right = left_ + width_, bottom = bottom_, top = bottom_ + height_;
  if (width_ > 0 && open_sr_ < (1 - kOpenNearlyFull) * total_sr_)
    left -= margin, right += margin, bottom -= margin, top += margin;
  if (width_ == 0) left = -2 * margin, right = 2 * margin, bottom = -margin, top = margin;
  for (std::size_t i = width_ == 0 ? 0 : known_views_; i < map.views().size(); ++i) {
    const Vector3d offset = map.views()[i].center_in_world - subject_.center_in_world;
    if (!(offset.norm() > 0)) continue;
    const CapFrame::Angles at = frame_->Of(offset.normalized());
    const double wide = margin / std::max(0.1, std::cos(at.elevation));
    if (at.azimuth < left) left = at.azimuth - wide;
    if (at.azimuth > right) right = at.azimuth + wide;
    if (at.elevation < bottom) bottom = at.elevation - margin;
    if (at.elevation > top) top = at.elevation + margin;
  }
  if (right - left > kOpenNearlyRound) left = -M_PI, right = M_PI;
  bottom = std::max(bottom, -M_PI / 2), top = std::min(top, M_PI / 2);
  const bool grown =
      left != left_ || right != left_ + width_ || bottom != bottom_ || top != bottom_ + height_;
  left_ = left, width_ = right - left, bottom_ = bottom, height_ = top - bottom;
  return grown;
}

void OpenDirections::BuildGrid(const CoverageMap& map) {
  const double cells = width_ * height_ / (kOpenCellWidth * kOpenCellHeight * disc_radius_ * disc_radius_);
  const double coarser = std::max(1.0, std::sqrt(cells / kOpenMostCells));
  columns_ = std::max(1, static_cast<int>(std::ceil(width_ / (coarser * kOpenCellWidth * disc_radius_))));
  rows_ = std::max(1, static_cast<int>(std::ceil(height_ / (coarser * kOpenCellHeight * disc_radius_))));
  open_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
  total_sr_ = open_sr_ = 0;
  for (int row = 0; row < rows_; ++row) total_sr_ += columns_ * CellSr(row);
  for (int column = 0; column < columns_; ++column)
    for (int row = 0; row < rows_; ++row) UpdateCell(map, column, row);
  known_views_ = map.views().size();
  next_cell_ = 0;
}

double OpenDirections::CellSr(int row) const {
  const double low = bottom_ + row * height_ / rows_;
  return column_width() * (std::sin(low + height_ / rows_) - std::sin(low));
}

void OpenDirections::UpdateCell(const CoverageMap& map, int column, int row) {
  const Vector3d direction = frame_->Direction(Azimuth(column), bottom_ + (row + 0.5) * height_ / rows_);
  const auto covering = map.At(direction);
  const std::uint8_t open = covering && covering->index < 0 ? 1 : 0;
  std::uint8_t& cell = open_[Index(column, row)];
  if (open != cell) open_sr_ += open ? CellSr(row) : -CellSr(row);
  cell = open;
}

void OpenDirections::UpdateAround(const CoverageMap& map, const CriterionView& view) {
  const Vector3d offset = view.center_in_world - subject_.center_in_world;
  if (!(offset.norm() > 0)) return;
  const CapFrame::Angles at = frame_->Of(offset.normalized());
  const double reach = kOpenReach * disc_radius_;
  const double wide = reach / std::max(kLeastRayCosine, std::cos(at.elevation));
  const int columns = std::min(columns_ / 2, static_cast<int>(wide / column_width())) + 1;
  const int middle = ColumnOf(at.azimuth);
  for (int step = -columns; step <= columns; ++step)
    if (const auto column = Wrapped(middle + step))
      for (int row = std::max(0, RowOf(at.elevation - reach));
           row <= std::min(rows_ - 1, RowOf(at.elevation + reach)); ++row)
        UpdateCell(map, *column, row);
}

int OpenDirections::ColumnOf(double azimuth) const {
  return static_cast<int>(std::floor((azimuth - left_) / column_width()));
}

int OpenDirections::RowOf(double elevation) const {
  return static_cast<int>(std::floor((elevation - bottom_) / height_ * rows_));
}

std::optional<int> OpenDirections::Wrapped(int column) const {
  if (width_ > 2 * M_PI - 1e-9) return (column % columns_ + columns_) % columns_;
  if (column < 0 || column >= columns_) return std::nullopt;
  return column;
}

std::vector<OpenDirections::Run> OpenDirections::Runs(int column) const {
  std::vector<Run> runs;
  const double step = height_ / rows_;
  for (int row = 0; row < rows_; ++row) {
    if (!open_[Index(column, row)]) continue;
    const int first = row;
    while (row + 1 < rows_ && open_[Index(column, row + 1)]) ++row;
    runs.push_back({bottom_ + first * step, bottom_ + (row + 1) * step});
  }
  return runs;
}

double OpenDirections::Gain(double azimuth, double elevation) const {
  const double reach = kOpenGainReach * disc_radius_;
  const double cosine = std::max(kLeastRayCosine, std::cos(elevation));
  const int columns = std::min(columns_ / 2, static_cast<int>(reach / cosine / column_width()) + 1);
  const int middle = ColumnOf(azimuth);
  double open = 0, inside = 0;
  for (int step = -columns; step <= columns; ++step) {
    const auto column = Wrapped(middle + step);
    if (!column) continue;
    const double across =
        ((middle + step - (azimuth - left_) / column_width()) + 0.5) * column_width() * cosine;
    if (std::abs(across) > reach) continue;
    const double half = std::sqrt(reach * reach - across * across);
    for (int row = std::max(0, RowOf(elevation - half)); row <= std::min(rows_ - 1, RowOf(elevation + half));
         ++row) {
      inside += CellSr(row);
      if (open_[Index(*column, row)]) open += CellSr(row);
    }
  }
  return open / (0.5 * std::max(inside, M_PI * reach * reach) + 0.5 * inside + 1e-300);
}

}  // namespace ulf::coverage
