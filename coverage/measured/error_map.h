// Maps measured errors (error_meter.h) by direction from the subject: keeps the newest measurement of each
// part of the sphere, 1.5 degrees wide. A view that is recorded nearby raises a measurement by an estimate,
// until the part is measured again.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/angles.h"
#include "core/light_field/light_field.h"
#include "render/prediction/error_cause.h"

namespace ulf::coverage {

// Describes how well the recorded views predicted a frame. Peak signal-to-noise ratios (dB) and pixels are
// those of small pictures (ErrorMeter::Options::size_px).
struct MeasuredFrame {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // from the subject to the camera, unit, world frame
  double nearest_view_angle = 0;  // radians, to the nearest recorded view, seen from the subject's centre
  double one_sided = 0;           // 0 to 1: all views that predict it stand on one side (render/prediction)
  bool measurable = false;        // false: no geometry, no overlap or no texture
  // Inside the subject's silhouette, the same after the prediction was aligned with the frame, and outside.
  double db = 0, db_aligned = 0, db_outside = 0;
  double misregistration_px = 0;  // inside, before that alignment
  render::ErrorCause cause = render::ErrorCause::kNone;
  double time_s = 0;        // the device's
  double processor_ms = 0;  // processor time of the measurement

  // Returns whether more views would improve the picture: a wrong pose, other light, a soft focus and what
  // moved in the scene do not count.
  bool IsOfTheLightField() const;
};

// How many dB a prediction gains when the nearest view is half as far away. In simulated scenes it was 0 to
// 3.4 from 12 to 6 degrees, 1.5 in the middle (docs/measured/charts/measured_error.csv).
inline constexpr double kDbPerHalving = 2;

class ErrorMap {
 public:
  void Add(const MeasuredFrame& frame);
  // Notes a recorded view in this direction: around it, errors fall with the angle to the nearest view.
  void AddView(const Eigen::Vector3d& direction);
  // Drops what was measured within `reach` (radians) of a view that is taken back.
  void RemoveView(const Eigen::Vector3d& direction, double reach);
  bool empty() const { return parts_.empty(); }

  struct Part {
    MeasuredFrame frame;
    double view_angle_now = 0;  // radians, to the nearest view, those recorded since included
    double DbNow() const;       // frame.db raised for these views, by kDbPerHalving
  };
  // Returns the nearest measurement within 3 degrees; null: none. Parts stay until the map changes.
  const Part* At(const Eigen::Vector3d& direction) const;
  std::vector<const Part*> Parts() const;

  using Key = std::array<int, 3>;  // names a part of the sphere
  static Key KeyOf(const Eigen::Vector3d& direction);

 private:
  std::map<Key, Part> parts_;
};

// Statistics of all measurable directions, by Part::DbNow().
struct ErrorSummary {
  int directions = 0, failing = 0;                          // failing: below `goal_db`
  double median_db = 0, worst_tenth_db = 0, median_px = 0;  // on the subject; second: the tenth percentile
  double median_outside_db = 0;                             // around it
  std::map<render::ErrorCause, int> causes;                 // how many fail for each
};
ErrorSummary Summarize(const ErrorMap& map, double goal_db);

// Returns "good", "fair" or "poor" for a peak signal-to-noise ratio, by the usual correspondence with mean
// opinion scores of ITU-R BT.500 (Klaue, Rathke, Wolisz: EvalVid, 2003): "good" from 31 dB, "fair" from 25
// dB; its "excellent" counts as good, its "bad" as poor.
const char* QualityInWords(double db);

// Converts to the form kept with the light field: measurable directions, each with Part::DbNow() and
// Part::view_angle_now. `cover`: the Name() of what decided; `frames`: how many were measured.
MeasuredErrors ToMeasuredErrors(const ErrorMap& map, const std::string& cover, double goal_db,
                                std::uint64_t frames);
ErrorMap ErrorMapOf(const MeasuredErrors& measured);
// Returns the light field's measurements, but for those whose nearest view is no longer there; none when
// there is no measurement or no subject.
std::optional<MeasuredErrors> ValidErrors(const LightField& light_field);

}  // namespace ulf::coverage
