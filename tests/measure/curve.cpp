#include "tests/measure/curve.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>

#include "tests/measure/provenance.h"

namespace ulf::test {
namespace {

constexpr double kMostlyRight = 0.9;
constexpr char kShares[] = "What comes of it";
constexpr char kHead[] =
    R"(`./run measure stability` drives every stage into the place where its method is known to fail, and
  fails where an answer is wrong without a word more often than is known. A trial is right, or careful (off,
  but to the side that hides nothing), or says so, or is wrong; the breaking point is the difficulty up to
  which nine trials in ten are right. What counts as right was settled on seeds 1 to 20; these are from 101
  on. What does not break is a test (`curves_test`), in full in the long run. What a tracker meets in whole
  sequences is in [tracking.md](tracking.md#where-tracking-is-hard).)";

std::map<std::string, Curve>& Registry() {
  static std::map<std::string, Curve> registry;
  return registry;
}

std::string Percent(double share) { return fmt::format("{:.0f} %", 100 * share); }

std::string Capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::vector<std::pair<Verdict, std::string>> VerdictsOf(const Curve& curve) {
  std::vector<std::pair<Verdict, std::string>> verdicts{
      {Verdict::kRight, "right"}, {Verdict::kWrong, "wrong without a word"}, {Verdict::kSaidSo, "says so"}};
  if (!curve.careful.empty()) verdicts.emplace_back(Verdict::kCareful, curve.careful);
  return verdicts;
}

bool HarderIsLess(const Curve& curve) { return curve.driven.values.back() < curve.driven.values.front(); }

// Columns of the table, in words.
std::string BreakingWords(const MeasuredCurve& measured) {
  if (measured.NeverBroke()) return fmt::format("none up to {:g}", measured.points.back().difficulty);
  const auto broke = measured.BreakingPoint();
  return broke ? fmt::format("{:g}", *broke) : "none is easy enough";
}

std::string BeyondWords(const MeasuredCurve& measured) {
  const CurvePoint& last = measured.points.back();
  std::string words;
  for (const auto& [verdict, what] : {std::pair{Verdict::kRight, std::string("right")},
                                      {Verdict::kCareful, measured.curve.careful},
                                      {Verdict::kSaidSo, "say so"},
                                      {Verdict::kWrong, "wrong"}})
    if (last.Share(verdict) > 0)
      words += fmt::format("{}{} {}", words.empty() ? "" : ", ", Percent(last.Share(verdict)), what);
  return fmt::format("at {:g}: {}", last.difficulty, words);
}

std::string WrongWords(const MeasuredCurve& measured) {
  const auto worst = std::ranges::max_element(
      measured.points, {}, [](const CurvePoint& point) { return point.Share(Verdict::kWrong); });
  if (worst->Share(Verdict::kWrong) == 0) return "none";
  return fmt::format("{:.0f}, at {:g}", worst->Share(Verdict::kWrong) * measured.trials, worst->difficulty);
}

}  // namespace

bool RegisterCurve(const char* name, const Curve& curve) {
  Registry()[name] = curve;
  Registry()[name].name = name;
  for (std::string Curve::*text : {&Curve::about, &Curve::why_wrong})
    Registry()[name].*text = OneLine(Registry()[name].*text);
  return true;
}

std::vector<Curve> AllCurves() {
  std::vector<Curve> all;
  for (const auto& [name, curve] : Registry()) all.push_back(curve);
  return all;
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
  return std::ranges::all_of(points, [&](const CurvePoint& point) {
    const bool known = curve.wrong_from && (HarderIsLess(curve) ? point.difficulty <= *curve.wrong_from
                                                                : point.difficulty >= *curve.wrong_from);
    return known || point.Share(Verdict::kWrong) <= curve.rarely_wrong;
  });
}

MeasuredCurve Measure(const Curve& curve, const Effort& effort) {
  const unsigned seeds = effort.Of(std::min(curve.seeds, 3u), curve.seeds);
  MeasuredCurve measured{.curve = curve, .trials = seeds};
  for (const double difficulty : effort.Of({curve.driven.easy, curve.driven.hard}, curve.driven.values)) {
    CurvePoint point{difficulty};
    std::vector<double> given;
    for (unsigned seed = kFirstSeed; seed < kFirstSeed + seeds; ++seed) {
      const Trial trial = curve.trial(difficulty, seed);
      point.shares[static_cast<std::size_t>(trial.verdict)] += 1;
      if (std::isfinite(trial.error) && trial.verdict != Verdict::kSaidSo) given.push_back(trial.error);
    }
    for (double& share : point.shares) share /= seeds;
    point.error = Spread::Of(given);
    measured.points.push_back(point);
  }
  return measured;
}

Chart ChartOf(const MeasuredCurve& measured) {
  const Curve& curve = measured.curve;
  ChartAxis difficulty = curve.driven.by;
  difficulty.falls = HarderIsLess(curve);  // harder is to the right
  ChartPanel shares{
      .title = kShares, .cost = difficulty, .error = {"share of the trials [%]"}, .compared = false};
  ChartPanel errors{.title = "Answers given without a doubt",
                    .cost = difficulty,
                    .error = FromZero(curve.error),
                    .compared = false};
  for (const auto& [verdict, series] : VerdictsOf(curve))
    for (const CurvePoint& point : measured.points)
      shares.points.push_back(
          {series, "", Spread::Exactly(point.difficulty), Spread::Exactly(100 * point.Share(verdict))});
  for (const CurvePoint& point : measured.points)
    errors.points.push_back({"", "", Spread::Exactly(point.difficulty), point.error});
  return {.name = curve.name,
          .title = Capital(curve.title),
          .about = curve.about,
          .found = fmt::format("Seeds {} to {}; to the right: median, lowest to highest.", kFirstSeed,
                               kFirstSeed + measured.trials - 1),
          .panels = {shares, errors},
          .same_costs = true};
}

MeasuredCurve FromChart(const Curve& curve, const Chart& chart) {
  MeasuredCurve measured{.curve = curve, .trials = curve.seeds, .caption = chart.caption};
  for (const ChartRow& row : chart.panels.at(1).points)
    measured.points.push_back({.difficulty = row.cost.median, .error = row.error});
  for (const auto& [verdict, series] : VerdictsOf(curve))
    for (CurvePoint& point : measured.points)
      for (const ChartRow& row : chart.panels.front().points)
        if (row.series == series && row.cost.median == point.difficulty)
          point.shares[static_cast<std::size_t>(verdict)] = row.error.median / 100;
  return measured;
}

Measurement MeasurementOf(const Curve& curve) {
  const auto measure = [curve](const Effort& effort) {
    if (const auto why_not = curve.why_not()) throw NotHere(*why_not);
    const MeasuredCurve measured = Measure(curve, effort);
    fmt::print("{}: breaking point {}, by {}, wrong at most {}\n", curve.name, BreakingWords(measured),
               curve.driven.by.label, Percent(measured.WorstShareWrong()));
    return ChartOf(measured);
  };
  const auto complaint = [curve](const Chart& chart) -> std::string {
    if (FromChart(curve, chart).WrongAsKnown()) return "";
    return "more answers are wrong without a word than is known";
  };
  return {.measure = measure,
          .title = Capital(curve.title),
          .about = curve.about,
          .complaint = complaint,
          .name = curve.name};
}

std::string StabilityPage(const std::vector<MeasuredCurve>& measured, const std::string& folder) {
  std::string page = std::string("# Where methods fail\n\n") + OneLine(kHead) +
                     "\n\n| stage | driven by | trials | breaking point | beyond it | most wrong without a "
                     "word |\n| --- | --- | --- | --- | --- | --- |\n";
  std::vector<std::string> makers;
  for (const MeasuredCurve& m : measured) {
    page += fmt::format("| {}: [{}](#{}) | {} | ", Capital(m.curve.stage), Capital(m.curve.title),
                        m.curve.name, Capital(m.curve.driven.by.label));
    page += m.points.empty() ? "– | not measured | – | – |\n"
                             : fmt::format("{} | {} | {} | {} |\n", m.trials, BreakingWords(m),
                                           BeyondWords(m), WrongWords(m));
    const std::string made_by = WithoutCommand(m.caption);
    if (!made_by.empty() && std::ranges::find(makers, made_by) == makers.end()) makers.push_back(made_by);
  }
  page += fmt::format("\nMeasured: {}.\n", fmt::join(makers, "; "));
  for (const MeasuredCurve& m : measured) {
    page += fmt::format("\n<a id=\"{}\"></a>\n## {}\n\n", m.curve.name, Capital(m.curve.title));
    if (!m.points.empty()) page += fmt::format("![Curves]({}/{}.png)\n\n", folder, m.curve.name);
    page += m.curve.about + "\n";
    if (!m.curve.why_wrong.empty()) page += fmt::format("\nWrong without a word: {}\n", m.curve.why_wrong);
  }
  return page;
}

}  // namespace ulf::test
