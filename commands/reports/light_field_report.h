// Reports a light field in one row, like the thesis's Table 6.1: views, capture time, angular range, average
// angle between neighbours; also the spread of distances, redundant views, the covered share of a cap and its
// holes.
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
  double capture_s = 0;
  // The largest horizontal and vertical angle between viewpoints as seen from the subject, degrees: azimuth
  // and elevation about the first view's direction while all views are within 90 degrees of it, round the
  // vertical beyond.
  std::optional<Eigen::Vector2d> angular_range_deg;
  std::optional<double> mean_edge_deg;  // none if the viewpoints span no surface
  std::optional<Subject> subject;
  std::string units;
  std::optional<coverage::Cap> cap;
  std::optional<double> covered;           // none without a cap; uses measured errors if the capture did
  std::optional<double> covered_by_bound;  // none if nothing else decided
  std::optional<MeasuredErrors> measured;  // none if the capture measured no errors
  std::vector<coverage::CapGap> holes;     // open parts of the cap; empty without a cap
  struct Distances {
    double nearest = 0, median = 0, farthest = 0;  // from the subject's centre, world units
  };
  std::optional<Distances> distances;  // none without views
  std::size_t duplicates = 0;          // number of views that an earlier one covers
  double threshold_px = coverage::kHighThresholdPx;
  std::uint64_t taken_back = 0;  // number of views in unposed/
  std::map<std::string, std::uint64_t> reasons;
  std::size_t uncounted_views = 0;  // of sessions whose frames and time were never written
  // Statistics of views with other exposures (capture --bracket).
  struct Brackets {
    std::size_t views = 0, merged = 0;
    std::size_t fewest = 0, most = 0;   // exposures of a view including its own
    std::set<double> stops;             // relative to the view's own, to a tenth; 0 is its own
    std::optional<double> ghosts_most;  // share of a merged view's pixels; none if no view is merged
    int ghosts_most_view = 0;
  };
  std::optional<Brackets> brackets;  // none if no view has other exposures
};

struct ReportOptions {
  std::optional<coverage::Cap> cap = std::nullopt;    // none: the capture's, if any
  std::optional<Subject> subject = std::nullopt;      // none: the light field's, or from the optical axes
  std::optional<double> threshold_px = std::nullopt;  // none: the light field's, or 7
};

// Without a subject, if the axes give none either, values about it are none. Throws UsageError if a cap is
// asked for then.
LightFieldReport Describe(const LightField& light_field, const ReportOptions& options);

std::string ToText(const MeasuredErrors& measured);
nlohmann::json ToJson(const MeasuredErrors& measured);
nlohmann::json ToJson(const LightFieldReport& report);
std::string ToText(const LightFieldReport& report);

// Tabulates several light fields like the thesis's Table 6.1: views, capture time, angular range, average
// angle between neighbours; and the share of the cap if one is measured.
struct NamedReport {
  std::string name;
  LightFieldReport report;
};
std::string TableText(const std::vector<NamedReport>& reports);
nlohmann::json TableJson(const std::vector<NamedReport>& reports);

}  // namespace ulf::commands
