// Runs `ulf calibrate` with a board: views, lens, report.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "acquisition/calibration/calibrate.h"
#include "acquisition/calibration/calibration_picture.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/calibration/other_board.h"
#include "commands/calibration/calibrate_source.h"
#include "commands/calibration/calibration_report.h"
#include "commands/calibration/guide_picture.h"
#include "commands/options/subcommands.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/base/stop_signal.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/png_picture.h"
#include "core/image/image.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

void WriteBoardReport(const fs::path& folder, const acquisition::CalibrationResult& result,
                      const acquisition::CollectedViews& collected, const std::string& text) {
  WriteFileAtomically(folder / "report.txt", text + CandidateTable(result.choice));
  WriteFileAtomically(folder / "report.json", ReportJson(result).dump(2) + "\n");
  if (result.ok())
    WriteFileAtomically(folder / "residuals.png", PngBytes(acquisition::DrawCalibration(result)));
  // Stores the frames of a device, so that the calibration can be repeated from the folder.
  if (!collected.pictures.empty()) fs::create_directories(folder / "frames");
  for (std::size_t i = 0; i < collected.pictures.size(); ++i)
    WriteFileAtomically(folder / "frames" / fmt::format("{:04}.png", i + 1), PngBytes(collected.pictures[i]));
}

void WarnOfNoSerial(const CalibrationSource& source, std::vector<std::string>& warnings) {
  if (source.device && source.identity.serial.empty() && !source.identity.model.empty())
    warnings.push_back(fmt::format(
        "the camera has no serial: the calibration is bound to model '{}' at {}, and also applies to any "
        "other camera of this model there",
        source.identity.model, source.identity.bus.empty() ? "an unknown place" : source.identity.bus));
}

// A device with an end (a recording) may deliver too few frames.
void WarnOfEarlyEnd(acquisition::ViewsEnd end, std::vector<std::string>& warnings) {
  using acquisition::ViewsEnd;
  if (end != ViewsEnd::kStopped && end != ViewsEnd::kNoPhotograph) return;
  warnings.push_back(fmt::format("ended before the views were complete: {}",
                                 end == ViewsEnd::kStopped ? "stopped" : "a photograph did not arrive"));
}

// Returns some of the pictures with and without the board, evenly chosen, grey.
std::vector<cv::Mat> SomePictures(const CalibrationSource& source,
                                  const acquisition::CollectedViews& collected) {
  constexpr std::size_t kFew = 12;  // pictures suffice to recognise the board
  std::vector<cv::Mat> taken = collected.pictures;
  taken.insert(taken.end(), collected.unseen.begin(), collected.unseen.end());
  const std::size_t all = source.device ? taken.size() : source.files.size();
  std::vector<cv::Mat> some;
  for (std::size_t i = 0; i < std::min(kFew, all); ++i) {
    const std::size_t at = all <= kFew ? i : i * (all - 1) / (kFew - 1);
    some.push_back(source.device ? taken[at]
                                 : GrayForTracking({ReadImageFile(source.files[at]), Transfer::kSrgb}));
  }
  return some;
}

// Warns if the corners fit another board. Returns whether the result is refused for it.
bool RefuseOtherBoard(const Board& said, const CalibrationSource& source,
                      const acquisition::CollectedViews& collected, acquisition::CalibrationResult& result) {
  // Pixels: right boards give less than the first; above the second, wrong lengths spoil the result. Guessed.
  constexpr double kSuspiciousPx = 0.25, kSpoiltPx = 1;
  const std::vector<cv::Mat> pictures = SomePictures(source, collected);
  // The error alone is no evidence: corners that contradict most of the others were left out before.
  if (result.ok() && result.rms_px < kSuspiciousPx && !acquisition::MarkersContradict(said, pictures))
    return false;
  const auto other = acquisition::BoardInPictures(said, pictures);
  if (!other) return false;
  const std::string text = acquisition::DescribeOtherBoard(said, *other);
  if (result.ok() && other->other_lengths_only && result.rms_px < kSpoiltPx) {
    result.warnings.insert(result.warnings.begin(), text);
    return false;
  }
  result.refusal = text;
  return true;
}

}  // namespace

int RunBoardCalibration(const CalibrateArgs& args) {
  const Board board = Board::Parse(args.board);
  CalibrationSource source = OpenCalibrationSource(args);
  const std::string output = CalibrationOutput(args, source);
  RequireReportFolder(args);
  const StopOnSignal stop_on_signal;
  acquisition::CollectedViews collected;
  {
    Progress progress(source.device ? "calibrating" : "searching for the board", args.json);
    acquisition::CalibrationCaptureOptions options = CaptureOptions(args, progress);
    ShowGuide(args, source.device != nullptr, progress, options);
    collected = source.device ? acquisition::CollectViews(*source.device, board, options)
                              : acquisition::CollectViews(source.files, board, options);
  }
  acquisition::CalibrationResult result =
      acquisition::CalibrateFromViews(board, collected.views, collected.width, collected.height);
  const bool other_board = RefuseOtherBoard(board, source, collected, result);
  const bool only_moves = !other_board && collected.views.empty() && collected.moving > 0;
  if (only_moves)
    result.refusal = fmt::format(
        "the board {} was seen in {}, and moved in all of them: hold it still for a moment at each place, or "
        "give single frames as pictures (ulf calibrate FOLDER)",
        board.Text(), Counted(collected.moving, "picture"));
  if (result.ok()) WarnOfNoSerial(source, result.warnings);
  if (result.ok()) WarnOfEarlyEnd(collected.end, result.warnings);
  const std::string text =
      result.ok() ? ReportText(result, source.truth) : "refused: " + result.refusal + "\n";
  if (!args.report.empty()) WriteBoardReport(args.report, result, collected, text);
  if (result.ok())
    acquisition::UpdateCalibration(output, source.identity,
                                   fmt::format("ulf calibrate {}, {}", source.name, board.Text()), args.mode,
                                   {.camera = result.camera,
                                    .window = source.window,
                                    .sigma = result.sigma,
                                    .rms_px = result.rms_px,
                                    .flat_field = {},
                                    .color_profile = {}});
  if (args.json) {
    Json json = ReportJson(result);
    json["file"] = result.ok() ? output : "";
    if (source.truth && result.ok())
      json["differs_from_truth_px"] = LargestDifferencePx(*source.truth, result.camera);
    fmt::print("{}\n", json.dump(2));
  }
  if (!result.ok())
    throw Error("no calibration: {}{}", other_board || only_moves ? "" : source.RetakeAdvice(),
                result.refusal);
  if (args.json) return kOk;
  fmt::print("{}", text);
  if (args.explain) fmt::print("\n{}", CandidateTable(result.choice));
  fmt::print("\n{}: written, mode {}\n", output, args.mode);
  if (source.identity.serial.empty() && source.identity.model.empty())
    fmt::print(
        "not bound to any camera: ulf calibration {} --serial SERIAL -o FILE does so ('ulf devices')\n",
        ShellWord(output));
  else if (args.output.empty())
    fmt::print("commands that use this camera find this file automatically\n");
  return kOk;
}

}  // namespace ulf::commands
