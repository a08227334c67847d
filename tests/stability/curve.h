// A method driven into the place where it is known to fail: a difficulty that grows, and what comes of it.
//
// Every trial is right, or careful (off to the side that hides nothing), or it says that it has no answer (or
// a doubtful one), or it is wrong: an answer that is off and was given without a word. The last is what must
// not be, however hard it gets; where it is known to happen, a curve says how often, from where on, and why.
// The breaking point is the difficulty up to which at least nine trials in ten are right.
//
// What counts as right was settled on seeds 1 to 20; what is reported comes from others.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/charts/chart.h"

namespace ulf::test {

// Of what is reported, in pictures and on the page, and every day.
inline constexpr unsigned kFirstSeed = 101;

enum class Verdict { kRight, kCareful, kSaidSo, kWrong };

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
  // Two of them for every day: where each trial is right; where none is wrong, and not each is right, unless
  // the method never breaks.
  double easy = 0, hard = 0;
  std::string never_breaks = {};  // why not, within the range; empty: it does
  // Wrong without a word is this share of the trials at most, and any from this difficulty on: known, and
  // why.
  double rarely_wrong = 0;
  std::optional<double> wrong_from = {};
  std::string why_wrong = {};
  std::string careful = {};  // what a careful answer is; empty: there is none
  std::string error;         // of an answer, with its unit
  bool logarithmic_error = true;
  unsigned seeds = 40;
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
  std::vector<CurvePoint> points;               // by difficulty; none where it could not be measured
  std::optional<std::string> why_not = {};      // it could not
  std::optional<double> BreakingPoint() const;  // none: not even the easiest
  bool NeverBroke() const;                      // as far as it was driven
  double WorstShareWrong() const;
  bool WrongAsKnown() const;  // no more than the curve says
};

// Asks first whether this machine can.
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
