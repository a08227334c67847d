// Keeps the open part of a coverage map on a coarse grid that is cheap to query for every frame: columns of
// azimuth, each with the intervals of elevation that no view covers.
//
// Each Follow() reads the map around new views, and one slice of the rest, so that it costs the same whatever
// the map's size; corrected poses show up within 16 calls, in the largest grids within 130. A cell is half a
// disc radius wide and a quarter high. Without a cap the grid holds the recorded views and a margin; it grows
// with them, and when it is nearly full, so that the recorded area is extended evenly.
//
// Azimuth and elevation are those of the map's CapFrame, radians.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "coverage/bound/coverage_map.h"

namespace ulf::coverage {

class OpenDirections {
 public:
  struct Run {
    double low, high;  // elevation
  };

  // Call it after every frame, before the others. `map` must have views.
  void Follow(const CoverageMap& map);

  const CapFrame& frame() const { return *frame_; }
  double disc_radius() const { return disc_radius_; }
  int columns() const { return columns_; }
  double column_width() const { return width_ / columns_; }
  double Azimuth(int column) const { return left_ + (column + 0.5) * column_width(); }
  int ColumnOf(double azimuth) const;  // may lie outside 0 to columns()
  // Returns the column modulo columns() where the grid goes all round; none beyond its rim.
  std::optional<int> Wrapped(int column) const;
  std::vector<Run> Runs(int column) const;  // the open intervals, the lowest first
  // Returns the area that a view in this direction would newly cover, as a share of its disc, of whose part
  // beyond the rim only half counts.
  double Gain(double azimuth, double elevation) const;
  double OpenSr() const { return open_sr_; }  // of the grid
  double CoveredSr() const { return total_sr_ - open_sr_; }

 private:
  void BuildGrid(const CoverageMap& map);
  bool GrowGrid(const CoverageMap& map);
  void UpdateCell(const CoverageMap& map, int column, int row);
  void UpdateAround(const CoverageMap& map, const CriterionView& view);
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(column) * static_cast<std::size_t>(rows_) + static_cast<std::size_t>(row);
  }
  int RowOf(double elevation) const;
  double CellSr(int row) const;

  Subject subject_;
  std::optional<CapFrame> frame_;
  std::optional<Cap> cap_;
  double disc_radius_ = 0;
  double left_ = 0, width_ = 0, bottom_ = 0, height_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint8_t> open_;
  double open_sr_ = 0, total_sr_ = 0;
  std::size_t known_views_ = 0, next_cell_ = 0;
};

}  // namespace ulf::coverage
