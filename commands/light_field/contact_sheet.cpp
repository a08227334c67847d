#include "commands/light_field/contact_sheet.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace ulf::commands {
namespace {

const cv::Scalar kPaper(250, 250, 250), kMat(232, 232, 232), kInk(40, 40, 40);
constexpr int kMargin = 16, kCaptionHeight = 30, kHeadlineHeight = 44;

void WriteText(cv::Mat& sheet, const std::string& text, cv::Point baseline, double scale, int max_width) {
  constexpr int kFont = cv::FONT_HERSHEY_DUPLEX;
  const int width = cv::getTextSize(text, kFont, scale, 1, nullptr).width;
  if (width > max_width) scale *= static_cast<double>(max_width) / width;
  cv::putText(sheet, text, baseline, kFont, scale, kInk, 1, cv::LINE_AA);
}

void PlaceFitted(const cv::Mat& image, cv::Mat cell) {
  cell.setTo(kMat);
  const double scale =
      std::min(static_cast<double>(cell.cols) / image.cols, static_cast<double>(cell.rows) / image.rows);
  cv::Mat fitted;
  cv::resize(image, fitted, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  const cv::Rect inner((cell.cols - fitted.cols) / 2, (cell.rows - fitted.rows) / 2,
                       std::min(fitted.cols, cell.cols), std::min(fitted.rows, cell.rows));
  fitted(cv::Rect(0, 0, inner.width, inner.height)).copyTo(cell(inner));
}

}  // namespace

cv::Mat ComposeSheet(const std::string& headline, const std::vector<SheetPanel>& panels,
                     const ContactSheetLayout& layout) {
  const int count = static_cast<int>(panels.size());
  const int rows = (count + layout.columns - 1) / layout.columns;
  const int column_step = layout.cell_width_px + kMargin;
  const int row_step = layout.cell_height_px + kCaptionHeight + kMargin;
  cv::Mat sheet(kHeadlineHeight + kMargin + rows * row_step, kMargin + layout.columns * column_step, CV_8UC3,
                kPaper);
  WriteText(sheet, headline, {kMargin, kHeadlineHeight - 8}, 0.75, sheet.cols - 2 * kMargin);
  for (int i = 0; i < count; ++i) {
    const SheetPanel& panel = panels[static_cast<std::size_t>(i)];
    if (panel.image.empty()) throw Error("contact sheet: the panel '{}' has no image", panel.caption);
    const cv::Point corner(kMargin + (i % layout.columns) * column_step,
                           kHeadlineHeight + kMargin + (i / layout.columns) * row_step);
    PlaceFitted(panel.image, sheet(cv::Rect(corner, cv::Size(layout.cell_width_px, layout.cell_height_px))));
    WriteText(sheet, panel.caption, {corner.x, corner.y + layout.cell_height_px + kCaptionHeight - 9}, 0.5,
              layout.cell_width_px);
  }
  return sheet;
}

}  // namespace ulf::commands
