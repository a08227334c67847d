#include "render/display/plain_panels.h"

#include <algorithm>
#include <cmath>

namespace ulf::render {

using Eigen::Vector2d;

double ScaleOf(const Surface& surface) {
  constexpr double kWideEnough = 960, kHighEnough = 540;  // points that the texts need. Guessed.
  constexpr double kLeast = 0.6;                          // smaller text cannot be read. Guessed.
  constexpr double kSteps = 20;                           // per unit: each scale needs its own fonts
  const cv::Size screen = surface.Size();
  const double fits = std::min(screen.width / kWideEnough, screen.height / kHighEnough);
  const double wanted = std::clamp(fits, kLeast, surface.ContentScale());
  return std::round(wanted * kSteps) / kSteps;
}

void PlainPanels::Status(const std::vector<StatusItem>& items) const {
  const double gap = Px(22), pad = Px(10), line = painter_.Extent("X", TextSize::kSmall).y() + Px(4);
  std::vector<Vector2d> places;
  double x = pad, y = Px(5);
  for (const StatusItem& item : items) {
    const double width = painter_.Extent(item.text, TextSize::kSmall).x();
    if (x > pad && x + width > screen_.width - pad) x = pad, y += line;
    places.push_back({x, y});
    x += width + gap;
  }
  painter_.Box({0, 0, double(screen_.width), y + line + Px(3)}, ink::kPanel, 0);
  for (std::size_t i = 0; i < items.size(); ++i)
    painter_.Text(places[i], items[i].text, TextSize::kSmall, items[i].color);
}

void PlainPanels::Table(const std::vector<TableRow>& rows, const Vector2d& corner, const Vector2d& anchor,
                        double wrap_points) const {
  const double pad = Px(10), swatch = Px(16), gap = Px(14);
  double left = 0, right = 0, height = 0;
  std::vector<double> heights;
  bool swatches = false;
  for (const TableRow& row : rows) {
    left = std::max(left, painter_.Extent(row.left, TextSize::kSmall).x());
    const Vector2d extent = painter_.Extent(row.right, TextSize::kSmall, Px(wrap_points));
    right = std::max(right, row.right.empty() ? 0 : extent.x());
    heights.push_back(std::max(extent.y(), painter_.Extent("X", TextSize::kSmall).y()) + Px(3));
    height += heights.back();
    swatches = swatches || row.swatch;
  }
  const double indent = swatches ? swatch + Px(8) : 0;
  const Vector2d size(2 * pad + indent + left + (right > 0 ? gap + right : 0), 2 * pad + height);
  const Vector2d low = corner - anchor.cwiseProduct(size);
  painter_.Box({low.x(), low.y(), size.x(), size.y()}, ink::kPanel, 6);
  double y = low.y() + pad;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TableRow& row = rows[i];
    if (row.swatch) painter_.Box({low.x() + pad, y + Px(2), swatch, swatch}, *row.swatch, 3);
    painter_.Text({low.x() + pad + indent, y}, row.left, TextSize::kSmall, row.color);
    painter_.Text({low.x() + pad + indent + left + gap, y}, row.right, TextSize::kSmall, row.color,
                  Px(wrap_points));
    y += heights[i];
  }
}

void PlainPanels::Instruction(const std::string& words, const Rgba& color) const {
  if (words.empty()) return;
  // Uses the largest size that fits between the panels.
  const double room = std::min<double>(screen_.width - Px(40), Px(900));
  TextSize size = TextSize::kLarge;
  if (painter_.Extent(words, size).x() > room) size = TextSize::kMedium;
  const Vector2d extent = painter_.Extent(words, size, room);
  const Vector2d at(0.5 * (screen_.width - extent.x()), screen_.height - extent.y() - Px(26));
  painter_.Box({at.x() - Px(16), at.y() - Px(6), extent.x() + Px(32), extent.y() + Px(12)}, {0, 0, 0, 200},
               6);
  painter_.Text(at, words, size, color, room);
}

void PlainPanels::Hint(const std::string& words) const {
  const Vector2d extent = painter_.Extent(words, TextSize::kSmall);
  const Vector2d at(screen_.width - extent.x() - Px(22), screen_.height - extent.y() - Px(18));
  painter_.Box({at.x() - Px(10), at.y() - Px(6), extent.x() + Px(20), extent.y() + Px(12)}, ink::kPanel, 6);
  painter_.Text(at, words, TextSize::kSmall, ink::kText);
}

void PlainPanels::Notice(const std::string& words) const {
  const double room = std::min<double>(0.45 * screen_.width, Px(600));  // between the panels
  const Vector2d extent = painter_.Extent(words, TextSize::kSmall, room);
  const Vector2d at(0.5 * (screen_.width - extent.x()), screen_.height - extent.y() - Px(96));
  painter_.Box({at.x() - Px(10), at.y() - Px(6), extent.x() + Px(20), extent.y() + Px(12)}, ink::kPanel, 6);
  painter_.Text(at, words, TextSize::kSmall, ink::kCareful, room);
}

void PlainPanels::Mode(const std::vector<TableRow>& rows) const {
  Table(rows, {Px(12), screen_.height - Px(12)}, {0, 1});
}

void PlainPanels::Keys(const std::vector<TableRow>& rows) const {
  painter_.Box({0, 0, double(screen_.width), double(screen_.height)}, {0, 0, 0, 150}, 0);
  const auto gap = std::ranges::find_if(rows, [](const TableRow& row) { return row.left.empty(); });
  const double middle = 0.5 * screen_.width;
  if (gap == rows.end()) return Table(rows, {middle, 0.5 * screen_.height}, {0.5, 0.5});
  const double top = Px(80), half_a_space = Px(6);
  Table({rows.begin(), gap}, {middle - half_a_space, top}, {1, 0});
  Table({gap + 1, rows.end()}, {middle + half_a_space, top}, {0, 0});
}

void PlainPanels::Flash(const Rgba& color) const {
  const double width = screen_.width, height = screen_.height, thick = Px(16);
  painter_.Box({0, 0, width, thick}, color, 0);
  painter_.Box({0, height - thick, width, thick}, color, 0);
  painter_.Box({0, 0, thick, height}, color, 0);
  painter_.Box({width - thick, 0, thick, height}, color, 0);
}

}  // namespace ulf::render
