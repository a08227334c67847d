// A calibration target on paper, in true size: SVG and PDF, both of them vector graphics.
//
// One millimetre of the board is one millimetre of the page, whatever the printer's resolution; printers'
// "fit to page" is the enemy, so a scale bar to be measured with a ruler is printed under the board, and the
// board's text, which `ulf calibrate --board` takes.
#pragma once

#include <string>

#include "core/fiducials/board.h"

namespace ulf::acquisition {

struct SheetLayout {
  double page_width_mm = 0, page_height_mm = 0;
  double board_x_mm = 0, board_y_mm = 0;  // of the board's upper left corner on the page
  double bar_x_mm = 0, bar_y_mm = 0, bar_mm = 100;
  std::string caption;
};

// `page`: "a4", "a3", "letter" (upright or lying, as the board fits) or "board" (as large as the board
// needs). Throws UsageError where the board does not fit, with the size it needs.
SheetLayout LayOutSheet(const Board& board, const std::string& page);

std::string SheetSvg(const Board& board, const SheetLayout& layout);
std::string SheetPdf(const Board& board, const SheetLayout& layout);

}  // namespace ulf::acquisition
