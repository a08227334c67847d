// Runs benchmarks and compares their figures with targets. A benchmark says which of its counters have to
// reach what; after the runs one line per target says whether they did, and the program's exit status is 1
// when one was missed.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "tests/measure/cpu_time.h"

namespace ulf {

struct Target {
  std::string run;      // the beginning of the run's name, as printed
  std::string counter;  // as printed
  double at_least = 0;
  std::string what;                    // for people: what is counted, with its unit
  std::optional<double> at_most = {};  // if it is set, asked for instead of at_least
};

// Prints Google Benchmark's own output, then a line for each target. A target whose run is not there counts
// as missed, unless a filter was given; one whose run was skipped with an error always does. Where
// ULF_FIGURES names a page, the figures become a table in it, with what made them (provenance.h). Returns the
// exit status: 2 for arguments that are not understood.
int RunBenchmarks(int argc, char** argv, const std::vector<Target>& targets = {});

using Clock = std::chrono::steady_clock;

}  // namespace ulf
