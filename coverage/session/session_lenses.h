// Chooses the lenses of a session: of the live frames, and of what is recorded, which is the same unless the
// device takes photographs. A resumed light field continues with the camera that it has
// (LightFieldWriter::CameraInUse) unless the caller names another lens: that one becomes a new camera, and
// the views so far keep theirs.
#pragma once

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "core/frames/frame.h"
#include "core/light_field/folder/light_field_writer.h"

namespace ulf::coverage {

struct SessionLenses {
  NewCamera live, recorded;
  acquisition::LensOrigin live_origin = acquisition::LensOrigin::kMeasured;
  bool is_new = false;  // the light field that is resumed does not have `recorded` yet
};

// `first`: a live frame. `given`: the caller's arguments. `live`: those for live frames, with a guess where
// the lens is to be refined. `resumed`: the writer of the light field that goes on; null: a light field
// begins. Throws Error and Refusal where a lens cannot be had or does not fit; writes nothing.
SessionLenses ChooseLenses(const acquisition::Device& device, const Frame& first,
                           const acquisition::IntrinsicsArgs& given, const acquisition::IntrinsicsArgs& live,
                           LightFieldWriter* resumed);

// Adds the camera to the light field, and reports from which view on it counts.
void AddCameraInUse(const NewCamera& camera, LightFieldWriter& writer);

}  // namespace ulf::coverage
