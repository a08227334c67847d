#include "tests/measure/runner.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>

#include "tests/measure/provenance.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFailed = 1, kNotUnderstood = 2, kNotHere = 3;

struct Arguments {
  fs::path folder;
  bool quick = false, draw = false;
  std::vector<std::string> names;
};

std::map<std::string, Measurement>& Registry() {
  static std::map<std::string, Measurement> registry;
  return registry;
}

int Make(const Measurement& one, const std::string& part, const Arguments& arguments) {
  const fs::path table = arguments.folder / (one.name + ".csv");
  if (arguments.draw && !fs::exists(table)) return 0;
  const std::string command =
      fmt::format("./run measure {}{}/{}", arguments.quick ? "--quick " : "", part, one.name);
  // Before measuring: the tree may change meanwhile, the program does not.
  const std::string measured = arguments.draw ? "" : Provenance(command);
  Chart chart = arguments.draw ? ReadChart(table) : one.measure({arguments.quick});
  chart.name = one.name;
  chart.title = one.title;
  chart.about = one.about;
  chart.caption = arguments.draw ? command + kBetween + WithoutCommand(chart.caption) : measured;
  WriteChart(table, chart);
  DrawChart(arguments.folder, chart);
  const std::string complaint = one.complaint ? one.complaint(chart) : "";
  if (!complaint.empty()) fmt::print(stderr, "{}: {}\n", one.name, complaint);
  return complaint.empty() ? 0 : kFailed;
}

int MakeApart(const Measurement& one, const std::string& part, const Arguments& arguments) {
  std::fflush(nullptr);
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    int status = kFailed;
    try {
      status = Make(one, part, arguments);
    } catch (const NotHere& why) {
      fmt::print(stderr, "{} is not measured: {}\n", one.name, why.what());
      status = kNotHere;
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}: {}\n", one.name, error.what());
    }
    std::fflush(nullptr);
    _exit(status);
  }
  int status = 0;
  rusage used{};
  if (child < 0 || wait4(child, &status, 0, &used) != child || !WIFEXITED(status)) return kFailed;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  if (!arguments.draw)
    fmt::print("{}: {:.0f} s, {} s of processor time\n", one.name, took.count(),
               used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  return WEXITSTATUS(status);
}

int Run(const MeasuringProgram& program, const Arguments& arguments) {
  const auto is_wanted = [&](const Measurement& one) {
    if (arguments.names.empty()) return arguments.draw || !one.only_named;
    return std::ranges::find(arguments.names, one.name) != arguments.names.end();
  };
  if (arguments.quick) setenv(kMeasureChanged, "1", 0);
  if (!arguments.draw) Provenance(program.part);  // refused before it is measured for an hour
  fs::create_directories(arguments.folder);
  bool failed = false, not_here = false;
  for (const Measurement& one : program.measurements)
    if (is_wanted(one)) {
      const int status = MakeApart(one, program.part, arguments);
      failed = failed || (status != 0 && status != kNotHere);
      not_here = not_here || status == kNotHere;
    }
  if (program.page && !arguments.quick) program.page(arguments.folder);
  return failed ? kFailed : not_here ? kNotHere : 0;
}

}  // namespace

std::string OneLine(const std::string& text) {
  std::string line;
  std::istringstream words(text);
  for (std::string word; words >> word;) line += (line.empty() ? "" : " ") + word;
  return line;
}

bool Register(const char* name, const Measurement& measurement) {
  Registry()[name] = measurement;
  Registry()[name].name = name;
  Registry()[name].about = OneLine(measurement.about);
  return true;
}

std::vector<Measurement> Registered() {
  std::vector<Measurement> all;
  for (const auto& [name, measurement] : Registry()) all.push_back(measurement);
  return all;
}

int RunTool(CLI::App& app, int argc, char** argv, const std::function<int()>& run) {
  try {
    app.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kNotUnderstood;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return kFailed;
  }
}

int RunMeasurements(const MeasuringProgram& program, int argc, char** argv) {
  Arguments arguments;
  std::vector<std::string> known;
  for (const Measurement& one : program.measurements) known.push_back(one.name);
  CLI::App app(program.about, program.part);
  app.add_option("folder", arguments.folder, "Where tables and pictures go")->required();
  app.add_option("names", arguments.names, "Which; without, all that take minutes")
      ->check(CLI::IsMember(known));
  app.add_flag("--quick", arguments.quick, "Fewer seeds and values");
  app.add_flag("--draw", arguments.draw, "Draws the tables in the folder anew");
  return RunTool(app, argc, argv, [&] { return Run(program, arguments); });
}

}  // namespace ulf::test
