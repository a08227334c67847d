// A chart of the quality of pictures of left-out views over the time that a picture takes.
#pragma once

#include <string>
#include <vector>

#include "tests/charts/plot/chart.h"
#include "render/quality/evaluate.h"

namespace ulf::render {

// A point: `series` gives its colour, `name` its text.
ChartRow QualityRow(const std::string& series, const std::string& name, double ms, double psnr_db);
Chart QualityChart(const std::string& title, const std::string& about, std::vector<ChartRow> points);

// One colour for each proxy, one point for each field.
Chart QualityChart(const EvaluateSummary& summary, const std::string& light_field);

}  // namespace ulf::render
