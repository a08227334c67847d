// What a map's size brings: keyframes and points against the error of the poses, for the thresholds of
// mapper_options.h, one varied at a time.
//
// map_size FOLDER RECORDING...   writes map_size.csv and map_size.png to FOLDER. A recording is a folder of
// *.jpg with intrinsics.txt and groundtruth.txt or colmap_reference.txt. Minutes for each; a table that is
// there already is gone on with.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <vector>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/gnuplot.h"
#include "tracking/tracker.h"
#include "tracking/trajectory.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

struct Threshold {
  std::string name;
  double MapperOptions::*value;
  std::vector<double> tried;
};

const std::vector<Threshold>& Thresholds() {
  static const std::vector<Threshold> thresholds{
      {"keyframe moved", &MapperOptions::keyframe_moved, {0.015, 0.02, 0.03, 0.05, 0.08, 0.12}},
      {"superfluous share", &MapperOptions::superfluous_share, {0.6, 0.7, 0.8, 0.9, 0.95, 1.01}},
      {"least found share", &MapperOptions::min_found_share, {0, 0.15, 0.25, 0.4, 0.6}},
      {"least parallax", &MapperOptions::min_parallax_deg, {0.5, 1, 2, 3}}};
  return thresholds;
}

struct Row {
  std::string recording, threshold;
  double value = 0;
  int keyframes = 0, points = 0, tracked = 0;
  double live_mm = 0, final_mm = 0;

  std::string Key() const { return fmt::format("{},{},{:g}", recording, threshold, value); }
};

constexpr const char* kHead = "recording,threshold,value,keyframes,points,tracked,live_mm,final_mm\n";

Row Measure(const fs::path& folder, const Threshold& threshold, double value) {
  const bool metric = fs::exists(folder / "groundtruth.txt") && !fs::exists(folder / "colmap_reference.txt");
  const auto truth = ReadTum(folder / (metric ? "groundtruth.txt" : "colmap_reference.txt"));
  TrackerOptions options{.deterministic = true};
  options.mapping.*threshold.value = value;
  Tracker tracker(ReadCalibration(folder / "intrinsics.txt"), options);
  const auto device = OpenDevice("replay:" + folder.string() + "?glob=*.jpg");
  device->Start();
  std::vector<TimedPose> live;
  std::vector<std::pair<double, Anchored>> anchors;
  while (const auto frame = device->Next(std::chrono::milliseconds(1000))) {
    const Track track = tracker.Step(*frame);
    if (!track.cam_from_world) continue;
    live.push_back({frame->device_time_s, *track.cam_from_world});
    anchors.emplace_back(frame->device_time_s, *track.anchor);
  }
  tracker.Finish();
  std::vector<TimedPose> after;
  for (const auto& [time_s, anchor] : anchors) after.push_back({time_s, tracker.PoseOf(anchor)});
  const auto mm = [&](const std::vector<TimedPose>& poses) {
    constexpr double kTolerance_s = 1.0 / 60;
    const auto error = CompareTrajectories(poses, truth, kTolerance_s);
    return error ? 1000 * error->ate_rmse : std::nan("");
  };
  const TrackerStatistics map = tracker.Statistics();
  return {folder.filename().string(),    threshold.name, value,    map.keyframes, map.map_points,
          static_cast<int>(live.size()), mm(live),       mm(after)};
}

std::vector<Row> ReadRows(const fs::path& table) {
  std::vector<Row> rows;
  std::ifstream file(table);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    Row row;
    char comma;
    std::getline(fields, row.recording, ',');
    std::getline(fields, row.threshold, ',');
    fields >> row.value >> comma >> row.keyframes >> comma >> row.points >> comma >> row.tracked >> comma >>
        row.live_mm >> comma >> row.final_mm;
    if (fields) rows.push_back(row);
  }
  return rows;
}

