#include "tests/measure/figures.h"

#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "tests/measure/provenance.h"

namespace ulf {
namespace {

// Prints as ever, and keeps what was printed.
class Keeper : public benchmark::ConsoleReporter {
 public:
  Keeper() : ConsoleReporter(OO_Tabular) {}
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    runs_.insert(runs_.end(), runs.begin(), runs.end());
  }
  const std::vector<Run>& runs() const { return runs_; }

 private:
  std::vector<Run> runs_;
};

std::string Asked(const Target& target) {
  return target.at_most ? fmt::format("{} <= {:g}", target.what, *target.at_most)
                        : fmt::format("{} >= {:g}", target.what, target.at_least);
}

// The counters, else the time, of each run that was measured.
std::string TableOf(const std::vector<benchmark::BenchmarkReporter::Run>& runs) {
  std::string table = "| run | figures |\n| --- | --- |\n";
  for (const auto& run : runs) {
    std::string figures =
        fmt::format("{:.3g} {}", run.GetAdjustedRealTime(), benchmark::GetTimeUnitString(run.time_unit));
    for (const auto& [name, counter] : run.counters)
      figures += fmt::format(", {} {:.3g}", name, static_cast<double>(counter));
    if (run.error_occurred) figures = "not measured: " + run.error_message;
    table += fmt::format("| `{}` {} | {} |\n", run.benchmark_name(), run.report_label, figures);
  }
  return table;
}

}  // namespace

int RunBenchmarks(int argc, char** argv, const std::vector<Target>& targets) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const std::string name = std::filesystem::path(argv[0]).filename();
  const char* page = std::getenv("ULF_FIGURES");
  const std::string made_by = page ? test::Provenance("./run measure benchmarks/" + name) : "";
  Keeper keeper;
  benchmark::RunSpecifiedBenchmarks(&keeper);
  const std::string filter = benchmark::GetBenchmarkFilter();
  const bool all_asked_for = filter.empty() || filter == ".";
  if (page)
    test::ReplacePart(page, name, fmt::format("### `{}`\n\n{}\n\n{}", name, made_by, TableOf(keeper.runs())));
  int missed = 0;
  for (const Target& target : targets) {
    bool ran = false;
    for (const auto& run : keeper.runs()) {
      if (!run.benchmark_name().starts_with(target.run)) continue;
      ran = true;
      const auto counter = run.counters.find(target.counter);
      const bool measured = !run.error_occurred && counter != run.counters.end();
      const double value = measured ? static_cast<double>(counter->second) : 0;
      const bool reached = measured && (target.at_most ? value <= *target.at_most : value >= target.at_least);
      missed += !reached;
      fmt::print("target {}: {}: {}\n", target.run, Asked(target),
                 measured ? fmt::format("{:.3g}, {}", value, reached ? "reached" : "missed")
                          : "not measured, missed");
    }
    if (ran) continue;
    missed += all_asked_for;
    fmt::print("target {}: {}: not measured\n", target.run, Asked(target));
  }
  std::fflush(stdout);
  return missed > 0 ? 1 : 0;
}

}  // namespace ulf
