// Maps the error that was measured at frames by direction from the subject: the newest measurement of each
// small part of the sphere. A view that is recorded afterwards improves it by an estimate, until it is
// measured again.
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

// Describes what a frame showed of the light field's error.
struct MeasuredFrame {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // from the subject to the camera, unit, world frame
  double nearest_view_angle = 0;  // radians, from the subject: of the nearest recorded view
  double one_sided = 0;           // 1: all views that predict it stand on one side of it (render/prediction)
  bool measurable = false;        // false: no geometry, no overlap or no texture
  double db = 0, db_aligned = 0, db_outside = 0;  // in small pictures; inside the silhouette, and outside
  double misregistration_px = 0;                  // inside, in small pictures
  render::ErrorCause cause = render::ErrorCause::kNone;
  double time_s = 0;        // the device's
  double processor_ms = 0;  // that it took

  // Returns whether more views would improve the picture: what moved, or was lit or aimed differently in this
  // one frame, does not count.
  bool IsOfTheLightField() const;
};

// The gain of pictures, dB, when the nearest view is half as far away. Simulated scenes: 0 to 3.4 from 12 to
// 6 degrees, 1.5 in the middle (docs/measured/charts/measured_error.csv).
inline constexpr double kDbPerHalving = 2;

class ErrorMap {
 public:
  void Add(const MeasuredFrame& frame);
  // Notes a recorded view in this direction: around it, errors fall with the distance to the nearest view.
  void AddView(const Eigen::Vector3d& direction);
  // Drops what was measured within `reach` (radians) of a view that is taken back.
  void RemoveView(const Eigen::Vector3d& direction, double reach);
  bool empty() const { return parts_.empty(); }

  struct Part {
    MeasuredFrame frame;
    double view_angle_now = 0;  // to the nearest recorded view
    double DbNow() const;       // by kDbPerHalving
  };
  // Returns the nearest measurement; none within reach.
  const Part* At(const Eigen::Vector3d& direction) const;
  std::vector<const Part*> Parts() const;

  using Key = std::array<int, 3>;  // of a part
  static Key KeyOf(const Eigen::Vector3d& direction);

 private:
  std::map<Key, Part> parts_;
};

// Statistics of all measured directions: the median quality, that of the worst tenth, and how many are below
// `goal_db`, by cause.
struct ErrorSummary {
  int directions = 0, failing = 0;
  double median_db = 0, worst_tenth_db = 0, median_px = 0;  // on the subject
  double median_outside_db = 0;                             // around it
  std::map<render::ErrorCause, int> causes;                 // of those that fail
};
ErrorSummary Summarize(const ErrorMap& map, double goal_db);

// Returns "good", "fair" or "poor" for a peak signal-to-noise ratio, by the usual correspondence with mean
// opinion scores of ITU-R BT.500 (Klaue, Rathke, Wolisz: EvalVid, 2003): "good" from 31 dB, "fair" from 25
// dB; its "excellent" counts as good, its "bad" as poor.
const char* QualityInWords(double db);

// Converts to the form kept with the light field: measurable directions, each with Part::DbNow() and the
// angle to which it belongs.
MeasuredErrors ToMeasuredErrors(const ErrorMap& map, const std::string& cover, double goal_db,
                                std::uint64_t frames);
ErrorMap ErrorMapOf(const MeasuredErrors& measured);
// Returns the measurements that are still valid: not those whose nearest view is gone. Returns none when none
// is.
std::optional<MeasuredErrors> ValidErrors(const LightField& light_field);

}  // namespace ulf::coverage
