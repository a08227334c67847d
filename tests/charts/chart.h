// The charts of ./run charts: a table (CSV) beside a drawing in SVG and PNG, with what made them.
#pragma once

#include <filesystem>
#include <string>

#include "tests/charts/plot/chart.h"

namespace ulf::test {

using Spread = ChartSpread;

// What made it: command, processors, date (UTC), commit of the working directory, "+" where sources differ.
std::string ChartCaption(const std::string& command);

// All there is to a chart; `ReadChart` gives it back. Throw Error.
void WriteChart(const std::filesystem::path& table, const Chart& chart);
Chart ReadChart(const std::filesystem::path& table);

// To FOLDER/name.svg and .png.
void DrawChart(const std::filesystem::path& folder, const Chart& chart);

}  // namespace ulf::test
