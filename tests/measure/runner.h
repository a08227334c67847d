// Provides the main() of programs that measure: charts, curves, and tools with options of their own.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/measure/chart_file.h"
#include "tests/measure/effort.h"

namespace ulf::test {

// Returns a text that stands in several lines of a source with one space between words.
std::string OneLine(const std::string& text);

// One chart: the function that measures, and its words.
struct Measurement {
  std::function<Chart(const Effort&)> measure = {};  // fills panels, `found` and `same_costs` of the chart
  std::string title = {};
  std::string about = {};
  bool only_named = false;  // it takes an hour, or data sets: it is made only when it is named
  // Returns what is wrong with the chart; empty: nothing.
  std::function<std::string(const Chart&)> complaint = {};
  std::string name = {};
};

// CHART(name, measure, title, about) makes a chart known to the program that it is linked into.
bool Register(const char* name, const Measurement& measurement);
#define CHART(name, ...) [[maybe_unused]] const bool chart_##name = Register(#name, {__VA_ARGS__})
// Returns all that are registered, by name.
std::vector<Measurement> Registered();

// A measurement throws it to say why this machine cannot make it.
struct NotHere : std::runtime_error {
  using runtime_error::runtime_error;
};

struct MeasuringProgram {
  std::string part;  // of ./run measure
  std::string about;
  std::vector<Measurement> measurements;
  // Makes a page of all tables of the folder, after each run but a quick one.
  std::function<void(const std::filesystem::path& folder)> page = {};
};

//   PROGRAM FOLDER [--quick] [NAME...]   measures, and writes table, SVG and PNG of each
//   PROGRAM FOLDER --draw [NAME...]      draws the tables of the folder anew, with the words of today
//
// Each measurement runs in a process of its own, so that it leaves no thread, memory or network to the next
// one. Returns the exit status: 0; 1 where one failed or had a complaint; 2 for arguments that are not
// understood; 3 where this machine could not measure one.
int RunMeasurements(const MeasuringProgram& program, int argc, char** argv);

// Parses the arguments and calls `run`; prints errors after the app's name. Returns the exit status: `run`'s,
// 1 for errors, 2 for arguments that are not understood.
int RunTool(CLI::App& app, int argc, char** argv, const std::function<int()>& run);

}  // namespace ulf::test
