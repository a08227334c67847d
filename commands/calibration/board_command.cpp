// `ulf board`: draws a calibration target for printing.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquisition/calibration/board_sheet.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "core/base/atomic_file.h"
#include "core/base/output_path.h"

namespace ulf::commands {
namespace {

struct BoardArgs {
  std::string board = Board().Text();
  std::string page = "a4";
  std::vector<std::string> outputs = {"board.pdf"};
  bool json = false;
};

int RunBoard(const BoardArgs& args) {
  const Board board = Board::Parse(args.board);
  const acquisition::SheetLayout layout = acquisition::LayOutSheet(board, args.page);
  std::vector<std::string> sheets;
  for (const std::string& output : args.outputs) {
    const std::string extension = std::filesystem::path(output).extension();
    if (extension != ".pdf" && extension != ".svg")
      throw UsageError("-o {}: a board is written as .pdf or .svg", output);
    RequireWritable(output);
    sheets.push_back(extension == ".pdf" ? acquisition::SheetPdf(board, layout)
                                         : acquisition::SheetSvg(board, layout));
    RequireUnused(output, sheets.back());
  }
  for (std::size_t i = 0; i < sheets.size(); ++i) WriteFileAtomically(args.outputs[i], sheets[i]);
  if (args.json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"board", board.Text()},
                                              {"files", args.outputs},
                                              {"board_mm", {board.WidthMm(), board.HeightMm()}},
                                              {"page_mm", {layout.page_width_mm, layout.page_height_mm}},
                                              {"points", board.Points().size()}}
                           .dump(2));
    return kOk;
  }
  for (const std::string& output : args.outputs)
    fmt::print("{}: {} on {:g} x {:g} mm\n", output, board.Text(), layout.page_width_mm,
               layout.page_height_mm);
  fmt::print(
      "Print at 100 % and measure the scale bar ({:g} mm). Fix the sheet to something flat and stiff. Then:\n"
      "  ulf calibrate CAMERA --board {}\n",
      layout.bar_mm, board.Text());
  return kOk;
}

}  // namespace

void AddBoardCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] =
      NewSubcommand(app, chosen, "board", "Write a calibration target to print, in true size", RunBoard);
  command
      ->add_option(
          "BOARD", args->board,
          "charuco:7x5:30:22:DICT_5X5_100 (squares, square mm, marker mm, dictionary), "
          "aruco:4x5:37.5:5:DICT_6X6_1000 (markers, marker mm, gap mm, dictionary), aprilgrid:6x6:30:9 "
          "(Kalibr's: tags, tag mm, gap mm) or chessboard:8x6:25 (squares, square mm)")
      ->capture_default_str();
  command
      ->add_option("--page", args->page,
                   "Size of the page: a4, a3, letter, or board (the size that the board needs)")
      ->capture_default_str();
  command->add_option("-o,--output", args->outputs, "File to write, .pdf or .svg; may be repeated")
      ->capture_default_str();
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf board -o board.pdf\nThen:    ulf calibrate aravis:192.168.1.20");
}

}  // namespace ulf::commands
