// Reports a light field with the figures of the thesis's Table 6.1 (views, capture time, angular range,
// average angle between neighbours), the spread of distances, redundant views, and the covered share of a cap
// and its holes. The thesis is "Unstructured Light Fields" (MIT, 2012).
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/gap_words.h"

namespace ulf::commands {

struct LightFieldReport {
  std::size_t views = 0;
  struct Lens {
    CameraModel camera;
    std::size_t views = 0;  // number of views taken with it
    std::string source;     // origin of its intrinsics; empty: unknown
  };
  std::vector<Lens> lenses;
  double capture_s = 0;  // by the camera's clock; 0: unknown
  // The horizontal and vertical extent of the viewpoints as seen from the subject, degrees: of azimuth and
  // elevation relative to the first view's direction if all views lie within 90 degrees of it, else relative
  // to the horizontal direction below it.
  std::optional<Eigen::Vector2d> angular_range_deg;
  std::optional<double> mean_edge_deg;  // angle between neighbours; none if the viewpoints span no surface
  std::optional<Subject> subject;
  std::string units;  // of the world: "metres" or "arbitrary"
  std::optional<coverage::Cap> cap;
  std::optional<double> covered;           // share of the cap, by measured errors if the capture used them
  std::optional<double> covered_by_bound;  // set if `covered` is by measured errors
  std::optional<MeasuredErrors> measured;  // none if the capture measured no errors
  std::vector<coverage::CapGap> holes;     // open parts of the cap; empty without a cap
  struct Distances {
    double nearest = 0, median = 0, farthest = 0;  // from the subject's centre, world units
  };
  std::optional<Distances> distances;  // none without views
  std::size_t duplicates = 0;          // number of views that an earlier one covers
  double threshold_px = coverage::kHighThresholdPx;
  std::uint64_t taken_back = 0;                  // number of views taken back, whose files lie in unposed/
  std::map<std::string, std::uint64_t> reasons;  // number of frames by Name(coverage::Reason)
  std::size_t uncounted_views = 0;               // views of sessions whose `reasons` were never written
  // Statistics of views with other exposures (capture --bracket).
  struct Brackets {
    std::size_t views = 0, merged = 0;
    std::size_t fewest = 0, most = 0;   // exposures of a view including its own
    std::set<double> stops;             // relative to the view's own, rounded to a tenth; 0 is its own
    std::optional<double> ghosts_most;  // largest share of ghost pixels in a merged view; none without one
    int ghosts_most_view = 0;           // View::id of that view
  };
  std::optional<Brackets> brackets;  // none if no view has other exposures
};

struct ReportOptions {
  std::optional<coverage::Cap> cap = std::nullopt;    // none: the capture's, if any
  std::optional<Subject> subject = std::nullopt;      // none: the light field's, or from the optical axes
  std::optional<double> threshold_px = std::nullopt;  // none: the light field's, or 7
};

// If there is no subject, values that need one are none or 0; then throws UsageError if `options` has a cap.
LightFieldReport Describe(const LightField& light_field, const ReportOptions& options);

std::string ToText(const MeasuredErrors& measured);
nlohmann::json ToJson(const MeasuredErrors& measured);
nlohmann::json ToJson(const LightFieldReport& report);
std::string ToText(const LightFieldReport& report);

// Tabulates several light fields like the thesis's Table 6.1, and the covered share of the cap.
struct NamedReport {
  std::string name;
  LightFieldReport report;
};
std::string TableText(const std::vector<NamedReport>& reports);
nlohmann::json TableJson(const std::vector<NamedReport>& reports);

}  // namespace ulf::commands
