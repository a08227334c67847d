// Why a frame differs from what the recorded views predict of it, by evidence in the difference itself.
//
//   not seen   no view sees the subject's points, or there is no geometry where the subject is
//   pose       the whole picture is displaced, as by a motion of the camera beyond the pose's uncertainty
//   light      what remains after alignment is brightness: a lamp, a cloud, an exposure that clips
//   focus      the frame has less detail than the prediction, everywhere
//   geometry   the views are displaced, each another way, and agree with the frame when each is aligned: depths are
//              wrong
//   moved      things are displaced, and the views agree among each other: the subject has changed
//   surface    things are displaced, and the views differ among each other however they are aligned: mirrors, glass,
//              gloss
//   detail     nothing is displaced: there is more detail than so few views can show
#pragma once

#include <array>

#include "render/prediction/prediction_error.h"

namespace ulf::render {

enum class ErrorCause { kNone, kNotSeen, kPose, kLight, kFocus, kMoved, kGeometry, kSurface, kDetail };
inline constexpr std::array kErrorCauses{ErrorCause::kNone,     ErrorCause::kNotSeen, ErrorCause::kPose,
                                         ErrorCause::kLight,    ErrorCause::kFocus,   ErrorCause::kMoved,
                                         ErrorCause::kGeometry, ErrorCause::kSurface, ErrorCause::kDetail};
const char* Name(ErrorCause cause);     // as in files: "none", "not_seen", ...
const char* InWords(ErrorCause cause);  // for the person with the camera

// All guessed on simulated scenes (tests/render/prediction/error_cause_test), and reported on others.
struct CauseOptions {
  double good_db = 33;            // inside the silhouette, after the noise: nothing to explain
  double least_seen = 0.6;        // share of the silhouette that views see, and that has geometry
  double pose_sigmas = 2.5;       // beyond these a motion is an error of the pose
  double least_pose_px = 0.7;     // and it moves the picture by as much
  double light_share = 0.5;       // of the error that a factor of each block's brightness takes away
  double most_gain_spread = 1.6;  // of the factors of exposure
  double focus_detail = 0.6;      // of the prediction's detail that the frame has
  double least_off_px = 0.25;     // with less misregistration nothing is displaced
  double aligned_share = 0.55;    // of the error that stays, at most, when each view is aligned
  double views_agree = 0.4;       // where the views' variance is below this share of the error
};

ErrorCause CauseOf(const PredictionError& error, const CauseOptions& options = {});

}  // namespace ulf::render
