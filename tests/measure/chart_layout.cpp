#include "tests/measure/chart_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>

namespace ulf::test {
namespace {

constexpr double kPoint = 5;  // half a point's size, px
constexpr double kClear = 3;  // of a name from a line above or below, px

std::vector<double> LinearTics(double low, double high) {
  const double rough = (high - low) / 6, power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double nice : {5.0, 2.5, 2.0, 1.0})
    if (nice * power >= rough) step = nice * power;
  std::vector<double> tics;
  for (double k = std::ceil(low / step); k * step <= high * (1 + 1e-12); ++k) tics.push_back(k * step);
  return tics;
}

std::vector<double> LogarithmicTics(double low, double high) {
  const double decades = std::log10(high / low);
  if (decades < 0.5) return LinearTics(low, high);
  std::vector<double> steps{1};
  if (decades <= 3.2) steps = {1, 2, 5};
  if (decades <= 1.1) steps = {1, 1.5, 2, 3, 4, 5, 7};
  constexpr double kMostDecades = 7;
  const int apart = static_cast<int>(std::ceil(decades / kMostDecades));
  std::vector<double> tics;
  for (double power = std::pow(10, apart * std::floor(std::log10(low) / apart)); power <= high;
       power *= std::pow(10, apart))
    for (const double step : steps)
      if (step * power >= low && step * power <= high) tics.push_back(step * power);
  return tics;
}

// A point, and the places for its name, the best first.
struct NamedPlace {
  double x = 0, y = 0, half = 0;  // the point's own half size
  std::array<ChartBox, 8> Around(double width) const {
    const double beside = half + 3 + 0.5 * width, above = half + 3 + 0.5 * kNameHeight;
    std::array<ChartBox, 8> boxes;
    std::size_t next = 0;
    for (const auto& [dx, dy] : {std::pair{0.0, -above},
                                 {beside, -0.8 * above},
                                 {beside, 0.0},
                                 {-beside, -0.8 * above},
                                 {0.0, above},
                                 {beside, 0.8 * above},
                                 {-beside, 0.0},
                                 {-beside, 0.8 * above}})
      boxes[next++] = {x + dx - 0.5 * width, y + dy - 0.5 * kNameHeight, x + dx + 0.5 * width,
                       y + dy + 0.5 * kNameHeight};
    return boxes;
  }
};

std::vector<NamedPlace> PlacesOf(const ChartPanel& panel, const ChartScale& cost, const ChartScale& error,
                                 const ChartBox& inside) {
  std::vector<NamedPlace> places;
  for (const ChartRow& point : panel.points)
    places.push_back({inside.left + cost.Share(point.cost.median) * (inside.right - inside.left),
                      inside.bottom - error.Share(point.error.median) * (inside.bottom - inside.top),
                      point.is_default ? 2 * kPoint : kPoint});
  return places;
}

// The default first, then the front, then the rest.
std::vector<std::size_t> NamingOrder(const ChartPanel& panel, const std::vector<std::size_t>& front) {
  const auto rank = [&](std::size_t i) {
    return panel.points[i].is_default ? 0 : std::ranges::find(front, i) != front.end() ? 1 : 2;
  };
  std::vector<std::size_t> order(panel.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  return order;
}

// Bars and lines between points, which names should not cover. Short boxes stand for slanted lines.
std::vector<ChartBox> Strokes(const ChartPanel& panel, const ChartScale& cost, const ChartScale& error,
                              const ChartBox& inside, const std::vector<NamedPlace>& places) {
  constexpr double kPiece = 6;  // px
  const auto x = [&](double value) { return inside.left + cost.Share(value) * (inside.right - inside.left); };
  const auto y = [&](double value) {
    return inside.bottom - error.Share(value) * (inside.bottom - inside.top);
  };
  std::vector<ChartBox> strokes;
  for (std::size_t i = 0; i < panel.points.size(); ++i) {
    const ChartRow& point = panel.points[i];
    const NamedPlace& at = places[i];
    if (point.cost.high > point.cost.low)
      strokes.push_back({std::min(x(point.cost.low), x(point.cost.high)), at.y - kClear,
                         std::max(x(point.cost.low), x(point.cost.high)), at.y + kClear});
    if (point.error.high > point.error.low)
      strokes.push_back({at.x - 1, y(point.error.high), at.x + 1, y(point.error.low)});
    const auto next = std::find_if(panel.points.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                   panel.points.end(), [&](const ChartRow& other) {
                                     return other.series == point.series && std::isfinite(other.error.median);
                                   });
    if (!panel.joined || next == panel.points.end() || !std::isfinite(point.error.median)) continue;
    const NamedPlace& to = places[static_cast<std::size_t>(next - panel.points.begin())];
    const double length = std::hypot(to.x - at.x, to.y - at.y);
    for (double along = 0; along < length; along += kPiece) {
      const double px = at.x + (to.x - at.x) * along / length, py = at.y + (to.y - at.y) * along / length;
      strokes.push_back({px - 1, py - 1, px + 1, py + 1});
    }
  }
  return strokes;
}

// The front is drawn in steps: along, then up or down.
std::vector<ChartBox> FrontLine(const std::vector<NamedPlace>& places,
                                const std::vector<std::size_t>& front) {
  std::vector<ChartBox> line;
  for (std::size_t i = 1; i < front.size(); ++i) {
    const NamedPlace &from = places[front[i - 1]], &to = places[front[i]];
    line.push_back({from.x, from.y - kClear, to.x, from.y + kClear});
    line.push_back({to.x - 1, std::min(from.y, to.y), to.x + 1, std::max(from.y, to.y)});
  }
  return line;
}

bool Holds(const ChartBox& outer, const ChartBox& inner) {
  return inner.left >= outer.left && inner.right <= outer.right && inner.top >= outer.top &&
         inner.bottom <= outer.bottom;
}

// Moves the box inside sideways, if it is not too wide.
void PushInside(const ChartBox& inside, ChartBox& box) {
  const double by = std::max(0.0, inside.left - box.left) - std::max(0.0, box.right - inside.right);
  box.left += by;
  box.right += by;
}

bool Free(const ChartBox& box, const std::vector<ChartBox>& taken) {
  return std::ranges::none_of(taken, [&](const ChartBox& other) { return box.Overlaps(other); });
}

// The nearest free place in rings about the point.
std::optional<ChartBox> FartherOff(const NamedPlace& place, double width, const ChartBox& inside,
                                   const std::vector<ChartBox>& taken) {
  constexpr int kRings = 12, kDirections = 16;
  for (int ring = 2; ring < 2 + kRings; ++ring)
    for (int d = 0; d < kDirections; ++d) {
      const double angle = 2 * M_PI * d / kDirections - M_PI / 2, off = ring * kNameHeight;
      const double x = place.x + (off + 0.5 * width) * std::cos(angle), y = place.y + off * std::sin(angle);
      ChartBox box{x - 0.5 * width, y - 0.5 * kNameHeight, x + 0.5 * width, y + 0.5 * kNameHeight};
      PushInside(inside, box);
      if (Holds(inside, box) && Free(box, taken)) return box;
    }
  return std::nullopt;
}

}  // namespace

double ChartScale::Share(double value) const {
  const double share =
      logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return falls ? 1 - share : share;
}

ChartScale ScaleOf(const std::vector<Spread>& values, bool logarithmic, bool from_zero) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Spread& value : values)
    for (const double v : {value.median, value.low, value.high})
      if (std::isfinite(v) && (v > 0 || !logarithmic)) low = std::min(low, v), high = std::max(high, v);
  if (!(low <= high)) low = high = 1;
  ChartScale scale{low, high, logarithmic, {}, false};
  if (logarithmic) {
    const double margin = std::max(std::pow(high / low, 0.07), 1.1);
    scale.low /= margin, scale.high *= margin;
    scale.tics = LogarithmicTics(scale.low, scale.high);
  } else {
    const double margin = high > low  ? 0.08 * (high - low)
                          : high == 0 ? 1
                                      : 0.1 * std::max(1.0, std::abs(high));
    scale.low = low >= 0 && (from_zero || low <= 0.4 * high) ? 0 : low - margin;
    scale.high = high + margin;
    scale.tics = LinearTics(scale.low, scale.high);
  }
  return scale;
}

