// How much lens model a set of views supports: parameters against the error on views that were left out.
#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/simulator/simulated_board.h"
#include "tests/acquisition/calibration/synthetic_board_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

// All candidates, those that the rule has chosen ringed.
void Add(const std::string& panel, const CalibrationResult& result, Table& table) {
  // Several candidates are equally large.
  table.Panel(panel, {"parameters of the lens model"}, Log("error of left-out views [px RMS]"),
              {.joined = false});
  if (!result.ok()) return;
  for (const CandidateResult& candidate : result.choice.table) {
    const LensCandidate& lens = candidate.fit.candidate;
    table.Add(panel, lens.distortion == Distortion::kFisheye ? "fisheye" : "perspective", lens.name,
              lens.Parameters(), candidate.LeftOutRmsPx(),
              &candidate == &result.choice.table[result.choice.chosen]);
  }
}

Chart MeasureCalibration(const Effort& effort) {
  Table table;
  for (const char* lens : effort.Of(std::vector{"barrel"}, {"pinhole", "barrel", "wide"}))
    for (const unsigned seed : effort.Seeds(5))
      Add(fmt::format("simulated lens: {}", lens),
          CalibrateFromViews(
              Board(),
              MakeViews(
                  {.camera = SimulatedLens(lens, 640, 480), .views = 24, .noise_px = 0.1, .seed = seed}),
              640, 480),
          table);
  if (const auto folder = TestData("chessboard_webcam"); folder && !effort.quick) {
    const Board board = Board::Parse("chessboard:8x8:25");
    const CollectedViews collected = CollectViews(ImagesIn({folder->string()}), board, {});
    Add("chessboard_webcam", CalibrateFromViews(board, collected.views, collected.width, collected.height),
        table);
  }
  return {.panels = table.panels()};
}

CHART(calibration, MeasureCalibration,
      "Calibration: size of the lens model against the error of views that were left out", R"(Simulated
  lenses: 24 views of the usual board, corners 0.1 px off, five seeds; ringed is what the rule chose for
  most. chessboard_webcam: 19 photographs, poorly conditioned, one run, for reporting only. Bars: lowest to
  highest seed.)");

}  // namespace
}  // namespace ulf::test
