// A method driven into the place where it is known to fail: a difficulty that grows, and what comes of it.
//
// Every trial is right, or careful (off to the side that hides nothing), or it says that it has no answer (or
// a doubtful one), or it is wrong: an answer that is off and was given without a word. The last is what must
// not be, however hard it gets; where it is known to happen, a curve says how often, from where on, and why.
// The breaking point is the difficulty up to which at least nine trials in ten are right.
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

// From easy to hard.
struct Driven {
  ChartAxis by;                // the difficulty, with its unit
  std::vector<double> values;  // the easiest first
  // Two of them for every day: where each trial is right; where none is wrong, and not each is right, unless
  // the method never breaks.
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
  // Why the method does not break at any of the values. Then it is no curve of the page, and needs no title:
  // a test drives it through all of them, and nine in ten must be right everywhere.
  std::string never_breaks = {};
  // Wrong without a word is this share of the trials at most, and any from this difficulty on: known, and
  // why.
  double rarely_wrong = 0;
  std::optional<double> wrong_from = {};
  std::string why_wrong = {};
  std::string careful = {};  // what a careful answer is; empty: there is none
  // Why this machine cannot drive it (no network of a process's own, no emulated webcam); none: it can.
  std::function<std::optional<std::string>()> why_not = [] { return std::nullopt; };
  std::string name = {};
};

// In CURVE(name, Curve{...}): known to the program that it is linked into.
bool RegisterCurve(const char* name, const Curve& curve);
#define CURVE(name, ...) [[maybe_unused]] const bool curve_##name = RegisterCurve(#name, __VA_ARGS__)
// All that are registered, by name: those of the page, and those that never break.
std::vector<Curve> AllCurves();

struct CurvePoint {
  double difficulty = 0;
  std::array<double, 4> shares = {};  // of the trials, by verdict
  Spread error = {};                  // of the answers that were given without a doubt
  double Share(Verdict verdict) const { return shares[static_cast<std::size_t>(verdict)]; }
};

struct MeasuredCurve {
  Curve curve;
  std::vector<CurvePoint> points = {};          // by difficulty; none where it was not measured
  unsigned trials = 0;                          // at each
  std::string caption = {};                     // of the chart it was read from
  std::optional<double> BreakingPoint() const;  // none: not even the easiest
  bool NeverBroke() const;                      // as far as it was driven
  double WorstShareWrong() const;
  bool WrongAsKnown() const;  // no more than the curve says
};

MeasuredCurve Measure(const Curve& curve, const Effort& effort);
// Shares above, errors of the answers below; and back.
Chart ChartOf(const MeasuredCurve& measured);
MeasuredCurve FromChart(const Curve& curve, const Chart& chart);

// For RunMeasurements(): a complaint where more is wrong without a word than is known.
Measurement MeasurementOf(const Curve& curve);

// The page: a table of breaking points, and every curve. `folder` is where the pictures lie, seen from it.
std::string StabilityPage(const std::vector<MeasuredCurve>& measured, const std::string& folder);

}  // namespace ulf::test
