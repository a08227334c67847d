// Runs a capture: the loop that turns a device's frames into the views of a light field. Each frame gets a
// pose (tracking/) and a decision with its reason (view_decision.h); a frame that is recorded becomes a view
// on disk.
//
// The device and the tracker run in the caller's thread, writing in others (view_spool.h). With
// `deterministic` everything runs in one thread, host times are the device's times, and the same frames give
// the same bytes.
//
// When the device disappears and comes back, the tracker relocalises; the journal notes the gap. When the
// disk is full or slow, recording pauses and tracking goes on; the journal notes that gap, too. Both are
// reported at once and counted at the end.
//
// Each view is anchored to a keyframe of the tracker's map. When the map is adjusted, the views' poses
// follow: they are journaled at intervals and at the end, and the coverage map is painted anew. When the
// tracker replaces the lens (LensUse::kRefine), they follow at once. Requests (capture_request.h) are
// answered between two frames.
#pragma once

#include <vector>

#include "acquisition/device/device.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/capture_summary.h"
#include "coverage/session/record/capture_options.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

// Runs until the cap is covered, the device ends, a limit is reached or a stop is requested; then stops the
// device, finishes the adjustment of the tracker's map, brings all poses up to date and closes the light
// field. `device` has been started; `first` are the frames that were read from it before (a live frame to
// learn its size, photographs before that one); `camera` is the lens of live frames. `writer` may come from
// LightFieldWriter::Resume(): the capture goes on with its views. Throws what device or tracker throw, after
// it has closed the light field; what kept the light field from being closed is in CaptureSummary::problem.
CaptureSummary RunCapture(acquisition::Device& device, const CameraModel& camera, tracking::PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options,
                          const CaptureHooks& hooks = {}, std::vector<Frame> first = {});

}  // namespace ulf::coverage