std::vector<PlacedName> PlaceNames(const ChartPanel& panel, const ChartScale& cost, const ChartScale& error,
                                   const ChartBox& inside) {
  const std::vector<NamedPlace> places = PlacesOf(panel, cost, error, inside);
  const std::vector<std::size_t> front = ParetoFront(panel);
  std::vector<ChartBox> taken;
  for (const NamedPlace& p : places)
    taken.push_back({p.x - p.half, p.y - p.half, p.x + p.half, p.y + p.half});
  std::vector<ChartBox> line = FrontLine(places, front);
  const std::vector<ChartBox> strokes = Strokes(panel, cost, error, inside, places);
  line.insert(line.end(), strokes.begin(), strokes.end());
  std::vector<PlacedName> placed;
  for (const std::size_t i : NamingOrder(panel, front)) {
    const std::string& name = panel.points[i].name;
    if (name.empty() || !std::isfinite(places[i].x) || !std::isfinite(places[i].y)) continue;
    auto around = places[i].Around(kNameCharacter * static_cast<double>(name.size()));
    for (ChartBox& each : around) PushInside(inside, each);
    const ChartBox* box = nullptr;
    std::ptrdiff_t fewest = 0;  // lines under it; of equal ones the first
    for (const ChartBox& candidate : around) {
      if (!Holds(inside, candidate) || !Free(candidate, taken)) continue;
      const auto crossed =
          std::ranges::count_if(line, [&](const ChartBox& other) { return candidate.Overlaps(other); });
      if (!box || crossed < fewest) box = &candidate, fewest = crossed;
    }
    const bool beside = box != nullptr;
    std::optional<ChartBox> where;
    if (beside)
      where = *box;
    else if (panel.all_named)
      where = FartherOff(places[i], kNameCharacter * static_cast<double>(name.size()), inside, taken);
    if (!where) continue;
    taken.push_back(*where);
    placed.push_back({i, *where, beside, places[i].x, places[i].y});
  }
  return placed;
}

