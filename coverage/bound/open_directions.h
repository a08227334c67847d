// What of a coverage map is still open, kept so that it can be asked often: columns of azimuth, in each the
// stretches of elevation that no view covers.
//
// The map is read around new views at once and everywhere else in turn, a slice at each call, so that a call
// costs the same whatever the map's size; corrected poses are seen a second later. The grid is half a disc
// radius wide and a quarter high. Without a cap it holds what is recorded and a margin, and grows with it and
// when it is nearly full: what is there is to be made larger evenly.
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

  // `map` has views.
  void Follow(const CoverageMap& map);

  const CapFrame& frame() const { return *frame_; }
  double disc_radius() const { return disc_radius_; }
  int columns() const { return columns_; }
  double column_width() const { return width_ / columns_; }
  double Azimuth(int column) const { return left_ + (column + 0.5) * column_width(); }
  int ColumnOf(double azimuth) const;  // may lie outside 0 to columns()
  // Round the back where the grid goes all round; none beyond its rim.
  std::optional<int> Wrapped(int column) const;
  std::vector<Run> Runs(int column) const;
  // What a view there would newly cover, as a share of a disc. A disc that hangs over the rim counts as
  // smaller than it is by half of what hangs over.
  double Gain(double azimuth, double elevation) const;
  double OpenSr() const { return open_sr_; }
  double CoveredSr() const { return total_sr_ - open_sr_; }

 private:
  void Lay(const CoverageMap& map);
  bool GrowsWith(const CoverageMap& map);
  void Look(const CoverageMap& map, int column, int row);
  void LookAround(const CoverageMap& map, const CriterionView& view);
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
