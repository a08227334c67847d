// A method driven into the place where it is known to fail: a difficulty that grows, and what comes of it.
//
// Every trial is right, or it says that it has no answer (or a doubtful one), or it is wrong: an answer that
// is off and was given without a word. The last is what must not be, however hard it gets. The breaking point
// is the difficulty up to which at least nine trials in ten are right.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/charts/chart.h"

namespace ulf::test {

enum class Verdict { kRight, kSaidSo, kWrong };

struct Trial {
  Verdict verdict = Verdict::kWrong;
  double error = 0;  // of the answer, in the curve's unit; not finite: there was none
};

struct Curve {
  std::string name;   // of its files
  std::string stage;  // of the program: tracking, coverage, ...
  std::string title;
  std::string about;       // the scene, what is right, what is said otherwise
  std::string difficulty;  // with its unit
  bool logarithmic = false;
  std::vector<double> values;  // the easiest first
  // Two of them for every day: where each trial is right; where none is wrong, and most say so unless the
  // method never breaks.
  double easy = 0, hard = 0;
  bool breaks = true;
  std::string error;  // of an answer, with its unit
  bool logarithmic_error = true;
  unsigned seeds = 20;
  std::function<Trial(double difficulty, unsigned seed)> trial;
  // Why this machine cannot drive it (no network of a process's own, no emulated webcam); none: it can.
  std::function<std::optional<std::string>()> why_not = [] { return std::nullopt; };
};

struct CurvePoint {
  double difficulty = 0;
  std::vector<Trial> trials;
  double Share(Verdict verdict) const;
};

struct MeasuredCurve {
  Curve curve;
  std::vector<CurvePoint> points;               // by difficulty
  std::optional<double> BreakingPoint() const;  // none: not even the easiest
  bool NeverBroke() const;                      // as far as it was driven
  double WorstShareWrong() const;
};

MeasuredCurve Measure(const Curve& curve, bool quick);
// Shares above, errors of the answers below.
Chart ChartOf(const MeasuredCurve& measured);

// The page: a table of breaking points, and every curve. `folder` is where the pictures lie, seen from it.
std::string StabilityPage(const std::vector<MeasuredCurve>& measured, const std::string& folder);

// By stage.
std::vector<Curve> GeometryCurves();     // two views, one view, bundle adjustment
std::vector<Curve> TrackingCurves();     // relocalisation
std::vector<Curve> CoverageCurves();     // the bound
std::vector<Curve> RenderCurves();       // viewpoint mesh, blending, proxies
std::vector<Curve> AcquisitionCurves();  // cameras under loss
std::vector<Curve> AllCurves();

}  // namespace ulf::test
