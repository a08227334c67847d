// Reads and sets a webcam's controls by name (exposure, gain, white balance, focus and all others of its
// driver), and switches off its automatics, which must not change the picture between two views.
//
// Names are the driver's titles in lower case with underscores, as v4l2-ctl shows them. Because they differ
// between kernel versions, the common ones also have a fixed short name: exposure (in steps of 100 us), gain,
// white_balance (kelvin), focus, zoom, auto_exposure, auto_gain, auto_white_balance, auto_focus.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/v4l2/v4l2_node.h"

namespace ulf::acquisition {

struct V4l2Control {
  std::uint32_t id = 0;
  std::string name;        // "exposure_time_absolute"
  std::string short_name;  // "exposure"; empty for most
  std::string title, category;
  std::uint32_t type = 0, flags = 0;              // V4L2_CTRL_TYPE_..., V4L2_CTRL_FLAG_...
  int min = 0, max = 0, step = 1, standard = 0;   // `standard`: the driver's default value
  std::vector<std::pair<int, std::string>> menu;  // values and their texts

  bool IsMenu() const { return type == V4L2_CTRL_TYPE_MENU || type == V4L2_CTRL_TYPE_INTEGER_MENU; }
  bool Answers(const std::string& wanted) const { return wanted == name || wanted == short_name; }
};

// Returns the controls of up to 32 bits that a user can set, in the driver's order.
std::vector<V4l2Control> V4l2Controls(const V4l2Node& node);

std::optional<int> GetV4l2Control(const V4l2Node& node, std::uint32_t id);
// Returns 0, or the error number.
int SetV4l2Control(const V4l2Node& node, std::uint32_t id, int value);

// Returns the number that a text stands for: of a menu "Manual Mode", "manual_mode" or "1", of a switch
// "true" or "on". Throws Refusal that begins with `who` and names the range or the choices.
int V4l2ControlValue(const std::string& who, const V4l2Control& control, const std::string& text);
// Returns a value as text: the menu's entry, "true", "false", or the number.
std::string V4l2ControlText(const V4l2Control& control, int value);

struct V4l2Frozen {
  std::vector<std::string> held;                    // "auto_exposure off, exposure_time_absolute held at 156"
  std::vector<std::pair<std::string, int>> values;  // the values held: {"exposure_time_absolute", 156}
  std::vector<std::string> refused;                 // "auto_focus stays on: ..."
};
// Switches off every automatic that is on and not in `except` (names), and writes back its last value.
V4l2Frozen FreezeV4l2Automatics(const V4l2Node& node, const std::vector<V4l2Control>& controls,
                                const std::vector<std::string>& except);

// Returns the state of the automatics at this moment.
HeldAutomatics HeldV4l2Automatics(const V4l2Node& node, const std::vector<V4l2Control>& controls);

// Returns the exposure time in seconds, read back; 0 when it is automatic or unknown.
double V4l2ExposureSeconds(const V4l2Node& node, const std::vector<V4l2Control>& controls);

}  // namespace ulf::acquisition
