// Finds why a frame differs from the recorded views' prediction, by evidence in the difference itself.
//
//   not seen   no view sees the subject's points, or there is no geometry at the subject
//   pose       the whole picture is displaced, by more than the pose's uncertainty
//   light      the views' exposure factors differ widely, or the error after alignment is brightness: a lamp,
//              a cloud, a clipping exposure
//   focus      the frame has less detail than the prediction, everywhere
//   geometry   each view is displaced differently, and agrees when aligned: depths are wrong
//   moved      things are displaced, and the views agree among each other: the subject has changed
//   surface    things are displaced, and the views differ even when aligned: mirrors, glass, gloss
//   detail     nothing is displaced: there is more detail than so few views can show
#pragma once

#include <array>

#include "render/prediction/prediction_error.h"

namespace ulf::render {

enum class ErrorCause { kNone, kNotSeen, kPose, kLight, kFocus, kMoved, kGeometry, kSurface, kDetail };
inline constexpr std::array kErrorCauses{ErrorCause::kNone,     ErrorCause::kNotSeen, ErrorCause::kPose,
                                         ErrorCause::kLight,    ErrorCause::kFocus,   ErrorCause::kMoved,
                                         ErrorCause::kGeometry, ErrorCause::kSurface, ErrorCause::kDetail};
const char* Name(ErrorCause cause);     // for files: "none", "not_seen", ...
const char* InWords(ErrorCause cause);  // for the person with the camera

// From `good_db` on, inside the silhouette and without noise, only kNotSeen, kPose, kLight (by exposure
// factors) and kFocus are still found, else kNone. Guessed.
ErrorCause CauseOf(const PredictionError& error, double good_db = 33);

}  // namespace ulf::render
