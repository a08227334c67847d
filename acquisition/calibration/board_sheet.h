// Draws a calibration target for printing in true size, as SVG or PDF.
//
// One millimetre of the board is one millimetre on the page. Printer drivers often scale ("fit to page");
// therefore a scale bar, to be checked with a ruler, is printed below the board, with the text for `ulf
// calibrate --board`.
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

// `page`: "a4", "a3", "letter" (portrait or landscape, as the board fits) or "board" (the size that the board
// needs). Throws Refusal, with the size that the board needs, when it does not fit.
SheetLayout LayOutSheet(const Board& board, const std::string& page);

std::string SheetSvg(const Board& board, const SheetLayout& layout);
std::string SheetPdf(const Board& board, const SheetLayout& layout);

}  // namespace ulf::acquisition