// Down a column: a recording. In it: error after the run against points, and against keyframes, a line for
// each threshold; what is used is ringed.
void Draw(const fs::path& picture, const std::vector<std::string>& recordings, const std::vector<Row>& rows) {
  constexpr std::array kColors{"#1f63b4", "#d95f02", "#4d8c15", "#7a5195"};
  std::string script = fmt::format(
      "set multiplot layout 2,{} title 'What a map''s size brings: one threshold varied at a time, the value "
      "in "
      "use ringed' font ',14' margins 0.07,0.985,0.08,0.9 spacing 0.08,0.13\n"
      "set grid lc rgb '#e4e4e4' lt 1\nset border 3 lc rgb '#808080'\nset xtics nomirror\nset ytics "
      "nomirror\n"
      "set logscale y\nset ytics (0.2, 0.5, 1, 2, 5, 10, 20)\nset key top right samplen 1.5\n",
      recordings.size());
  for (const bool by_keyframes : {false, true})
    for (const std::string& recording : recordings) {
      std::string plot;
      for (std::size_t t = 0; t < Thresholds().size(); ++t) {
        const Threshold& threshold = Thresholds()[t];
        const std::string data =
            fmt::format("${}{}{}", by_keyframes ? "k" : "p", t, &recording - recordings.data());
        std::string all = data + " << EOD\n", used = data + "u << EOD\n";
        for (const Row& row : rows) {
          if (row.recording != recording || row.threshold != threshold.name) continue;
          const std::string line = fmt::format(
              "{} {:.4g} {:.4g}\n", by_keyframes ? row.keyframes : row.points, row.final_mm, row.live_mm);
          all += line;
          if (std::abs(row.value - MapperOptions{}.*threshold.value) < 1e-9) used += line;
        }
        script += all + "EOD\n" + used + "EOD\n";
        plot += fmt::format(
            "{0}{1} using 1:2 with linespoints pt 7 ps 0.9 lw 1.5 lc rgb '{2}' title '{3}', "
            "{1} using 1:3 with linespoints pt 6 ps 0.9 lw 1 dt 3 lc rgb '{2}' notitle, "
            "{1}u using 1:2 with points pt 6 ps 2.2 lw 2 lc rgb '#000000' notitle",
            plot.empty() ? "plot " : ", ", data, kColors[t], threshold.name);
      }
      script += fmt::format(
          "set title {} noenhanced\nset xlabel '{}'\nset ylabel 'error of the centres, RMS [mm]'\n{}\n",
          QuotedForGnuplot(recording + ": after the run (full), live (dotted)"),
          by_keyframes ? "keyframes" : "map points", plot);
    }
  DrawChart(picture.string(), 1400, 980, script + "unset multiplot\n");
}

int Main(const fs::path& folder, const std::vector<fs::path>& recordings) {
  const fs::path table = folder / "map_size.csv", picture = folder / "map_size.png";
  RequireChart(picture.string());
  std::vector<Row> rows = ReadRows(table);
  std::set<std::string> done;
  for (const Row& row : rows) done.insert(row.Key());
  if (rows.empty()) std::ofstream(table) << kHead;
  std::vector<std::string> names;
  for (const fs::path& recording : recordings) {
    names.push_back(recording.filename().string());
    for (const Threshold& threshold : Thresholds())
      for (const double value : threshold.tried) {
        const Row asked{names.back(), threshold.name, value};
        if (done.contains(asked.Key())) continue;
        fmt::print(stderr, "{}\n", asked.Key());
        rows.push_back(Measure(recording, threshold, value));
        const Row& row = rows.back();
        std::ofstream file(table, std::ios::app);
        file << fmt::format("{},{},{},{},{:.4g},{:.4g}\n", row.Key(), row.keyframes, row.points, row.tracked,
                            row.live_mm, row.final_mm);
        if (!file.flush()) throw Error("{}: cannot be written", table.string());
      }
  }
  Draw(picture, names, rows);
  return 0;
}

}  // namespace
}  // namespace ulf

int main(int count, char** arguments) {
  if (count < 3) {
    fmt::print(stderr, "usage: map_size FOLDER RECORDING...\n");
    return 2;
  }
  try {
    return ulf::Main(arguments[1], {arguments + 2, arguments + count});
  } catch (const std::exception& error) {
    fmt::print(stderr, "map_size: {}\n", error.what());
    return 1;
  }
}
