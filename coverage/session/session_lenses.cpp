#include "coverage/session/session_lenses.h"

#include <spdlog/spdlog.h>

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/record/still_capture.h"

namespace ulf::coverage {
namespace {

// An imported set may have cameras of several sizes: the last one of the device's is used.
void UseCameraOfSize(const Frame& frame, LightFieldWriter& writer) {
  const std::vector<CameraModel>& cameras = writer.Contents().cameras;
  for (std::size_t i = cameras.size(); i-- > 0;)
    if (cameras[i].width == frame.image.width() && cameras[i].height == frame.image.height())
      return writer.UseCamera(static_cast<int>(i));
  throw Error("{}: was captured at {}x{}, the device now gives {}x{}; set it back or begin a new light field",
              writer.Contents().root.string(), cameras.back().width, cameras.back().height,
              frame.image.width(), frame.image.height());
}

NewCamera CameraInUse(const LightFieldWriter& writer) {
  const LightField& light_field = writer.Contents();
  const int index = writer.CameraInUse();
  const auto of = [index](const auto& by_camera) {
    const auto found = by_camera.find(index);
    return found == by_camera.end() ? std::nullopt : std::optional(found->second);
  };
  return {light_field.cameras.at(static_cast<std::size_t>(index)), of(light_field.flat_fields),
          of(light_field.color_profiles), light_field.CalibrationSource(index)};
}

// Says what is doubtful about it.
NewCamera Resolved(const acquisition::ResolvedCalibration& calibration) {
  for (const std::string& warning : calibration.warnings) spdlog::warn("{}", warning);
  return {calibration.camera, calibration.flat_field, calibration.color_profile, calibration.source};
}

// Returns how two lenses differ, for people.
std::string LensInWords(const NewCamera& now, const NewCamera& before) {
  const double focal_px = now.camera.MeanFocalPx(), focal_before_px = before.camera.MeanFocalPx();
  const std::string text = fmt::format("{:.1f}", focal_px),
                    text_before = fmt::format("{:.1f}", focal_before_px);
  if (text != text_before) return fmt::format("f {} px instead of {}", text, text_before);
  return now.camera == before.camera ? "the same lens, with another flat field or colour profile"
                                     : fmt::format("f {} px as before, another middle or distortion", text);
}

// What a file does not say of flat field and colours stays as it is.
bool IsSameLens(const NewCamera& given, const NewCamera& in_use) {
  return given.camera == in_use.camera && (!given.flat_field || given.flat_field == in_use.flat_field) &&
         (!given.color_profile || given.color_profile == in_use.color_profile);
}

// Returns the lens in use before it was corrected (`ulf refine`, or LensUse::kRefine).
NewCamera AsNoted(const LightFieldWriter& writer) {
  NewCamera camera = CameraInUse(writer);
  camera.camera = writer.CameraAsNoted();
  return camera;
}

// Returns whether the lens that was named for a session is another one than the light field has.
bool IsNew(const NewCamera& given, const LightFieldWriter& writer) {
  const NewCamera in_use = CameraInUse(writer);
  if (IsSameLens(given, in_use)) return false;
  if (!IsSameLens(given, AsNoted(writer))) return true;
  spdlog::info("{}: the lens that it was begun with ({}) was corrected since ({}); the corrected one stays",
               writer.Contents().root.string(), given.calibration_source, LensInWords(in_use, given));
  return false;
}

// The calibration that earlier sessions took without being told may have been made anew.
void WarnOfOtherStoredLens(const acquisition::Device& device, const LightFieldWriter& writer) {
  const NewCamera in_use = CameraInUse(writer);
  try {
    const auto stored =
        acquisition::ResolveCalibration(device, {}, in_use.camera.width, in_use.camera.height);
    const NewCamera now{stored.camera, stored.flat_field, stored.color_profile, stored.source};
    if (stored.source == in_use.calibration_source && !IsSameLens(now, in_use) &&
        !IsSameLens(now, AsNoted(writer)))
      spdlog::warn(
          "{}: goes on under the lens that it has; the calibration {} is another one since ({}): it is used "
          "from now on where its file is given ({})",
          writer.Contents().root.string(), stored.source, LensInWords(now, in_use), Parameter("calibration"));
  } catch (const Error&) {  // there is none
  }
}

// The same number of pixels elsewhere on the sensor has another principal point.
void RequireSameWindow(const std::string& dir, const std::optional<SensorWindow>& recorded,
                       const std::optional<SensorWindow>& now) {
  if (!recorded || !now || *recorded == *now) return;
  throw Error(
      "{}: its views show {}, the device is now set to {}: set it back, or give the lens of this part of the "
      "sensor ({} FILE)",
      dir, Describe(*recorded), Describe(*now), Parameter("calibration"));
}

}  // namespace

SessionLenses ChooseLenses(const acquisition::Device& device, const Frame& first,
                           const acquisition::IntrinsicsArgs& given, const acquisition::IntrinsicsArgs& live,
                           LightFieldWriter* resumed) {
  const bool stills = device.TakesStills();
  const bool is_named = !given.calibration_path.empty() || (given.focal_px && !stills);
  SessionLenses lenses;
  if (resumed && !stills) UseCameraOfSize(first, *resumed);
  if (resumed && !stills && !is_named) {
    RequireSameWindow(resumed->Contents().root.string(), resumed->Contents().window, device.Window());
    WarnOfOtherStoredLens(device, *resumed);
    lenses.live = lenses.recorded = CameraInUse(*resumed);
    lenses.live_origin = acquisition::OriginOfSource(lenses.live.calibration_source);
    return lenses;
  }
  const acquisition::ResolvedCalibration of_live =
      acquisition::ResolveCalibration(device, live, first.image.width(), first.image.height());
  if (resumed && given.focal_px && of_live.origin != acquisition::LensOrigin::kGiven)
    throw Refusal(
        Parameter("focal_px"), fmt::format("{:g}", *given.focal_px),
        fmt::format("the camera's intrinsics are known ({}) and come first", of_live.source),
        fmt::format("leave it out, or give another lens on purpose ({} FILE)", Parameter("calibration")));
  lenses.live = Resolved(of_live);
  lenses.live_origin = of_live.origin;
  if (!stills)
    lenses.recorded = lenses.live;
  else if (resumed && !is_named)
    lenses.recorded = CameraInUse(*resumed);
  else
    lenses.recorded = Resolved(ResolveStillCamera(device, given));
  if (!resumed || !is_named) return lenses;
  lenses.is_new = IsNew(lenses.recorded, *resumed);
  if (lenses.is_new) return lenses;
  lenses.recorded = CameraInUse(*resumed);
  if (stills) return lenses;
  lenses.live = lenses.recorded;
  lenses.live_origin = acquisition::OriginOfSource(lenses.live.calibration_source);
  return lenses;
}

void AddCameraInUse(const NewCamera& camera, LightFieldWriter& writer) {
  const std::string difference = LensInWords(camera, CameraInUse(writer));
  const int number = writer.AddCamera(camera) + 1;
  spdlog::info("the views from {} on have {}: {} ({})", writer.NextViewId(),
               number == 2 ? "a second camera" : fmt::format("camera {}", number), difference,
               camera.calibration_source);
  if (!writer.Contents().views.empty())
    spdlog::info(
        "new views are placed in the map of those so far, whose poses belong to their lens: the check of the "
        "lens sees mostly those, and may miss that this one is wrong; 'ulf refine {} --intrinsics' tells, "
        "and where it is the same lens, calibrated better, puts views and map right before you go on",
        ShellWord(writer.Contents().root.string()));
}

}  // namespace ulf::coverage
