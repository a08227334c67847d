#include "coverage/session/watch/light_watch.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

// Logarithms of the light. Settled on simulated scenes (docs/capture.md#mistakes).
constexpr std::size_t kLightFewest = 20;  // points of a pair of pictures; fewer say nothing
// Median of their deviations; more, but in bands, is another scene, a hand before the lens, or a motion too
// quick to be followed, under which the median leans to one side.
constexpr double kLightMostDeviation = 0.05;
constexpr double kLightApart_s = 2, kLightMean_s = 0.4;  // two means so far apart are compared
constexpr double kLightLeastChange = 0.12;               // an eighth
constexpr double kLightFlicker_s = 2.5;                  // of pictures that a frequency is looked for in
constexpr double kLightLeastFlicker = 0.02;              // amplitude
// Share of the quick changes that the strongest frequency explains.
constexpr double kLightOneFrequency = 0.7;
constexpr double kLightExplainedByBands = 0.5;  // share of the points' deviations

// Numbers of bands over the picture's height that are looked for. Fewer look like the shade of something.
constexpr double kFewestBands = 0.8, kMostBands = 10, kBandStep = 0.1;
constexpr int kBandNumbers = static_cast<int>((kMostBands - kFewestBands) / kBandStep) + 1;

double BandsOf(int index) { return kFewestBands + kBandStep * index; }

struct Deviation {
  double height, value;  // share of the picture's height
};

