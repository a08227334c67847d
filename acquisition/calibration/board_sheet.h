// Draws a calibration target for printing in true size, as SVG or PDF.
//
// One millimetre of the board is one millimetre on the page. Printer drivers often scale ("fit to page");
// therefore a scale bar, to be checked with a ruler, is printed below the board, with the text for `ulf
// calibrate --board`. Places count from the upper left corner of the page.
#pragma once

#include <string>

#include "core/fiducials/board.h"

namespace ulf::acquisition {

struct SheetLayout {
  double page_width_mm = 0, page_height_mm = 0;
  double board_x_mm = 0, board_y_mm = 0;            // the board's upper left corner
  double bar_x_mm = 0, bar_y_mm = 0, bar_mm = 100;  // the bar's upper left corner and its length
  std::string caption;
};

// Places the board on a page: "a4", "a3", "letter" (portrait or landscape, as the board fits) or "board" (as
// large as the board needs). Throws Refusal for another name or a page that is too small.
SheetLayout LayOutSheet(const Board& board, const std::string& page);

std::string SheetSvg(const Board& board, const SheetLayout& layout);
std::string SheetPdf(const Board& board, const SheetLayout& layout);

}  // namespace ulf::acquisition
