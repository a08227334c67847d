// Drives a method into the place where it is known to fail: a difficulty grows, and trials show what comes of
// it.
//
// Every trial is right, or careful (off, but to the side that hides nothing), or it says that it has no
// answer (or a doubtful one), or it is wrong: an answer that is off and was given without a word. A wrong
// trial must not happen, however hard it gets; where it is known to happen, a curve says how often, from
// where on, and why. The breaking point is the difficulty up to which at least nine trials in ten are right.
//
// Reported are the seeds from kFirstSeed on (effort.h).
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/measure/chart.h"
#include "tests/measure/runner.h"

namespace ulf::test {

enum class Verdict { kRight, kCareful, kSaidSo, kWrong };

struct Trial {
  Verdict verdict = Verdict::kWrong;
  double error = 0;  // of the answer, in the curve's unit; not finite: there was none
};

struct Driven {
  ChartAxis by;                // the difficulty, with its unit
  std::vector<double> values;  // the easiest first
  // Two of the values for quick runs: at `easy` each trial is right; at `hard` none is wrong, and not each is
  // right, unless the method never breaks.
  double easy = 0, hard = 0;
};

struct Curve {
  std::string stage = {};  // of the program: tracking, coverage, ...
  std::string title = {};
  std::string about = {};  // the scene, what is right, what is said otherwise
  Driven driven = {};
  ChartAxis error = {};  // of an answer, with its unit
  std::function<Trial(double difficulty, unsigned seed)> trial = {};
  unsigned seeds = 40;
  // Why the method does not break at any of the values; empty: it does. A curve that never breaks is not on
  // the page and needs no title: a test drives it through all values; nine in ten must be right everywhere.
  std::string never_breaks = {};
  // The known faults: this share of the trials at most is wrong without a word, and any share from the
  // difficulty `wrong_from` on (none: nowhere), for the reason `why_wrong`.
  double rarely_wrong = 0;
  std::optional<double> wrong_from = {};
  std::string why_wrong = {};
  std::string careful = {};  // what a careful answer is; empty: there is none
  // Why this machine cannot drive it (no network of a process's own, no emulated webcam); none: it can.
  std::function<std::optional<std::string>()> why_not = [] { return std::nullopt; };
  std::string name = {};
};

// CURVE(name, Curve{...}) makes a curve known to the program that it is linked into.
bool RegisterCurve(const char* name, const Curve& curve);
#define CURVE(name, ...) [[maybe_unused]] const bool curve_##name = RegisterCurve(#name, __VA_ARGS__)
// Returns all that are registered, by name: those of the page, and those that never break.
std::vector<Curve> AllCurves();

struct CurvePoint {
  double difficulty = 0;
  std::array<double, 4> shares = {};  // of the trials, by verdict
  Spread error = {};                  // of the answers that were given without a doubt
  double Share(Verdict verdict) const { return shares[static_cast<std::size_t>(verdict)]; }
};

struct MeasuredCurve {
  Curve curve;
  std::vector<CurvePoint> points = {};          // the easiest first; empty: it was not measured
  unsigned trials = 0;                          // at each point
  std::string caption = {};                     // of the chart it was read from
  std::optional<double> BreakingPoint() const;  // none: not even the easiest is right
  bool NeverBroke() const;                      // as far as it was driven
  double WorstShareWrong() const;
  bool WrongAsKnown() const;  // nowhere is more wrong than the curve says
};

MeasuredCurve Measure(const Curve& curve, const Effort& effort);
// ChartOf() makes a panel of shares and one of the answers' errors; FromChart() reads them back.
Chart ChartOf(const MeasuredCurve& measured);
MeasuredCurve FromChart(const Curve& curve, const Chart& chart);

// Returns the curve for RunMeasurements(), with a complaint where more is wrong without a word than is known.
Measurement MeasurementOf(const Curve& curve);

// Returns the page in Markdown: a table of breaking points, and every curve. `folder`: the pictures' folder,
// as seen from the page.
std::string StabilityPage(const std::vector<MeasuredCurve>& measured, const std::string& folder);

}  // namespace ulf::test
