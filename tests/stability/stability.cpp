// Drives every stage into the place where it fails, and draws the page.
//
//   stability PAGE.md [--quick] [NAME...]   curves beside the page, in a folder of its name; without names
//   all,
//                                           and the page itself
//
// 1 where answers were wrong without a word more often than is known, 3 where this machine could not measure
// a curve: the page says why.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fstream>

#include "core/base/error.h"
#include "tests/stability/curve.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path page;
  bool quick = false;
  std::vector<std::string> names;
};

// In the order of the page; without names all.
std::vector<Curve> Chosen(const std::vector<std::string>& names) {
  std::vector<Curve> chosen = AllCurves();
  if (!names.empty())
    std::erase_if(chosen, [&](const Curve& curve) {
      return std::find(names.begin(), names.end(), curve.name) == names.end();
    });
  return chosen;
}

int Run(const Arguments& arguments) {
  const fs::path folder = fs::path(arguments.page).replace_extension();
  fs::create_directories(folder);
  std::vector<MeasuredCurve> measured;
  int wrong = 0, skipped = 0;
  for (const Curve& curve : Chosen(arguments.names)) {
    const auto begin = std::chrono::steady_clock::now();
    measured.push_back(Measure(curve, arguments.quick));
    const MeasuredCurve& m = measured.back();
    if (m.why_not) {
      fmt::print(stderr, "stability: {} is not measured: {}\n", curve.name, *m.why_not);
      ++skipped;
      continue;
    }
    Chart chart = ChartOf(m);
    chart.caption =
        ChartCaption(fmt::format("./run stability {}{}", arguments.quick ? "--quick " : "", curve.name));
    WriteChart(folder / (curve.name + ".csv"), chart);
    DrawChart(folder, chart);
    wrong += !m.WrongAsKnown();
    const auto broke = m.BreakingPoint();
    fmt::print("{}: {}, by {}, wrong at most {:.0f} %, {:.0f} s\n", curve.name,
               m.NeverBroke() ? "never broke"
               : broke        ? fmt::format("right up to {:g}", *broke)
                              : "never right",
               curve.difficulty, 100 * m.WorstShareWrong(),
               std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    std::fflush(stdout);
  }
  if (arguments.names.empty())
    std::ofstream(arguments.page) << StabilityPage(measured, folder.filename().string());
  if (wrong)
    fmt::print(stderr,
               "stability: {} of {} curves hold more answers that are wrong without a word than known\n",
               wrong, measured.size());
  return wrong ? 1 : skipped ? 3 : 0;
}

}  // namespace
}  // namespace ulf::test

int main(int count, char** words) {
  using namespace ulf::test;
  Arguments arguments;
  std::vector<std::string> known;
  for (const Curve& curve : AllCurves()) known.push_back(curve.name);
  CLI::App app("Drives every stage into the place where it fails");
  app.add_option("page", arguments.page, "Markdown file; pictures go into a folder of its name")->required();
  app.add_option("names", arguments.names, "Which curves; without, all of them and the page")
      ->check(CLI::IsMember(known));
  app.add_flag("--quick", arguments.quick, "Two points of each, three seeds");
  try {
    app.parse(count, words);
    return Run(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "stability: {}\n", error.what());
    return 1;
  }
}
