#include "commands/tracking/trajectory_plot.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/quantile.h"
#include "core/geometry/small_matrices.h"
#include "core/plot/gnuplot.h"

namespace ulf::commands {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kWidth = 1200;
constexpr const char* kTruthColor = "#9a9a9a";
constexpr const char* kLiveColor = "#d95f02";
constexpr const char* kFinalColor = "#1f63b4";
constexpr const char* kPointsColor = "#4d8c15";
constexpr const char* kLostColor = "#c2185b";

// Pixels of the picture, from its upper left corner.
struct Box {
  double left, right, top, bottom;
  double Height() const { return bottom - top; }
  double Width() const { return right - left; }
};

// The views' height follows the path's; the charts over time lie below.
struct Layout {
  Box above, behind, upper, lower;
  double height;

  static Layout Of(double view_height, bool two_charts) {
    constexpr double kLeft = 78, kRight = 1182, kGap = 72, kTop = 112, kChart = 200, kBetween = 34;
    constexpr double kMiddle = (kLeft + kRight) / 2, kChartsRight = 1120, kLabels = 88, kFoot = 62;
    const double views_end = kTop + view_height, charts = views_end + kLabels;
    const double second = charts + (two_charts ? kChart + kBetween : 0), charts_end = second + kChart;
    return {{kLeft, kMiddle - kGap / 2, kTop, views_end},
            {kMiddle + kGap / 2, kRight, kTop, views_end},
            {kLeft, kChartsRight, charts, charts + kChart},
            {kLeft, kChartsRight, second, charts_end},
            charts_end + kFoot};
  }
  static double ViewWidth() { return Of(0, false).above.Width(); }

  std::string Margins(const Box& box) const {
    return fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\n"
        "set tmargin at screen {}\n",
        box.left / kWidth, box.right / kWidth, 1 - box.bottom / height, 1 - box.top / height);
  }
};

constexpr const char* kAxes =
    "set grid lc rgb '#e4e4e4' lt 1\nset border 3 lc rgb '#808080'\n"
    "set xtics nomirror textcolor rgb '#404040'\nset ytics nomirror textcolor rgb '#404040'\n";

struct Line {
  std::string name;
  std::string style;  // of gnuplot's plot
  std::vector<double> times_s;
  std::vector<Vector3d> centers;
};

// Rows: right, forward and up of the mean camera.
Matrix3d MeanCamera(const std::vector<TimedPose>& poses) {
  Vector3d right = Vector3d::Zero(), down = Vector3d::Zero(), mean = Vector3d::Zero();
  const double share = 1.0 / static_cast<double>(poses.size());
  for (const TimedPose& pose : poses) {
    const Matrix3d world_from_cam = pose.cam_from_world.RotationMatrix().transpose();
    right += share * world_from_cam.col(0);
    down += share * world_from_cam.col(1);
    mean += share * pose.cam_from_world.OriginInSource();
  }
  constexpr double kLeastDown = 0.1, kLeastRight = 0.3;  // of the mean: less gives no direction. Guessed
  const Vector3d up = down.norm() > kLeastDown ? Vector3d(-down.normalized()) : Vector3d(Vector3d::UnitZ());
  right -= up.dot(right) * up;
  if (right.norm() < kLeastRight) {  // all around: the path's longest extent runs across the picture
    Matrix3d spread = Matrix3d::Zero();
    for (const TimedPose& pose : poses) {
      Vector3d from_mean = pose.cam_from_world.OriginInSource() - mean;
      from_mean -= up.dot(from_mean) * up;
      spread += from_mean * from_mean.transpose();
    }
    right = EigenvaluesOf(spread).vectors.col(2);
    right -= up.dot(right) * up;
  }
  if (right.norm() < 1e-6) right = up.unitOrthogonal();
  right.normalize();
  Matrix3d axes;
  axes << right.transpose(), up.cross(right).transpose(), up.transpose();
  return axes;
}

struct Range {
  double from = 0, to = 0;
  double Middle() const { return 0.5 * (from + to); }
  double Length() const { return to - from; }
};

Range RangeOf(const std::vector<Line>& lines, int axis) {
  Range range{1e300, -1e300};
  for (const Line& line : lines)
    for (const Vector3d& center : line.centers) {
      range.from = std::min(range.from, center(axis));
      range.to = std::max(range.to, center(axis));
    }
  return range.from > range.to ? Range{} : range;
}

// A longer step between two times means that poses are missing.
double GapSeconds(const std::vector<double>& times_s) {
  constexpr double kUsualSteps = 2.5;  // two steps, and some jitter
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < times_s.size(); ++i) steps_s.push_back(times_s[i] - times_s[i - 1]);
  return kUsualSteps * Median(steps_s);
}

