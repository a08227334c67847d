// What pictures of left-out views are worth against what they cost, as a chart.
#pragma once

#include <string>
#include <vector>

#include "core/plot/chart.h"
#include "render/quality/evaluate.h"

namespace ulf::render {

// `series` says what has a colour, `name` what stands beside the point.
ChartRow QualityRow(const std::string& series, const std::string& name, double ms, double psnr_db);
Chart QualityChart(const std::string& title, const std::string& about, std::vector<ChartRow> points);

// Each proxy a colour, each field a point.
Chart QualityChart(const EvaluateSummary& summary, const std::string& light_field);

}  // namespace ulf::render
