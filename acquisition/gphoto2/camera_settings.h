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
// Returns the choice that equals a value from the user; none if there is no such choice.
std::optional<std::string> ChoiceFor(const std::vector<std::string>& choices, const std::string& value);
// Returns the choice for manual operation; none if the setting has none.
std::optional<std::string> ManualChoice(const std::vector<std::string>& choices);
bool IsAutomatic(const std::string& value);

// The files of a photograph in this image format (as the camera names it).
struct PhotographFiles {
  bool raw = false, jpeg = true;
};
PhotographFiles FilesOf(const std::string& image_format);

// Returns a message that tells which image format to set when this one has no JPEG; empty when it has one.
std::string RawFormatProblem(GphotoCamera& camera, const std::string& image_format);

// Selects card or memory; `to_card` none: the card if there is one with free space. Returns true when
// photographs go to memory. Throws Refusal for a target that the camera does not offer, Error when it refuses
// one.
bool ChooseTarget(GphotoCamera& camera, const std::string& uri, std::optional<bool> to_card);

// Returns whether a file is in the camera's volatile memory, from which it is deleted after its download.
// Files on a card are never deleted.
bool IsInCameraMemory(const std::string& folder, bool target_is_memory);

class CameraSettings {
 public:
  // Finds the settings that the camera has. Errors name `uri`.
  CameraSettings(GphotoCamera& camera, const std::string& uri);

  // Writes a setting and reads it back. Throws Refusal, with the choices, for a value that the camera does
  // not offer; Error when the camera does not keep it.
  void Lock(ShotSetting setting, const std::string& value);
  // Sets the exposure program to manual if the camera allows it. Returns one message for each setting that
  // stays automatic and is not in `given`.
  std::vector<std::string> LockRemaining(const std::vector<ShotSetting>& given);

  // Reads all settings; one message for each change since the last call.
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