std::string LineData(const std::string& name, const Line& line) {
  const double gap_s = GapSeconds(line.times_s);
  std::string data = fmt::format("${} << EOD\n", name);
  for (std::size_t i = 0; i < line.centers.size(); ++i) {
    if (i > 0 && line.times_s[i] - line.times_s[i - 1] > gap_s) data += "\n";
    fmt::format_to(std::back_inserter(data), "{:.6g} {:.6g} {:.6g}\n", line.centers[i].x(),
                   line.centers[i].y(), line.centers[i].z());
  }
  if (line.centers.empty()) data += "NaN NaN NaN\n";
  return data + "EOD\n";
}

// The parts of `path` (the truth, or the final poses) on which the camera was lost.
Line LostParts(const std::vector<LostStretch>& stretches, const Line& path) {
  constexpr double kSameTime_s = 1e-3;
  Line lost{"no pose", fmt::format("lines lw 4 lc rgb '{}'", kLostColor), {}, {}};
  for (const LostStretch& stretch : stretches)
    for (std::size_t i = 0; i < path.centers.size(); ++i)
      if (path.times_s[i] >= stretch.from_s - kSameTime_s && path.times_s[i] <= stretch.to_s + kSameTime_s) {
        lost.times_s.push_back(path.times_s[i]);
        lost.centers.push_back(path.centers[i]);
      }
  return lost;
}

double LargestHeight(const std::vector<Line>& lines) {
  return std::max(RangeOf(lines, 1).Length(), RangeOf(lines, 2).Length());
}

std::string Views(const std::vector<Line>& lines, const Layout& layout, const std::string& unit) {
  const Range x = RangeOf(lines, 0);
  const double aspect = layout.above.Height() / layout.above.Width();
  constexpr double kMargin = 1.1;
  const double across = kMargin * std::max({x.Length(), LargestHeight(lines) / aspect, 1e-9});
  std::string script;
  for (std::size_t i = 0; i < lines.size(); ++i) script += LineData(fmt::format("line{}", i), lines[i]);
  // An empty plot holds the legend of both views.
  script += layout.Margins({layout.above.left, layout.behind.right, 44, layout.above.top - 20});
  script += "unset border\nunset tics\nset xrange [0:1]\nset yrange [0:1]\n";
  script += "set key top center horizontal maxrows 1 samplen 2.5\nplot ";
  for (std::size_t i = 0; i < lines.size(); ++i)
    script += fmt::format("{}NaN with {} title '{}'", i > 0 ? ", " : "", lines[i].style, lines[i].name);
  script += fmt::format("\nunset key\nunset label 1\n{}", kAxes);
  const auto view = [&](const Box& box, const std::string& name, int axis) {
    const Range y = RangeOf(lines, axis);
    script += layout.Margins(box);
    script += fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", x.Middle() - across / 2,
                          x.Middle() + across / 2, y.Middle() - across * aspect / 2,
                          y.Middle() + across * aspect / 2);
    script += fmt::format("set xlabel 'right [{}]' offset 0,0.5\nset ylabel '{} [{}]' offset 1.5,0\n", unit,
                          axis == 1 ? "forward" : "up", unit);
    script += fmt::format("set title '{}' offset 0,-0.6\nplot ", name);
    for (std::size_t i = 0; i < lines.size(); ++i)
      script +=
          fmt::format("{}$line{} using 1:{} with {} notitle", i > 0 ? ", " : "", i, axis + 1, lines[i].style);
    script += "\n";
  };
  view(layout.above, "from above", 1);
  view(layout.behind, "from behind", 2);
  return script;
}

// Marks the stretches without a pose behind both charts over time.
std::string Shaded(const std::vector<LostStretch>& stretches, double start_s) {
  std::string script;
  int object = 1;
  for (const LostStretch& stretch : stretches)
    script += fmt::format(
        "set object {} rectangle from first {},graph 0 to first {},graph 1 fillcolor rgb '{}' fillstyle "
        "solid 0.15 noborder behind\n",
        object++, stretch.from_s - start_s, stretch.to_s - start_s, kLostColor);
  return script;
}

std::string ErrorsOverTime(const TrackErrors& errors, double start_s) {
  const bool small = errors.live->ate_max < 0.1;
  std::string script;
  const auto data = [&](const char* name, const TrajectoryError& error) {
    std::vector<double> times_s;
    for (const auto& [time_s, distance, turn_deg] : error.errors) times_s.push_back(time_s);
    const double gap_s = GapSeconds(times_s);
    script += fmt::format("${} << EOD\n", name);
    double before_s = times_s.front();
    for (const auto& [time_s, distance, turn_deg] : error.errors) {
      if (time_s - before_s > gap_s) script += "\n";
      before_s = time_s;
      fmt::format_to(std::back_inserter(script), "{:.4f} {:.6g}\n", time_s - start_s,
                     (small ? 1000 : 1) * distance);
    }
    script += "EOD\n";
  };
  data("errorlive", *errors.live);
  data("errorfinal", *errors.final);
  script += fmt::format(
      "set format x ''\nset ylabel 'error of the centre [{}]' offset 1.5,0\nset yrange [0:*]\n"
      "plot $errorlive using 1:2 with lines lw 1.3 lc rgb '{}' notitle, $errorfinal using 1:2 with lines lw "
      "1.3 lc rgb '{}' notitle\n",
      small ? "mm" : "m", kLiveColor, kFinalColor);
  return script;
}

