// Maps which directions around the subject the recorded views cover, and decides whether they cover a new
// view.
//
// A direction is covered when a viewpoint in it (at the median recorded distance, aimed at the subject, with
// the first view's camera) has a bound (criterion.h) within the threshold from some recorded view. The
// threshold may differ by direction. The map keeps a grid of directions, with three cells or more (from
// FinestDiscRadius() on) to the disc radius (the angle around its direction that one view covers), and paints
// the cells around each new view.
//
// Directions are unit vectors from the subject's centre, in world coordinates. The cap that a capture is
// asked for lies around the direction of the first recorded view: azimuth and elevation both are 0 there, and
// elevation grows upwards as seen from that view, so that 60 x 40 degrees is 0.716 sr wherever it stands.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/criterion_view.h"

namespace ulf::coverage {

// The directions with azimuth and elevation (CapFrame) up to width / 2 and height / 2 from 0; radians.
struct Cap {
  double width = 0;
  double height = 0;
  static Cap ParseDegrees(const std::string& text);  // "60x40"; throws Refusal
  static Cap FromDegrees(const Eigen::Vector2d& width_and_height);
  static Cap WholeSphere();
  Eigen::Vector2d Degrees() const;  // width and height
  double SolidAngle() const;        // steradians
};

// A cap and the share of it to cover.
struct CapGoal {
  Cap cap;
  std::optional<double> share;  // above 0, up to 1; none: not given
  // Parses "60x40", "60x40:95%" or "60x40:0.95"; throws Refusal.
  static CapGoal Parse(const std::string& text);
};

// Converts between directions and their azimuth and elevation, radians, about the first view's direction.
class CapFrame {
 public:
  // Elevation grows towards the component of `up_in_world` that is perpendicular to `first_direction`; if the
  // two are parallel, towards any perpendicular.
  CapFrame(const Eigen::Vector3d& first_direction, const Eigen::Vector3d& up_in_world);
  struct Angles {
    double azimuth;    // -pi to pi, growing to the right of a person who looks at the subject
    double elevation;  // -pi/2 to pi/2
  };
  Angles Of(const Eigen::Vector3d& direction) const;
  Eigen::Vector3d Direction(double azimuth, double elevation) const;
  bool Holds(const Cap& cap, const Eigen::Vector3d& direction) const;
  const Eigen::Vector3d& Up() const { return up_; }

 private:
  Eigen::Vector3d forward_, right_, up_;
};

// The smallest bound and the recorded view that has it, counted from 0 in the order of recording; -1: no view
// has a finite bound or, in a map's cell, one within the threshold.
struct CoveringView {
  double bound_px = std::numeric_limits<double>::infinity();
  int index = -1;
};

// Holds the recorded views of one subject and finds the smallest bound among them, exactly: it passes over
// only views that are too far in angle to have it.
class SubjectViews {
 public:
  explicit SubjectViews(const Subject& subject) : subject_(subject) {}
  void Add(const CriterionView& view);
  const std::vector<CriterionView>& views() const { return views_; }
  CoveringView Best(const CriterionView& candidate) const;
  // Returns whether some view covers the candidate; stops at the first one.
  bool Covers(const CriterionView& candidate, double threshold_px) const;
  double MedianDistance() const;  // from the subject's centre, world units; 0 without views
  Eigen::Vector3d Up() const;     // in the world, as UpOfCameras() finds it

 private:
  Subject subject_;
  std::vector<CriterionView> views_;
  std::vector<Eigen::Vector3d> directions_;
};

struct CoverageMapOptions {
  std::optional<Cap> cap = std::nullopt;                      // none: the whole sphere
  std::optional<Eigen::Vector3d> up_in_world = std::nullopt;  // none: by the views
  double threshold_px = kHighThresholdPx;
  double cells_per_disc_radius = 4;  // of the grid; pictures of the map take more
  double most_threshold_factor = 1;  // larger factors of SetThresholdFactor() count as this one
};

// The factor on the threshold in a direction, a unit vector from the subject; 1: the threshold as it is.
using ThresholdFactor = std::function<double(const Eigen::Vector3d& direction)>;

// A connected region of open cells.
struct CoverageHole {
  double solid_angle_sr = 0;
  Eigen::Vector3d direction;  // of the open cell nearest to its middle
};

// Before the first view a map has no cells and no frame().
class CoverageMap {
 public:
  CoverageMap(const Subject& subject, const CoverageMapOptions& options,
              std::span<const CriterionView> views = {});
  // Paints around `view`, or lays the grid anew and paints everything when the views' median distance has
  // changed by more than 1 % or their mean up (unless it is given) by more than half a degree.
  void Add(const CriterionView& view);

