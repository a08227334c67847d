// How much lens model a set of views supports: parameters against the error on views that were left out.
#include <cmath>
#include <map>

#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/simulator/simulated_board.h"
#include "tests/acquisition/calibration/synthetic_board_views.h"
#include "tests/charts/makers.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

// All candidates' errors by seed, and how often each was chosen.
class Candidates {
 public:
  void Add(const CalibrationResult& result) {
    if (!result.ok()) return;
    for (std::size_t i = 0; i < result.choice.table.size(); ++i) {
      const CandidateResult& candidate = result.choice.table[i];
      Entry& entry = entries_[candidate.fit.candidate.name];
      entry.lens = candidate.fit.candidate;
      entry.left_out_px.push_back(candidate.LeftOutRmsPx());
      entry.chosen += i == result.choice.chosen;
    }
  }
  ChartPanel Panel(const std::string& title) const {
    ChartPanel panel{title, {"parameters of the lens model"}, {"error of left-out views [px RMS]", true}, {}};
    panel.joined = false;  // several candidates are equally large
    int most = 1;
    for (const auto& [name, entry] : entries_) most = std::max(most, entry.chosen);
    for (const bool fisheye : {false, true})
      for (const LensCandidate& lens : LensCandidates()) {
        const auto found = entries_.find(lens.name);
        if (found == entries_.end() || (lens.distortion == Distortion::kFisheye) != fisheye) continue;
        panel.points.push_back({fisheye ? "fisheye" : "perspective", lens.name,
                                Spread::Exactly(lens.Parameters()), Spread::Of(found->second.left_out_px),
                                found->second.chosen == most});
      }
    return panel;
  }

 private:
  struct Entry {
    LensCandidate lens = {};
    std::vector<double> left_out_px;
    int chosen = 0;
  };
  std::map<std::string, Entry> entries_;
};

}  // namespace

Chart CalibrationChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "Calibration: size of the lens model against the error of views that were left out";
  chart.about =
      "Simulated lenses: 24 views of the usual board, corners 0.1 px off, seeds 11 to 15 (the rule was made "
      "with seeds 1 and 2); ringed is what the rule chose most often. chessboard_webcam: 19 photographs, "
      "poorly conditioned, one run, for reporting only. Bars: lowest to highest seed.";
  for (const char* lens : effort.Of(std::vector{"barrel"}, {"pinhole", "barrel", "wide"})) {
    Candidates candidates;
    for (const unsigned seed : effort.Of(std::vector{11u}, {11u, 12u, 13u, 14u, 15u})) {
      const SyntheticBoardViews spec{
          .camera = SimulatedLens(lens, 640, 480), .views = 24, .noise_px = 0.1, .seed = seed};
      candidates.Add(CalibrateFromViews(Board(), MakeViews(spec), 640, 480));
    }
    chart.panels.push_back(candidates.Panel(fmt::format("simulated lens: {}", lens)));
  }
  if (const auto folder = TestData("chessboard_webcam"); folder && !effort.quick) {
    const Board board = Board::Parse("chessboard:8x8:25");
    const CollectedViews collected = CollectViews(ImagesIn({folder->string()}), board, {});
    Candidates candidates;
    candidates.Add(CalibrateFromViews(board, collected.views, collected.width, collected.height));
    chart.panels.push_back(candidates.Panel("chessboard_webcam"));
  }
  return chart;
}

}  // namespace ulf::test
