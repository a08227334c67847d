#include "tracking/sources/poses_spec.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>

#include "core/base/at.h"
#include "core/base/device_uri.h"
#include "core/base/error.h"
#include "tracking/tracker/working_size.h"

namespace ulf::tracking {
namespace {

// Reads `tx ty tz qx qy qz qw`, the camera in the tool's frame.
Rigid3 ReadHandEye(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error("hand_eye: {} cannot be read", path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    double v[7];
    char rest = 0;
    const int read = std::sscanf(line.c_str(), "%lf %lf %lf %lf %lf %lf %lf %c", v, v + 1, v + 2, v + 3,
                                 v + 4, v + 5, v + 6, &rest);
    const auto pose = read == 7 ? PoseFromNumbers(v) : std::nullopt;
    if (!pose)
      throw Error("hand_eye: {}: '{}' is not 'tx ty tz qx qy qz qw', the camera in the tool's frame", path,
                  line);
    return *pose;
  }
  throw Error("hand_eye: {} holds no line 'tx ty tz qx qy qz qw'", path);
}

// Warns before the start, because a failure looks as if the operator moved wrongly.
void WarnOfLargePictures(const CameraModel& camera, const TrackerOptions& options) {
  const CameraModel tracked = WorkingSize(camera, options.max_side_px).working();
  if (std::max(tracked.width, tracked.height) <= TrackerOptions{}.max_side_px) return;
  spdlog::warn(
      "pictures are tracked at {}x{}: unless they are sharp at that size, few features are found again; "
      "leave {} out if tracking fails",
      tracked.width, tracked.height, Parameter("tracking_side"));
}

double AtLeastZero(const DeviceUri& uri, const char* key, double otherwise) {
  const double value = uri.Number(key).value_or(otherwise);
  if (value < 0)
    throw Refusal(Parameter("poses"), uri.Text(), fmt::format("{}={:g} is below 0", key, value), "");
  return value;
}

SenderClock ClockFrom(const DeviceUri& uri) {
  const std::string name = uri.Option("clock").value_or("own");
  if (name == "own") return SenderClock::kOwn;
  if (name == "host") return SenderClock::kHost;
  if (name == "device") return SenderClock::kDevice;
  throw Refusal(Parameter("poses"), uri.Text(), fmt::format("clock={} is unknown", name),
                "give own (the sender's clock), host or device");
}

}  // namespace

PosesSpec PosesSpec::Parse(const std::string& text) {
  PosesSpec spec;
  spec.text_ = text;
  const auto after = [&](const char* prefix) { return text.substr(std::string(prefix).size()); };
  const auto read_common = [&](const DeviceUri& uri, auto& options) {
    options.offset_s = uri.Number("offset_s").value_or(0);
    options.max_gap_s = AtLeastZero(uri, "max_gap_s", options.max_gap_s);
    if (const auto path = uri.Option("hand_eye")) spec.trajectory_.tool_from_cam = ReadHandEye(*path);
  };
  if (text == "features") {
    spec.kind_ = Kind::kFeatures;
  } else if (text == "known") {
    spec.kind_ = Kind::kKnown;
  } else if (text.starts_with("markers:")) {
    spec.kind_ = Kind::kMarkers;
    spec.markers_ = MarkerSpec::Parse(after("markers:"));
  } else if (text.starts_with("features+markers:")) {
    spec.kind_ = Kind::kBoth;
    spec.markers_ = MarkerSpec::Parse(after("features+markers:"));
  } else if (text.starts_with("tum:")) {
    const DeviceUri uri = DeviceUri::Parse(text);
    uri.AllowOnly({"offset_s", "hand_eye", "max_gap_s"});
    spec.kind_ = Kind::kFile;
    spec.file_ = uri.path;
    if (spec.file_.empty())
      throw Refusal(Parameter("poses"), text, "write tum:FILE, a trajectory in TUM format", "");
    read_common(uri, spec.trajectory_);
  } else if (text.starts_with("tcp:")) {
    const DeviceUri uri = DeviceUri::Parse(text);
    uri.AllowOnly({"offset_s", "hand_eye", "max_gap_s", "wait_s", "connect_s", "clock"});
    spec.kind_ = Kind::kStream;
    int used = 0;
    if (std::sscanf(uri.path.c_str(), "%d%n", &spec.stream_.port, &used) != 1 ||
        At(used) != uri.path.size() || spec.stream_.port < 0 || spec.stream_.port > 65535)
      throw Refusal(Parameter("poses"), text, fmt::format("'{}' is not a port", uri.path),
                    "write tcp:PORT, 1 to 65535, or 0 for any that is free");
    read_common(uri, spec.stream_);
    spec.stream_.wait_s = AtLeastZero(uri, "wait_s", spec.stream_.wait_s);
    spec.stream_.connect_s = AtLeastZero(uri, "connect_s", spec.stream_.connect_s);
    spec.stream_.clock = ClockFrom(uri);
  } else {
    throw Refusal(Parameter("poses"), text,
                  "poses come from features, markers:SPEC, features+markers:SPEC, known (by the device), "
                  "tum:FILE or tcp:PORT",
                  "");
  }
  return spec;
}

void PosesSpec::RequireFor(LensUse lens) const {
  if (lens == LensUse::kRefine && !FindLens())
    throw Refusal(
        Parameter("intrinsics"), fmt::format("refine with {} {}", Parameter("poses"), text_),
        "the lens is found from tracked features alone",
        fmt::format("leave out {} to find it, then use these poses with the calibration that {} writes",
                    Parameter("poses"), Parameter("calibration_out")));
}

std::unique_ptr<PoseSource> PosesSpec::Open(const CameraModel& camera,
                                            const PoseSourceOptions& options) const {
  if (UseFeatures()) WarnOfLargePictures(camera, options.tracker);
  switch (kind_) {
    case Kind::kKnown:
      return MakeKnownPoseSource(camera, options.subject, options.metric);
    case Kind::kMarkers:
      return MakeMarkerSource(camera, markers_);
    case Kind::kBoth:
      return MakeFeaturesAndMarkersSource(camera, markers_, options.tracker);
    case Kind::kFile:
      return MakeTrajectorySource(camera, file_, trajectory_, options.subject);
    case Kind::kStream: {
      PoseStreamOptions stream = stream_;
      stream.stop = options.stop;
      return MakeStreamSource(camera, std::make_unique<PoseStream>(stream), trajectory_.tool_from_cam,
                              options.subject);
    }
    default:
      return MakeTrackerSource(camera, options.tracker);
  }
}

}  // namespace ulf::tracking
