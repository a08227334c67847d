#include "tests/stability/curve.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace ulf::test {
namespace {

constexpr double kMostlyRight = 0.9;

std::string Percent(double share) { return fmt::format("{:.0f} %", 100 * share); }

std::string Capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string SeedsOf(const MeasuredCurve& measured) {
  const std::size_t count = measured.points.front().trials.size();
  return fmt::format("{} to {}", kFirstSeed, kFirstSeed + count - 1);
}

// Columns of the table, in words.
std::string BreakingWords(const MeasuredCurve& measured) {
  if (measured.NeverBroke()) return fmt::format("none up to {:g}", measured.points.back().difficulty);
  const auto broke = measured.BreakingPoint();
  return broke ? fmt::format("{:g}", *broke) : "none is easy enough";
}

std::string BeyondWords(const MeasuredCurve& measured) {
  if (measured.NeverBroke()) {
    const std::string& why = measured.curve.never_breaks;
    return "does not break within the range" + (why.empty() ? "" : ": " + why);
  }
  const CurvePoint& last = measured.points.back();
  std::string words = fmt::format("at {:g}: {} right", last.difficulty, Percent(last.Share(Verdict::kRight)));
  for (const auto& [verdict, what] : {std::pair{Verdict::kCareful, measured.curve.careful},
                                      {Verdict::kSaidSo, std::string("say so")},
                                      {Verdict::kWrong, std::string("wrong")}})
    if (last.Share(verdict) > 0) words += fmt::format(", {} {}", Percent(last.Share(verdict)), what);
  return words;
}

std::string WrongWords(const MeasuredCurve& measured) {
  const CurvePoint* worst = &measured.points.front();
  for (const CurvePoint& point : measured.points)
    if (point.Share(Verdict::kWrong) > worst->Share(Verdict::kWrong)) worst = &point;
  if (worst->Share(Verdict::kWrong) == 0) return "none";
  return fmt::format("{:.0f} of {}, at {:g}",
                     worst->Share(Verdict::kWrong) * static_cast<double>(worst->trials.size()),
                     worst->trials.size(), worst->difficulty);
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

bool MeasuredCurve::NeverBroke() const {
  return !points.empty() && BreakingPoint() == points.back().difficulty;
}

double MeasuredCurve::WorstShareWrong() const {
  double worst = 0;
  for (const CurvePoint& point : points) worst = std::max(worst, point.Share(Verdict::kWrong));
  return worst;
}

bool MeasuredCurve::WrongAsKnown() const {
  const bool harder_is_more = curve.values.back() > curve.values.front();
  return std::all_of(points.begin(), points.end(), [&](const CurvePoint& point) {
    const bool known = curve.wrong_from && (harder_is_more ? point.difficulty >= *curve.wrong_from
                                                           : point.difficulty <= *curve.wrong_from);
    return known || point.Share(Verdict::kWrong) <= curve.rarely_wrong;
  });
}

MeasuredCurve Measure(const Curve& curve, bool quick) {
  MeasuredCurve measured{curve, {}, curve.why_not()};
  if (measured.why_not) return measured;
  const unsigned seeds = quick ? std::min(curve.seeds, 3u) : curve.seeds;
  for (const double difficulty : quick ? std::vector{curve.easy, curve.hard} : curve.values) {
    CurvePoint point{difficulty, {}};
    for (unsigned seed = kFirstSeed; seed < kFirstSeed + seeds; ++seed)
      point.trials.push_back(curve.trial(difficulty, seed));
    measured.points.push_back(point);
  }
  return measured;
}

Chart ChartOf(const MeasuredCurve& measured) {
  const Curve& curve = measured.curve;
  // Harder is to the right.
  const ChartAxis difficulty{.label = curve.difficulty,
                             .logarithmic = curve.logarithmic,
                             .falls = curve.values.back() < curve.values.front()};
  ChartPanel shares{"What comes of it", difficulty, {"share of the trials [%]"}, {}, false};
  ChartPanel errors{"Answers given without a doubt",
                    difficulty,
                    {.label = curve.error, .logarithmic = curve.logarithmic_error, .from_zero = true},
                    {},
                    false};
  for (const auto& [verdict, series] : {std::pair{Verdict::kRight, std::string("right")},
                                        {Verdict::kWrong, "wrong without a word"},
                                        {Verdict::kSaidSo, "says so"},
                                        {Verdict::kCareful, curve.careful}}) {
    if (verdict == Verdict::kCareful && curve.careful.empty()) continue;
    for (const CurvePoint& point : measured.points)
      shares.points.push_back(
          {series, "", Spread::Exactly(point.difficulty), Spread::Exactly(100 * point.Share(verdict))});
  }
  for (const CurvePoint& point : measured.points) {
    std::vector<double> given;
    for (const Trial& trial : point.trials)
      if (std::isfinite(trial.error) && trial.verdict != Verdict::kSaidSo) given.push_back(trial.error);
    errors.points.push_back({"", "", Spread::Exactly(point.difficulty), Spread::Of(given)});
  }
  Chart chart;
  chart.name = curve.name;
  chart.title = Capital(curve.title);
  chart.about = curve.about + fmt::format(
                                  " Seeds {} (what is right was settled on 1 to 20); to the right: "
                                  "median, lowest to highest.",
                                  SeedsOf(measured));
  chart.panels = {shares, errors};
  chart.same_costs = true;
  return chart;
}

std::string StabilityPage(const std::vector<MeasuredCurve>& measured, const std::string& folder) {
  std::string page =
      "# Where methods fail\n\n"
      "`./run stability` drives every stage into the place where its method is known to fail, draws this "
      "page "
      "and its pictures, and fails where an answer is wrong without a word more often than is known; "
      "`./run stability NAME...` does some. Two points of each curve are among the everyday tests "
      "(`curve_test`). A trial is right, or careful (off, but to the side that hides nothing), or says so, "
      "or "
      "is wrong; the breaking point is the difficulty up to which nine trials in ten are right. What a "
      "tracker "
      "meets in whole sequences (darkness, jumps, mirrors, crowds) is in "
      "[tracking.md](tracking.md#where-tracking-is-hard).\n\n";
  page += fmt::format(
      "What counts as right was settled on seeds 1 to 20; everything here comes from seeds {} on, as many as "
      "the table says: few where a trial takes long.\n\n"
      "| stage | driven by | seeds | breaking point | beyond it | most wrong without a word |\n"
      "| --- | --- | --- | --- | --- | --- |\n",
      kFirstSeed);
  for (const MeasuredCurve& m : measured) {
    page += fmt::format("| {}: [{}](#{}) | {} | ", Capital(m.curve.stage), Capital(m.curve.title),
                        m.curve.name, Capital(m.curve.difficulty));
    page += m.why_not ? fmt::format("– | not measured: {} | – | – |\n", *m.why_not)
                      : fmt::format("{} | {} | {} | {} |\n", SeedsOf(m), BreakingWords(m), BeyondWords(m),
                                    WrongWords(m));
  }
  for (const MeasuredCurve& m : measured) {
    page += fmt::format("\n<a id=\"{}\"></a>\n## {}\n\n", m.curve.name, Capital(m.curve.title));
    if (!m.why_not) page += fmt::format("![{}]({}/{}.png)\n\n", Capital(m.curve.title), folder, m.curve.name);
    page += m.curve.about + "\n";
    if (!m.curve.why_wrong.empty()) page += fmt::format("\nWrong without a word: {}\n", m.curve.why_wrong);
  }
  return page;
}

std::vector<Curve> AllCurves() {
  std::vector<Curve> all;
  for (const auto& stage : {GeometryCurves, TrackingCurves, CoverageCurves, RenderCurves, AcquisitionCurves})
    for (Curve& curve : stage()) all.push_back(std::move(curve));
  return all;
}

}  // namespace ulf::test
