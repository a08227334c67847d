#include "render/prediction/error_cause.h"

namespace ulf::render {
namespace {

struct CauseTexts {
  const char* name;
  const char* words;
};
// In the order of ErrorCause.
constexpr std::array<CauseTexts, kErrorCauses.size()> kTexts{{
    {"none", "nothing is wrong"},
    {"not_seen", "no recorded view shows it"},
    {"pose", "the position is off"},
    {"light", "light or exposure has changed"},
    {"focus", "out of focus or blurred"},
    {"moved", "something has moved"},
    {"geometry", "its depth is not known well enough"},
    {"surface", "a surface that looks different from every side"},
    {"detail", "more detail than so few views can show"},
}};

// Sums over the blocks of the silhouette.
struct Shares {
  double error = 0, aligned = 0, leveled = 0, variance = 0;
  double measured_error = 0, by_view = 0;  // where displacements were measured
};

Shares SharesInside(const PredictionError& error) {
  Shares shares;
  for (const BlockError& block : error.blocks) {
    if (!block.inside) continue;
    shares.error += block.mse;
    shares.aligned += block.mse_aligned;
    shares.leveled += block.mse_leveled;
    shares.variance += block.variance_of_views;
    if (!block.measured) continue;
    shares.measured_error += block.mse;
    shares.by_view += block.mse_by_view;
  }
  return shares;
}

}  // namespace

const char* Name(ErrorCause cause) { return kTexts[static_cast<std::size_t>(cause)].name; }
const char* InWords(ErrorCause cause) { return kTexts[static_cast<std::size_t>(cause)].words; }

ErrorCause CauseOf(const PredictionError& error, const CauseOptions& options) {
  if (error.inside.SeenShare() < options.least_seen || error.on_mesh_share < options.least_seen)
    return ErrorCause::kNotSeen;
  const Shares shares = SharesInside(error);
  const bool views_agree = shares.variance < options.views_agree * shares.error;
  if (error.pose_off_sigmas > options.pose_sigmas && error.pose_px > options.least_pose_px && views_agree)
    return ErrorCause::kPose;
  if (error.gain_spread > options.most_gain_spread) return ErrorCause::kLight;
  if (error.detail_ratio < options.focus_detail) return ErrorCause::kFocus;
  if (error.inside.db >= options.good_db) return ErrorCause::kNone;
  if (shares.aligned - shares.leveled > options.light_share * shares.error) return ErrorCause::kLight;
  if (error.inside.misregistration_px < options.least_off_px) return ErrorCause::kDetail;
  if (shares.by_view < options.aligned_share * shares.measured_error) return ErrorCause::kGeometry;
  return views_agree ? ErrorCause::kMoved : ErrorCause::kSurface;
}

}  // namespace ulf::render
