// Finds the settings of a photograph under the names that different makers' drivers give them: shutter, ISO,
// aperture, focus, exposure program, file format. Values are compared by meaning ("1/125" equals "0.0080s").
//
// Lock() writes a setting and reads it back; Changes() reports every later change (automatic ISO, a dial that
// somebody turns), because it changes the pictures in the middle of a capture.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

enum class ShotSetting { kShutter, kIso, kAperture, kFocus, kFormat, kProgram };
inline constexpr std::array kShotSettings{ShotSetting::kShutter, ShotSetting::kIso,    ShotSetting::kAperture,
                                          ShotSetting::kFocus,   ShotSetting::kFormat, ShotSetting::kProgram};
const char* Name(ShotSetting setting);  // as in the URI: "shutter", "iso", ...

// Reads "1/125", "0.0080s", "f/5.6", "ISO 200", "2.5"; none for "Auto", "bulb".
std::optional<double> PhotographicNumber(const std::string& text);
bool IsSameSetting(const std::string& a, const std::string& b);
// Returns the choice with the same text or number, or the only one that contains the text; else none.
std::optional<std::string> ChoiceFor(const std::vector<std::string>& choices, const std::string& value);
// Returns the choice for manual operation ("Manual", "MF", "Off"); none if there is none.
std::optional<std::string> ManualChoice(const std::vector<std::string>& choices);
// Returns whether the value leaves a setting to the camera ("Auto", "AF-S", "One Shot").
bool IsAutomatic(const std::string& value);

// The files that a photograph consists of, by the camera's name of the image format.
struct PhotographFiles {
  bool raw = false, jpeg = true;
};
PhotographFiles FilesOf(const std::string& image_format);

// Returns a message that says which image format to set if this one has no JPEG, else an empty text.
std::string RawFormatProblem(GphotoCamera& camera, const std::string& image_format);

// Selects where the camera stores photographs: on its card or in its memory (`to_card` none: on the card if
// it has free space). Returns true if they go to memory. Throws Refusal for a requested target that the
// camera does not offer, Error for one that it does not take.
bool ChooseTarget(GphotoCamera& camera, const std::string& uri, std::optional<bool> to_card);

// Returns whether a folder is in the camera's volatile memory: only files there are deleted after download.
bool IsInCameraMemory(const std::string& folder, bool target_is_memory);

// Belongs to the camera's thread.
class CameraSettings {
 public:
  // Finds the settings that the camera has. Errors name `uri`. `camera` must outlive this object.
  CameraSettings(GphotoCamera& camera, const std::string& uri);

  // Writes a setting and reads it back. Throws Refusal for a setting that the camera does not have, or, with
  // the choices, a value that it does not offer; Error if the camera does not keep the value.
  void Lock(ShotSetting setting, const std::string& value);
  // Sets the exposure program to manual if the camera allows it. Returns one message for each setting that
  // stays automatic and is not in `given`.
  std::vector<std::string> LockRemaining(const std::vector<ShotSetting>& given);

  // Reads all settings. Returns one message for each change since they were last read or written.
  std::vector<std::string> Changes();
  // Returns the value last read; empty if the camera has no such setting.
  std::string Value(ShotSetting setting) const;
  // Returns the values that the camera offers now; empty if it has no such setting, or takes any value.
  std::vector<std::string> Choices(ShotSetting setting) const;
  std::optional<double> Number(ShotSetting setting) const { return PhotographicNumber(Value(setting)); }

 private:
  struct Known {
    std::string name;  // in the driver
    std::string value;
  };
  GphotoCamera& camera_;
  std::string uri_;
  std::map<ShotSetting, Known> known_;
};

}  // namespace ulf::acquisition