// Returns by how much a wave with so many periods over the height brings down the sum of squares.
double ExplainedByWave(const std::vector<Deviation>& deviations, double periods) {
  double cc = 0, cs = 0, ss = 0, cv = 0, sv = 0, c1 = 0, s1 = 0, v1 = 0;
  for (const Deviation& d : deviations) {
    const double c = std::cos(2 * M_PI * periods * d.height), s = std::sin(2 * M_PI * periods * d.height);
    cc += c * c, cs += c * s, ss += s * s, cv += c * d.value, sv += s * d.value;
    c1 += c, s1 += s, v1 += d.value;
  }
  const auto n = static_cast<double>(deviations.size());
  cc -= c1 * c1 / n, cs -= c1 * s1 / n, ss -= s1 * s1 / n, cv -= c1 * v1 / n, sv -= s1 * v1 / n;
  const double determinant = cc * ss - cs * cs;
  if (determinant < 1e-3 * cc * ss) return 0;  // the points stand in too few rows
  return (ss * cv * cv - 2 * cs * cv * sv + cc * sv * sv) / determinant;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

const LightFinding& LightWatch::Update(const PicturePair& pair, double told) {
  std::vector<double> changes;
  for (const PictureTrack& track : pair.tracks)
    if (track.log_light) changes.push_back(*track.log_light);
  const double change = Median(changes);
  std::vector<double> off;
  for (const double value : changes) off.push_back(std::abs(value - change));
  if (changes.size() < kLightFewest) {
    moments_.clear();
    return finding_;
  }
  Moment now{.time_s = pair.now_s, .log_light = 0, .explained = {}};
  constexpr double kFarOff = 1;  // a point that was lost
  std::vector<Deviation> deviations;
  for (const PictureTrack& track : pair.tracks)
    if (track.log_light && std::abs(*track.log_light - change) < kFarOff)
      deviations.push_back(
          {track.now.y / static_cast<double>(pair.log_light.rows), *track.log_light - change});
  double mean = 0;
  for (const Deviation& d : deviations) mean += d.value / static_cast<double>(deviations.size());
  for (const Deviation& d : deviations) now.deviations += (d.value - mean) * (d.value - mean);
  now.points = deviations.size();
  for (int i = 0; i < kBandNumbers; ++i)
    now.explained.push_back(static_cast<float>(ExplainedByWave(deviations, BandsOf(i))));
  const bool is_in_bands = std::ranges::max(now.explained) > kLightExplainedByBands * now.deviations;
  if (Median(off) > kLightMostDeviation && !is_in_bands) {
    moments_.clear();
    return finding_;
  }
  if (moments_.empty() || moments_.back().time_s != pair.before_s) {
    moments_.clear();
    moments_.push_back({.time_s = pair.before_s, .log_light = 0, .explained = {}});
  }
  // In bands the points' median says which rows they stand in.
  now.log_light = moments_.back().log_light + (is_in_bands ? 0 : change - told);
  moments_.push_back(std::move(now));
  while (moments_.back().time_s - moments_.front().time_s >
         std::max(kLightApart_s + kLightMean_s, kLightFlicker_s))
    moments_.pop_front();
  LookForChange();
  LookForFlicker();
  LookForBands();
  return finding_;
}

void LightWatch::LookForChange() {
  const double now_s = moments_.back().time_s;
  if (now_s - moments_.front().time_s < kLightApart_s) return;
  std::vector<double> before, now;
  for (const Moment& moment : moments_) {
    const double ago_s = now_s - moment.time_s;
    if (ago_s <= kLightMean_s) now.push_back(moment.log_light);
    if (ago_s >= kLightApart_s) before.push_back(moment.log_light);
  }
  const auto [low_before, high_before] = std::ranges::minmax(before);
  const auto [low_now, high_now] = std::ranges::minmax(now);
  const double change = Mean(now) - Mean(before);
  // What flickers changes as much at once, and another picture, or a hand before the lens, in very few steps.
  if (std::abs(change) < std::max(high_before - low_before, high_now - low_now)) return;
  std::vector<double> steps;
  for (std::size_t i = 1; i < moments_.size(); ++i)
    steps.push_back(moments_[i].log_light - moments_[i - 1].log_light);
  constexpr std::size_t kFew = 3;
  std::ranges::sort(steps, std::greater{}, [](double step) { return std::abs(step); });
  double others = 0;
  for (std::size_t i = kFew; i < steps.size(); ++i) others += steps[i];
  if (std::abs(others) < 0.5 * std::abs(change)) return;
  if (std::abs(change) < kLightLeastChange) return;
  finding_.changed_s = now_s;
  if (std::abs(change) >= std::abs(finding_.changed.value_or(0))) finding_.changed = change;
}

// Looks at light against the mean of its neighbours in time: slow changes are gone, and an amplitude a at a
// frequency f is a (1 - cos(2 pi f / frames a second)).
void LightWatch::LookForFlicker() {
  constexpr std::size_t kFewest = 24;
  const double span_s = moments_.back().time_s - moments_.front().time_s;
  if (moments_.size() < kFewest || span_s < 0.8 * kLightFlicker_s) return;
  const double period_s = span_s / static_cast<double>(moments_.size() - 1);
  std::vector<double> quick;
  double power = 0;
  for (std::size_t i = 1; i + 1 < moments_.size(); ++i) {
    quick.push_back(moments_[i].log_light - 0.5 * (moments_[i - 1].log_light + moments_[i + 1].log_light));
    power += quick.back() * quick.back();
  }
  const double step = std::abs(moments_.back().log_light - moments_.front().log_light) /
                      static_cast<double>(moments_.size() - 1);
  const double n = static_cast<double>(quick.size());
  // Frequencies in cycles from one picture to the next. Slower ones are no flicker to the eye, nor to this
  // measure.
  constexpr double kSlowest = 0.08, kStep = 0.01;
  double best = 0, best_cycles = 0;
  for (double cycles = kSlowest; cycles <= 0.5 + 1e-9; cycles += kStep) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < quick.size(); ++i)
      sum += quick[i] *
             std::polar(1.0, -2 * M_PI * cycles * (moments_[i + 1].time_s - moments_[1].time_s) / period_s);
    const double explained = (cycles > 0.5 - 0.5 / n ? 1 : 2) * std::norm(sum) / n;
    if (explained > best) best = explained, best_cycles = cycles;
  }
  if (!(best > 0) || best < kLightOneFrequency * power) return;
  const double amplitude = std::sqrt(2 * best / n) / (1 - std::cos(2 * M_PI * best_cycles));
  // An automatic that follows every second picture goes in steps of its own.
  if (amplitude < std::max(kLightLeastFlicker, step)) return;
  finding_.flickered_s = moments_.back().time_s;
  finding_.flickers = std::max(amplitude, finding_.flickers.value_or(0));
}

void LightWatch::LookForBands() {
  if (moments_.back().time_s - moments_.front().time_s < 0.8 * kLightFlicker_s) return;
  double deviations = 0, points = 0;
  std::vector<double> explained(kBandNumbers);
  for (const Moment& moment : moments_) {
    if (moment.explained.empty()) continue;
    deviations += moment.deviations;
    points += static_cast<double>(moment.points);
    for (int i = 0; i < kBandNumbers; ++i)
      explained[static_cast<std::size_t>(i)] += moment.explained[static_cast<std::size_t>(i)];
  }
  const auto best = std::ranges::max_element(explained);
  if (!(points > 0) || *best < kLightExplainedByBands * deviations) return;
  // From picture to picture light changes by up to twice the lamp's amplitude.
  const double amplitude = 0.5 * std::sqrt(2 * *best / points);
  if (amplitude < kLightLeastFlicker) return;
  finding_.flickered_s = moments_.back().time_s;
  if (amplitude < finding_.flickers.value_or(0)) return;
  finding_.flickers = amplitude;
  finding_.bands = BandsOf(static_cast<int>(best - explained.begin()));
}

}  // namespace ulf::coverage
