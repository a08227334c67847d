#include "acquisition/calibration/board_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

// Printers do not print closer to the edge, and a board needs a white border. Guessed.
constexpr double kMarginMm = 10;
constexpr double kCaptionMm = 14;                              // below the board: scale bar and text
constexpr double kTextMm = 3.2;                                // height of the letters
constexpr double kBarLineMm = 0.3;                             // thickness
constexpr double kBarMm = 50;                                  // length of the scale bar
constexpr double kTextWidthMm = 150, kLeastPageWidthMm = 170;  // room for scale bar and caption
constexpr double kPointsPerMm = 72 / 25.4;

struct PageSize {
  const char* name;
  double short_mm, long_mm;
};
constexpr PageSize kPages[] = {{"a4", 210, 297}, {"a3", 297, 420}, {"letter", 215.9, 279.4}};

// Returns the scale bar as rectangles: a line with a tick at each end whose outer edges are bar_mm apart.
std::vector<RectangleMm> ScaleBar(const SheetLayout& layout) {
  constexpr double kTickMm = 4;
  const double x = layout.bar_x_mm, y = layout.bar_y_mm;
  return {{x, y, kBarLineMm, kTickMm},
          {x + layout.bar_mm - kBarLineMm, y, kBarLineMm, kTickMm},
          {x + kBarLineMm, y + 0.5 * (kTickMm - kBarLineMm), layout.bar_mm - 2 * kBarLineMm, kBarLineMm}};
}

std::vector<RectangleMm> OnPage(const Board& board, const SheetLayout& layout) {
  std::vector<RectangleMm> all = ScaleBar(layout);
  for (RectangleMm dark : board.Dark()) {
    dark.x += layout.board_x_mm;
    dark.y += layout.board_y_mm;
    all.push_back(dark);
  }
  return all;
}

struct TextLine {
  double x_mm, y_mm;  // of the base line's start
  std::string text;
};

std::vector<TextLine> Texts(const SheetLayout& layout) {
  return {{layout.bar_x_mm + layout.bar_mm + 3, layout.bar_y_mm + 3.1,
           fmt::format("{:g} mm: measure it; print at 100 %, without fitting to the page", layout.bar_mm)},
          {layout.bar_x_mm, layout.bar_y_mm + 8.5, layout.caption}};
}

}  // namespace

SheetLayout LayOutSheet(const Board& board, const std::string& page) {
  const double width = board.WidthMm() + 2 * kMarginMm;
  const double height = board.HeightMm() + 2 * kMarginMm + kCaptionMm;
  SheetLayout layout;
  if (page == "board") {
    layout.page_width_mm = std::max(width, kLeastPageWidthMm);
    layout.page_height_mm = height;
  } else {
    const auto size =
        std::find_if(std::begin(kPages), std::end(kPages), [&](const PageSize& s) { return s.name == page; });
    if (size == std::end(kPages))
      throw Refusal(Parameter("page"), page,
                    "there are a4, a3, letter and board (as large as the board needs)", "");
    const bool upright = width <= size->short_mm && height <= size->long_mm;
    const bool lying = width <= size->long_mm && height <= size->short_mm;
    if (!upright && !lying)
      throw Refusal(fmt::format("board '{}'", board.Text()), "",
                    fmt::format("with margins it needs {:g} x {:g} mm, {} has {:g} x {:g}", width, height,
                                page, size->short_mm, size->long_mm),
                    fmt::format("use smaller squares, a larger page, or {} board", Parameter("page")));
    layout.page_width_mm = upright ? size->short_mm : size->long_mm;
    layout.page_height_mm = upright ? size->long_mm : size->short_mm;
  }
  layout.board_x_mm = 0.5 * (layout.page_width_mm - board.WidthMm());
  layout.board_y_mm = 0.5 * (layout.page_height_mm - kCaptionMm - board.HeightMm());
  layout.bar_mm = kBarMm;
  layout.bar_x_mm = std::min(layout.board_x_mm, 0.5 * (layout.page_width_mm - kTextWidthMm));
  layout.bar_y_mm = layout.board_y_mm + board.HeightMm() + 7;
  layout.caption = fmt::format("ulf calibrate --board {}", board.Text());
  return layout;
}

std::string SheetSvg(const Board& board, const SheetLayout& layout) {
  // One path for all dark areas, because separate neighbours would have hairlines between them.
  std::string path;
  for (const RectangleMm& r : OnPage(board, layout))
    fmt::format_to(std::back_inserter(path), "M{:.6g} {:.6g}h{:.6g}v{:.6g}h{:.6g}z", r.x, r.y, r.width,
                   r.height, -r.width);
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}mm\" height=\"{1:g}mm\" viewBox=\"0 0 {0:g} "
      "{1:g}\">\n"
      "<title>{2}</title>\n"
      "<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"white\"/>\n"
      "<path fill=\"black\" d=\"{3}\"/>\n",
      layout.page_width_mm, layout.page_height_mm, board.Text(), path);
  for (const TextLine& line : Texts(layout))
    fmt::format_to(std::back_inserter(svg),
                   "<text x=\"{:.6g}\" y=\"{:.6g}\" font-family=\"Helvetica, Arial, sans-serif\" "
                   "font-size=\"{:g}\">{}</text>\n",
                   line.x_mm, line.y_mm, kTextMm, line.text);
  return svg + "</svg>\n";
}

std::string SheetPdf(const Board& board, const SheetLayout& layout) {
  // PDF counts points from the lower left; the matrix changes the unit to millimetres.
  std::string content = fmt::format("{0:.9f} 0 0 {0:.9f} 0 0 cm\n0 g\n", kPointsPerMm);
  for (const RectangleMm& r : OnPage(board, layout))
    fmt::format_to(std::back_inserter(content), "{:.6f} {:.6f} {:.6f} {:.6f} re\n", r.x,
                   layout.page_height_mm - r.y - r.height, r.width, r.height);
  content += "f\n";
  for (const TextLine& line : Texts(layout))
    fmt::format_to(std::back_inserter(content), "BT /F1 {:g} Tf {:.6f} {:.6f} Td ({}) Tj ET\n", kTextMm,
                   line.x_mm, layout.page_height_mm - line.y_mm, line.text);

  const std::string objects[] = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.6f} {:.6f}] /Contents 4 0 R /Resources << "
                  "/Font << /F1 5 0 R >> >> >>",
                  layout.page_width_mm * kPointsPerMm, layout.page_height_mm * kPointsPerMm),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
  };
  std::string pdf = "%PDF-1.7\n";
  std::vector<std::size_t> offsets;
  for (const std::string& object : objects) {
    offsets.push_back(pdf.size());
    fmt::format_to(std::back_inserter(pdf), "{} 0 obj\n{}\nendobj\n", offsets.size(), object);
  }
  const std::size_t table = pdf.size();
  fmt::format_to(std::back_inserter(pdf), "xref\n0 {}\n0000000000 65535 f \n", offsets.size() + 1);
  for (const std::size_t offset : offsets)
    fmt::format_to(std::back_inserter(pdf), "{:010} 00000 n \n", offset);
  fmt::format_to(std::back_inserter(pdf), "trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n",
                 offsets.size() + 1, table);
  return pdf;
}

}  // namespace ulf::acquisition
