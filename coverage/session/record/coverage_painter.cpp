#include "coverage/session/record/coverage_painter.h"

#include <utility>

#include "coverage/measured/threshold_by_errors.h"

namespace ulf::coverage {

CoveragePainter::CoveragePainter(const RecordedViews& views, const CaptureLens& lens,
                                 const CaptureOptions& options,
                                 const std::optional<Eigen::Vector3d>& up_in_world)
    : views_(views),
      lens_(lens),
      options_(options),
      map_options_(WithAdaptiveThreshold(
          {.cap = options.cap, .up_in_world = up_in_world, .threshold_px = options.threshold_px},
          options.cover)) {}

void CoveragePainter::PaintAnew(const Subject& subject, const ErrorMap* errors) {
  auto map = std::make_shared<CoverageMap>(subject, map_options_,
                                           views_.ForCriterion(lens_.recorded(), options_.coverage_width_px));
  if (errors) AdaptThresholds(*errors, options_.cover, *map);
  map_ = std::move(map);
  painted_ = StateOf(views_);
}

double CoveragePainter::Repaint(const Subject& subject, const ErrorMap* errors) {
  if (!map_) return 0;
  const std::shared_ptr<const CoverageMap> before = map_;
  PaintAnew(subject, errors);
  DropCoveredAgain();
  double open_sr = 0, covered_sr = 0;
  std::vector<ReopenedDirection> reopened;
  before->ForEachCell([&](const CoverageMap::CellView& cell) {
    if (cell.covering.index < 0) return;
    covered_sr += cell.solid_angle_sr;
    // The cap lies around its first view and moves with it: directions that it leaves are not missing.
    const auto at = map_->views().empty() ? CoveringView{} : map_->At(cell.direction);
    if (!at || at->index >= 0) return;
    open_sr += cell.solid_angle_sr;
    reopened.push_back({cell.direction, cell.solid_angle_sr});
  });
  const double whole_sr = before->options().cap ? before->extent().SolidAngle() : covered_sr;
  for (const ReopenedDirection& cell : reopened) reopened_.push_back({cell.direction, cell.share / whole_sr});
  return whole_sr > 0 ? open_sr / whole_sr : 0;
}

void CoveragePainter::DropCoveredAgain() {
  std::erase_if(reopened_, [&](const ReopenedDirection& cell) {
    if (map_->views().empty()) return false;
    const auto at = map_->At(cell.direction);
    return !at || at->index >= 0;
  });
}

void CoveragePainter::AdaptToErrors(const ErrorMap& errors) {
  auto map = std::make_shared<CoverageMap>(*map_);
  AdaptThresholds(errors, options_.cover, *map);
  map_ = std::move(map);
}

void CoveragePainter::AddNewest() {
  if (!map_) return;
  const RecordedViews::Entry& view = views_.views().back();
  auto map = std::make_shared<CoverageMap>(*map_);
  map->Add(
      CriterionView::From(view.CameraOr(lens_.recorded()), view.cam_from_world, options_.coverage_width_px));
  map_ = std::move(map);
  DropCoveredAgain();
}

}  // namespace ulf::coverage
