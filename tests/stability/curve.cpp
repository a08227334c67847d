#include "tests/stability/curve.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace ulf::test {
namespace {

constexpr double kMostlyRight = 0.9;

std::string Percent(double share) { return fmt::format("{:.0f} %", 100 * share); }

// In words, for the table.
std::string BreakingWords(const MeasuredCurve& measured) {
  if (measured.NeverBroke()) return fmt::format("none up to {:g}", measured.points.back().difficulty);
  const auto broke = measured.BreakingPoint();
  return broke ? fmt::format("{:g}", *broke) : "none is easy enough";
}

}  // namespace

double CurvePoint::Share(Verdict verdict) const {
  return static_cast<double>(std::count_if(trials.begin(), trials.end(),
                                           [&](const Trial& trial) { return trial.verdict == verdict; })) /
         static_cast<double>(trials.size());
}

std::optional<double> MeasuredCurve::BreakingPoint() const {
  std::optional<double> last;
  for (const CurvePoint& point : points) {
    if (point.Share(Verdict::kRight) < kMostlyRight) break;
    last = point.difficulty;
  }
  return last;
}

bool MeasuredCurve::NeverBroke() const { return BreakingPoint() == points.back().difficulty; }

double MeasuredCurve::WorstShareWrong() const {
  double worst = 0;
  for (const CurvePoint& point : points) worst = std::max(worst, point.Share(Verdict::kWrong));
  return worst;
}

MeasuredCurve Measure(const Curve& curve, bool quick) {
  MeasuredCurve measured{curve, {}};
  const unsigned seeds = quick ? std::min(curve.seeds, 3u) : curve.seeds;
  for (const double difficulty : quick ? std::vector{curve.easy, curve.hard} : curve.values) {
    CurvePoint point{difficulty, {}};
    for (unsigned seed = 1; seed <= seeds; ++seed) point.trials.push_back(curve.trial(difficulty, seed));
    measured.points.push_back(point);
  }
  return measured;
}

Chart ChartOf(const MeasuredCurve& measured) {
  const Curve& curve = measured.curve;
  ChartPanel shares{
      "what comes of it", {curve.difficulty, curve.logarithmic}, {"share of the trials [%]"}, {}, false};
  ChartPanel errors{"answers that were given",
                    {curve.difficulty, curve.logarithmic},
                    {curve.error, curve.logarithmic_error},
                    {},
                    false};
  for (const auto& [verdict, series] : {std::pair{Verdict::kRight, "right"},
                                        {Verdict::kWrong, "wrong without a word"},
                                        {Verdict::kSaidSo, "says so"}})
    for (const CurvePoint& point : measured.points)
      shares.points.push_back(
          {series, "", Spread::Exactly(point.difficulty), Spread::Exactly(100 * point.Share(verdict))});
  for (const CurvePoint& point : measured.points) {
    std::vector<double> given;
    for (const Trial& trial : point.trials)
      if (std::isfinite(trial.error) && trial.verdict != Verdict::kSaidSo) given.push_back(trial.error);
    errors.points.push_back({"error", "", Spread::Exactly(point.difficulty), Spread::Of(given)});
  }
  Chart chart;
  chart.name = curve.name;
  chart.title = curve.title;
  chart.about = curve.about + fmt::format(" {} seeds; errors: median, lowest to highest.",
                                          measured.points.front().trials.size());
  chart.panels = {shares, errors};
  return chart;
}

std::string StabilityPage(const std::vector<MeasuredCurve>& measured, const std::string& folder) {
  std::string page =
      "# Where methods fail\n\n"
      "`./run stability` drives every stage into the place where its method is known to fail, draws this "
      "page "
      "and its pictures, and fails where an answer is wrong without a word; `./run stability NAME...` does "
      "some. Two points of each curve are among the everyday tests (`curve_test`). A trial is right, or says "
      "so, or is wrong; the breaking point is the difficulty up to which nine trials in ten are right. What "
      "a "
      "tracker meets in whole sequences (darkness, jumps, mirrors, crowds) is in "
      "[tracking.md](tracking.md).\n\n"
      "| stage | driven by | breaking point | beyond it | most wrong |\n| --- | --- | --- | --- | --- |\n";
  for (const MeasuredCurve& m : measured) {
    const CurvePoint& last = m.points.back();
    page += fmt::format("| {}: [{}](#{}) | {} | {} | {} | {} |\n", m.curve.stage, m.curve.title, m.curve.name,
                        m.curve.difficulty, BreakingWords(m),
                        m.NeverBroke() ? "–"
                                       : fmt::format("at {:g}: {} right, {} say so", last.difficulty,
                                                     Percent(last.Share(Verdict::kRight)),
                                                     Percent(last.Share(Verdict::kSaidSo))),
                        Percent(m.WorstShareWrong()));
  }
  for (const MeasuredCurve& m : measured)
    page += fmt::format("\n<a id=\"{0}\"></a>\n## {1}\n\n![{1}]({2}/{0}.png)\n\n{3}\n", m.curve.name,
                        m.curve.title, folder, m.curve.about);
  return page;
}

std::vector<Curve> AllCurves() {
  std::vector<Curve> all;
  for (const auto& stage : {GeometryCurves, TrackingCurves, CoverageCurves, RenderCurves, AcquisitionCurves})
    for (Curve& curve : stage()) all.push_back(std::move(curve));
  return all;
}

}  // namespace ulf::test
