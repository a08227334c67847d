// Parses the choice of a source of poses from text: "features", "markers:SPEC", "tum:FILE" and so on
// (docs/tracking.md).
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/light_field/light_field.h"
#include "tracking/sources/marker_spec.h"
#include "tracking/sources/pose_sources.h"
#include "tracking/sources/pose_stream.h"
#include "tracking/tracker/pose_source.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::tracking {

struct PoseSourceOptions {
  TrackerOptions tracker = {};
  std::optional<Subject> subject = {};  // for given poses: Track::speed_px is computed at its distance
  bool metric = false;                  // the frames' own poses are in metres
  std::function<bool()> stop = {};      // PoseStreamOptions::stop
};

// The forms that Parse() accepts, for a program's help.
inline constexpr const char* kPosesHelp =
    "Where poses come from: features (tracked), markers:SPEC, features+markers:SPEC, known (by the device), "
    "tum:FILE, tcp:PORT (docs/tracking.md)";

// The same as a list of values.
inline constexpr const char* kPosesValues =
    "features,markers:SPEC,features+markers:SPEC,known,tum:FILE,tcp:PORT";

class PosesSpec {
 public:
  // Throws Refusal that names the accepted forms, and Error for a hand_eye file that cannot be read.
  static PosesSpec Parse(const std::string& text);
  const std::string& Text() const { return text_; }
  // Returns whether the poses come with the frames or from outside, so that there are no tracked points.
  bool AreGiven() const { return kind_ == Kind::kKnown || kind_ == Kind::kFile || kind_ == Kind::kStream; }
  bool ComeWithFrames() const { return kind_ == Kind::kKnown; }
  // Returns whether the user can name a subject before the first frame, in a world that is defined.
  bool DefineWorld() const { return kind_ != Kind::kFeatures; }
  // Returns whether the world is the marker that is seen first, which differs between sessions.
  bool WorldVaries() const {
    return (kind_ == Kind::kMarkers || kind_ == Kind::kBoth) && markers_.kind == MarkerSpec::Kind::kSeveral;
  }
  // Throws Refusal for LensUse::kRefine unless the poses come from a map of features alone.
  void RequireFor(LensUse lens) const;
  // Returns whether the source builds a map of features, which a resumed capture must restore.
  bool UseFeatures() const { return kind_ == Kind::kFeatures || kind_ == Kind::kBoth; }
  // Whether the tracker may go on with the lens that its images tell (LensUse::kRefine).
  bool FindLens() const { return kind_ == Kind::kFeatures; }
  // Returns SPEC of markers:SPEC and features+markers:SPEC.
  const MarkerSpec& markers() const { return markers_; }
  // Makes the source; throws as the functions of pose_sources.h do.
  std::unique_ptr<PoseSource> Open(const CameraModel& camera, const PoseSourceOptions& options) const;

 private:
  enum class Kind { kFeatures, kKnown, kMarkers, kBoth, kFile, kStream };
  std::string text_ = "features";
  Kind kind_ = Kind::kFeatures;
  MarkerSpec markers_;
  std::filesystem::path file_;
  TrajectoryOptions trajectory_;
  PoseStreamOptions stream_;
};

}  // namespace ulf::tracking