  // Sets another threshold by direction, because pictures turn out better or worse than the bound must assume
  // (coverage/measured). Compares the cells' bounds with it and computes no bound.
  void SetThresholdFactor(ThresholdFactor factor);
  const ThresholdFactor& threshold_factor() const { return threshold_factor_; }  // empty: 1 everywhere
  // Returns the threshold, pixels, in the direction of a viewpoint.
  double ThresholdAt(const Eigen::Vector3d& direction) const;
  // Returns the disc radius of a view at the reference distance, by the threshold without its factor,
  // radians, at most 0.3 and no less than the grid allows; 0 before the first view.
  double DiscRadius() const { return spacing_ * options_.cells_per_disc_radius; }

  CoveringView Best(const CriterionView& candidate) const { return recorded_.Best(candidate); }
  bool Covers(const CriterionView& candidate) const;

  // Returns the share of the cap's solid angle that is covered; 1 only where every cell is. The display, the
  // end of a capture and `ulf info` all use it. In a map that got its views one by one it may differ a little
  // from that of a map made of all, because Add() tolerates small changes of distance and up.
  double CoveredShare() const;
  // Returns the view that covers a direction, with index -1 for an open one; none outside the cap.
  std::optional<CoveringView> At(const Eigen::Vector3d& direction) const;
  // The grid's cells, row by row.
  struct CellView {
    Eigen::Vector3d direction;  // of its middle
    double solid_angle_sr = 0;
    CoveringView covering;  // index -1: not covered
  };
  void ForEachCell(const std::function<void(const CellView&)>& look) const;
  // Returns the holes, the largest first.
  std::vector<CoverageHole> Holes() const;

  // The painted cells, for drawing: neighbouring cells of a row that one view paints, joined in runs no wider
  // than `widest` of azimuth (or one cell). Azimuths and elevations about frame(), radians.
  struct PaintedRun {
    double left, right, bottom, top;
    int view;  // its index in views()
  };
  std::vector<PaintedRun> PaintedRuns(double widest) const;

  const Subject& subject() const { return subject_; }
  const CoverageMapOptions& options() const { return options_; }
  const std::vector<CriterionView>& views() const { return recorded_.views(); }
  const std::optional<CapFrame>& frame() const { return frame_; }    // none before the first view
  double reference_distance() const { return reference_distance_; }  // at which cells stand for viewpoints
  double spacing() const { return spacing_; }                        // of the grid, radians
  // Returns the smallest disc radius, radians, that the grid with its limited number of cells resolves; views
  // that cover less are painted too coarsely.
  static double FinestDiscRadius(const Cap& cap);
  Cap extent() const { return options_.cap.value_or(Cap::WholeSphere()); }

 private:
  struct Row {
    double elevation;
    double cell_sr;
    int columns;
    std::size_t first_cell;
  };
  struct Cell {
    float bound_px;      // the smallest so far, painted or not
    float threshold_px;  // painted within it
    std::int32_t view;   // that has the bound; -1: none reaches the cell
    bool IsPainted() const { return view >= 0 && bound_px <= threshold_px; }
  };
  static CoveringView Shown(const Cell& cell) {
    return cell.IsPainted() ? CoveringView{cell.bound_px, cell.view} : CoveringView{};
  }
  float ThresholdOf(const Eigen::Vector3d& direction) const;
  bool IsGridStale() const;
  // Visits the cells that share an edge with this one.
  void ForEachNeighbour(std::size_t row, int column,
                        const std::function<void(std::size_t row, int column)>& look) const;
  CoverageHole GatherHole(std::size_t row, int column, std::vector<bool>& seen) const;
  Eigen::Vector3d DirectionOf(const Row& row, int column) const;
  static std::size_t Index(const Row& row, int column) {
    return row.first_cell + static_cast<std::size_t>(column);
  }
  void Rebuild();
  void Paint(int view_index);
  void PaintRow(const Row& row, int view_index, double azimuth, double half_width, double min_cosine);
  CriterionView Hypothetical(const Eigen::Vector3d& direction) const;

  Subject subject_;
  CoverageMapOptions options_;
  SubjectViews recorded_;
  std::optional<CapFrame> frame_;
  double reference_distance_ = 0;
  double spacing_ = 0, row_height_ = 0;
  std::vector<Row> rows_;
  std::vector<Cell> cells_;
  ThresholdFactor threshold_factor_;  // empty: 1
  double painted_sr_ = 0, total_sr_ = 0;
  std::size_t open_cells_ = 0;
};

// Returns the cameras of the light field's views, in their order.
std::vector<CriterionView> CriterionViews(const LightField& light_field);
// Returns what a light field's views cover of `subject`, by the light field's own up and coverage image.
// `cap`: none for the whole sphere.
CoverageMap CoverageOf(const LightField& light_field, const Subject& subject, const std::optional<Cap>& cap,
                       double threshold_px);

}  // namespace ulf::coverage
