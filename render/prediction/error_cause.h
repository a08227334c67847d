// Why a frame differs from what the recorded views predict of it, by evidence in the difference itself.
//
//   not seen no view sees the subject's points, or there is no geometry where the subject is pose the whole
//   picture is displaced, as by a motion of the camera beyond the pose's uncertainty light what remains after
//   alignment is brightness: a lamp, a cloud, an exposure that clips focus the frame has less detail than the
//   prediction, everywhere geometry the views are displaced, each another way, and agree with the frame when
//   each is aligned: depths are
//              wrong
//   moved things are displaced, and the views agree among each other: the subject has changed surface things
//   are displaced, and the views differ among each other however they are aligned: mirrors, glass,
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

// `good_db`: inside the silhouette, after the noise, nothing is to be explained from there on. Guessed.
ErrorCause CauseOf(const PredictionError& error, double good_db = 33);

}  // namespace ulf::render
