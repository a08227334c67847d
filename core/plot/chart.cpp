#include "core/plot/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ulf {
namespace {

bool Counts(const ChartRow& point) {
  return std::isfinite(point.cost.median) && std::isfinite(point.error.median);
}

}  // namespace

ChartSpread ChartSpread::Of(const std::vector<double>& values) {
  if (values.empty()) return Exactly(std::numeric_limits<double>::quiet_NaN());
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  return {sorted[sorted.size() / 2], sorted.front(), sorted.back()};
}

std::vector<std::size_t> ParetoFront(const ChartPanel& panel) {
  std::vector<std::size_t> front;
  if (!panel.compared) return front;
  const auto error = [&](std::size_t i) {
    return (panel.error.more_is_better ? -1 : 1) * panel.points[i].error.median;
  };
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < panel.points.size(); ++i)
    if (Counts(panel.points[i])) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double cost_a = panel.points[a].cost.median, cost_b = panel.points[b].cost.median;
    return cost_a != cost_b ? cost_a < cost_b : error(a) < error(b);
  });
  for (const std::size_t i : order)
    if (front.empty() || error(i) < error(front.back())) front.push_back(i);
  return front;
}

}  // namespace ulf
