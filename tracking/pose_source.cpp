#include "tracking/pose_source.h"

#include "acquisition/error.h"

namespace ulf {

PosesSpec PosesSpec::Parse(const std::string& text) {
  PosesSpec spec;
  spec.text_ = text;
  if (text == "features")
    spec.kind_ = Kind::kFeatures;
  else if (text == "known")
    spec.kind_ = Kind::kKnown;
  else
    throw UsageError("--poses {}: poses come from features or are known (by the device)", text);
  return spec;
}

std::unique_ptr<PoseSource> PosesSpec::Open(const CameraModel& camera,
                                            const PoseSourceOptions& options) const {
  switch (kind_) {
    case Kind::kKnown:
      return MakeKnownPoseSource(camera, options.subject, options.metric);
    default:
      return MakeTrackerSource(camera, options.tracker);
  }
}

}  // namespace ulf
