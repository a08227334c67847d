#include "render/prediction/error_cause.h"

namespace ulf::render {
namespace {

// All are guessed on simulated scenes (tests/render/prediction/error_cause_test), and reported on others.
constexpr double kCauseLeastSeen = 0.6;  // share of the silhouette that views see, and that has geometry
constexpr double kPoseSigmas = 2.5;      // beyond these a motion is an error of the pose
constexpr double kLeastPosePx = 0.7;     // px that it must also move the picture
constexpr double kLightShare = 0.5;      // of the error that brightness factors of blocks remove
constexpr double kMostGainSpread = 1.6;  // of the factors of exposure
constexpr double kFocusDetail = 0.6;     // of the prediction's detail that the frame has
constexpr double kLeastOffPx = 0.25;     // with less misregistration nothing is displaced
constexpr double kAlignedShare = 0.55;   // largest remaining share of the error when each view is aligned
constexpr double kViewsAgree = 0.4;      // largest variance of the views, as a share of the error

struct CauseTexts {
  const char* name;
  const char* words;
};
// The order is that of ErrorCause.
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

ErrorCause CauseOf(const PredictionError& error, double good_db) {
  if (error.inside.SeenShare() < kCauseLeastSeen || error.on_mesh_share < kCauseLeastSeen)
    return ErrorCause::kNotSeen;
  const Shares shares = SharesInside(error);
  const bool views_agree = shares.variance < kViewsAgree * shares.error;
  if (error.pose_off_sigmas > kPoseSigmas && error.pose_px > kLeastPosePx && views_agree)
    return ErrorCause::kPose;
  if (error.gain_spread > kMostGainSpread) return ErrorCause::kLight;
  if (error.detail_ratio < kFocusDetail) return ErrorCause::kFocus;
  if (error.inside.db >= good_db) return ErrorCause::kNone;
  if (shares.aligned - shares.leveled > kLightShare * shares.error) return ErrorCause::kLight;
  if (error.inside.misregistration_px < kLeastOffPx) return ErrorCause::kDetail;
  if (shares.by_view < kAlignedShare * shares.measured_error) return ErrorCause::kGeometry;
  return views_agree ? ErrorCause::kMoved : ErrorCause::kSurface;
}

}  // namespace ulf::render
