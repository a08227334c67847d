// A light field in one row, as the thesis's Table 6.1 has it: views, capture time, angular range, average
// angle between neighbours; how the distances spread, which views add nothing, how much of a cap is covered
// and where it is open.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/frames/frame.h"
#include "core/light_field/folder/light_check.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/gap_words.h"

namespace ulf::commands {

struct LightFieldReport {
  std::size_t views = 0;
  struct Lens {
    CameraModel camera;
    std::size_t views = 0;  // that it took
    std::string source;     // where its intrinsics are from; empty: not told
  };
  std::vector<Lens> lenses;
  double capture_s = 0;
  // The largest horizontal and vertical angle between viewpoints as seen from the subject, degrees: azimuth
  // and elevation about the first view's direction while all views are within 90 degrees of it, round the
  // vertical beyond.
  std::optional<Eigen::Vector2d> angular_range_deg;
  std::optional<double> mean_edge_deg;  // none where the viewpoints span no surface
  std::optional<Subject> subject;
  std::string units;
  std::optional<coverage::Cap> cap;
  std::optional<double> covered;  // none without a cap; by what the capture measured, too, where that decided
  std::optional<double> covered_by_bound;  // alone; none where nothing else decided
  std::optional<MeasuredErrors> measured;  // none: the capture measured no errors
  std::vector<coverage::CapGap> holes;     // what of the cap is open; empty without a cap
  struct Distances {
    double nearest = 0, median = 0, farthest = 0;  // from the subject's centre, world units
  };
  std::optional<Distances> distances;  // none without views
  std::size_t duplicates = 0;          // views that an earlier one covers
  double threshold_px = coverage::kHighThresholdPx;
  std::uint64_t taken_back = 0;  // views that are in unposed/
  std::map<std::string, std::uint64_t> reasons;
  std::size_t uncounted_views = 0;  // of sessions whose frames and time were never written
  // Views with other exposures (capture --bracket).
  struct Brackets {
    std::size_t views = 0, merged = 0;
    std::size_t fewest = 0, most = 0;   // exposures of a view, its own among them
    std::set<double> stops;             // from the view's own, to a tenth; 0 is its own
    std::optional<double> ghosts_most;  // share of a merged view's pixels; none: no view is merged
    int ghosts_most_view = 0;
  };
  std::optional<Brackets> brackets;  // none: no view has other exposures
};

struct ReportOptions {
  std::optional<coverage::Cap> cap = std::nullopt;    // none: the one that was to be covered, if any
  std::optional<Subject> subject = std::nullopt;      // none: the light field's, else from the optical axes
  std::optional<double> threshold_px = std::nullopt;  // none: the light field's, else 7
};

// Without a subject, where the axes do not give one either, what is measured about it is none. Throws
// UsageError when it is asked for a cap all the same.
LightFieldReport Describe(const LightField& light_field, const ReportOptions& options);

std::string ToText(const MeasuredErrors& measured);
nlohmann::json ToJson(const MeasuredErrors& measured);
nlohmann::json ToJson(const LightFieldReport& report);
std::string ToText(const LightFieldReport& report);

// Of several light fields, the thesis's Table 6.1: views, capture time, angular range, average angle between
// neighbours; and the share of the cap where one is measured.
struct NamedReport {
  std::string name;
  LightFieldReport report;
};
std::string TableText(const std::vector<NamedReport>& reports);
nlohmann::json TableJson(const std::vector<NamedReport>& reports);

}  // namespace ulf::commands