ChartLayout LayoutOf(const Chart& chart, int legend_lines, int note_lines) {
  const std::size_t count = std::max<std::size_t>(1, chart.panels.size());
  const std::size_t columns = count == 3 ? 3 : std::min<std::size_t>(count, 2);
  const std::size_t rows = (count + columns - 1) / columns;
  constexpr double kAxes = 78, kGap = 24, kPanelTitle = 34, kBelow = 54;
  const double panel_width = columns == 1 ? 860 : columns == 2 ? 640 : 500;
  const double panel_height = columns == 1 ? 520 : 400;
  ChartLayout layout;
  layout.width = static_cast<int>(static_cast<double>(columns) * panel_width);
  layout.legend_top = 46;
  const double top = layout.legend_top + 20 * legend_lines;
  for (std::size_t i = 0; i < count; ++i) {
    const double left = panel_width * static_cast<double>(i % columns);
    const double upper = top + panel_height * static_cast<double>(i / columns);
    layout.panels.push_back(
        {left + kAxes, upper + kPanelTitle, left + panel_width - kGap, upper + panel_height - kBelow});
  }
  layout.notes_top = top + panel_height * static_cast<double>(rows) + 8;
  layout.height = static_cast<int>(layout.notes_top + 17 * note_lines + 6);
  return layout;
}

std::vector<std::string> Lines(const std::string& text, std::size_t characters) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > characters) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

}  // namespace ulf::test
