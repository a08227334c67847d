// XMP files for RealityScan (once RealityCapture), one beside each photograph: STEM.xmp for STEM.jpg. Conventions as
// realityscan_set.h has them. Poses are locked and lenses exact, so that the program keeps both; views of one camera are
// one calibration group. Groups count from 0: its help ("Selected Input") calls every number but -1 a group.
#pragma once

#include <string>

#include "core/light_field/light_field.h"

namespace ulf {

// Throws Refusal, which names the way out, where the form has no words for one of the lenses (a fisheye).
void RequireRealityScanLenses(const LightField& light_field);

// Of a view of a light field that passed the check.
std::string RealityScanXmpText(const CameraModel& camera, int camera_group, const Rigid3& cam_from_world);

}  // namespace ulf
