// Keeps charts in files: a table (CSV) beside a drawing in SVG and PNG.
#pragma once

#include <filesystem>

#include "tests/measure/chart.h"

namespace ulf::test {

// The table holds all that a chart consists of. Both throw Error.
void WriteChart(const std::filesystem::path& table, const Chart& chart);
Chart ReadChart(const std::filesystem::path& table);

// Draws to FOLDER/name.svg and .png. Throws as DrawChart() of gnuplot.h.
void DrawChart(const std::filesystem::path& folder, const Chart& chart);

}  // namespace ulf::test