std::string QualityOverTime(const TrackRun& run, double start_s) {
  std::string script = "$quality << EOD\n";
  for (const TrackedFrame& frame : run.frames) {
    if (frame.track.cam_from_world)
      fmt::format_to(std::back_inserter(script), "{:.4f} {:.4f} {}\n", frame.time_s - start_s,
                     frame.track.quality, frame.track.matched_points);
    else
      script += "\n";
  }
  script += "NaN NaN NaN\nEOD\n";
  script += fmt::format(
      "set format x '%g'\nset xlabel 'time [s]' offset 0,0.5\nset ylabel 'quality' offset 1.5,0\n"
      "set yrange [0:1.05]\nset ytics 0.2\nset y2range [0:*]\nset y2tics textcolor rgb '{0}'\n"
      "set y2label 'map points found' offset -1.2,0 textcolor rgb '{0}'\n"
      "plot $quality using 1:3 axes x1y2 with lines lw 1.3 lc rgb '{0}' notitle, $quality using 1:2 with "
      "lines lw 1.5 lc rgb '#2a2a2a' notitle\n",
      kPointsColor);
  return script;
}

Line LineOf(std::string name, std::string style, const std::vector<TimedPose>& poses,
            const Similarity3& picture_from_world) {
  Line line{std::move(name), std::move(style), {}, {}};
  for (const TimedPose& pose : poses) {
    line.times_s.push_back(pose.time_s);
    line.centers.push_back(picture_from_world * pose.cam_from_world.OriginInSource());
  }
  return line;
}

}  // namespace

void PlotRun(const std::string& path, const TrackRun& run, const TrackErrors* errors,
             const std::string& title) {
  const bool compared = errors && errors->live && errors->final;
  const double start_s = run.frames.front().time_s, end_s = run.frames.back().time_s;
  const auto [live, final] = OfLastMap(run);
  std::vector<TimedPose> truth;
  if (compared)
    std::copy_if(errors->truth.begin(), errors->truth.end(), std::back_inserter(truth),
                 [&](const TimedPose& p) { return p.time_s >= start_s && p.time_s <= end_s; });
  const std::vector<TimedPose>& reference = compared ? truth : final;
  const std::vector<LostStretch> lost = LostStretches(run);

  std::vector<Line> lines;
  if (!reference.empty()) {
    Similarity3 picture_from_world{1, MeanCamera(reference), Vector3d::Zero()};
    picture_from_world.translation =
        -(picture_from_world * reference.front().cam_from_world.OriginInSource());
    const auto style = [](double width, const char* color) {
      return fmt::format("lines lw {} lc rgb '{}'", width, color);
    };
    if (compared) lines.push_back(LineOf("truth", style(4, kTruthColor), truth, picture_from_world));
    if (!lost.empty()) lines.push_back(LostParts(lost, LineOf("", "", reference, picture_from_world)));
    const Similarity3 same;
    lines.push_back(LineOf("live", style(1.2, kLiveColor), live,
                           picture_from_world * (compared ? errors->live->truth_from_estimated : same)));
    lines.push_back(LineOf("after the run", style(1.2, kFinalColor), final,
                           picture_from_world * (compared ? errors->final->truth_from_estimated : same)));
    lines.push_back(
        LineOf("start", "points pt 7 ps 1.1 lc rgb '#2a2a2a'", {reference.front()}, picture_from_world));
  }

  const double across = std::max(1e-9, RangeOf(lines, 0).Length());
  const Layout layout =
      Layout::Of(Layout::ViewWidth() * std::clamp(LargestHeight(lines) / across, 0.3, 1.0), compared);
  std::string script =
      fmt::format("set multiplot\nset label 1 {} at screen 0.5,{} center noenhanced font ',14'\n",
                  QuotedForGnuplot(title), 1 - 26 / layout.height);
  if (lines.empty()) script += kAxes;
  if (!lines.empty()) script += Views(lines, layout, compared ? "m" : "map units");
  script += fmt::format("unset title\nunset xlabel\nunset key\nset xrange [0:{}]\n",
                        std::max(1e-3, end_s - start_s));
  script += Shaded(lost, start_s);
  if (compared) script += layout.Margins(layout.upper) + ErrorsOverTime(*errors, start_s);
  script += layout.Margins(layout.lower) + QualityOverTime(run, start_s);
  DrawChart(path, kWidth, static_cast<int>(layout.height), script + "unset multiplot\n");
}

}  // namespace ulf::commands
