// Charts in files: a table (CSV) beside a drawing in SVG and PNG.
#pragma once

#include <filesystem>

#include "tests/measure/chart.h"

namespace ulf::test {

// All there is to a chart; `ReadChart` gives it back. Throw Error.
void WriteChart(const std::filesystem::path& table, const Chart& chart);
Chart ReadChart(const std::filesystem::path& table);

// To FOLDER/name.svg and .png.
void DrawChart(const std::filesystem::path& folder, const Chart& chart);

}  // namespace ulf::test
