#include "acquisition/v4l2/v4l2_controls.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr int kMostControls = 1000;  // against a driver whose list does not end; guessed

struct ShortName {
  std::uint32_t id;
  const char* name;
};
constexpr std::array kShortNames = {
    ShortName{V4L2_CID_EXPOSURE_ABSOLUTE, "exposure"},
    ShortName{V4L2_CID_GAIN, "gain"},
    ShortName{V4L2_CID_WHITE_BALANCE_TEMPERATURE, "white_balance"},
    ShortName{V4L2_CID_FOCUS_ABSOLUTE, "focus"},
    ShortName{V4L2_CID_ZOOM_ABSOLUTE, "zoom"},
    ShortName{V4L2_CID_EXPOSURE_AUTO, "auto_exposure"},
    ShortName{V4L2_CID_AUTOGAIN, "auto_gain"},
    ShortName{V4L2_CID_AUTO_WHITE_BALANCE, "auto_white_balance"},
    ShortName{V4L2_CID_FOCUS_AUTO, "auto_focus"},
};

struct AutomaticControl {
  std::uint32_t id;
  int off;               // the value that switches it off
  std::uint32_t target;  // the control that it changes; 0: none that can be read
};
constexpr std::array kAutomaticControls = {
    AutomaticControl{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, V4L2_CID_EXPOSURE_ABSOLUTE},
    AutomaticControl{V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0, 0},  // lowers the frame rate for a longer exposure
    AutomaticControl{V4L2_CID_AUTOGAIN, 0, V4L2_CID_GAIN},
    AutomaticControl{V4L2_CID_AUTO_WHITE_BALANCE, 0, V4L2_CID_WHITE_BALANCE_TEMPERATURE},
    AutomaticControl{V4L2_CID_AUTO_N_PRESET_WHITE_BALANCE, V4L2_WHITE_BALANCE_MANUAL, 0},
    AutomaticControl{V4L2_CID_FOCUS_AUTO, 0, V4L2_CID_FOCUS_ABSOLUTE},
    AutomaticControl{V4L2_CID_HUE_AUTO, 0, V4L2_CID_HUE},
    AutomaticControl{V4L2_CID_AUTOBRIGHTNESS, 0, V4L2_CID_BRIGHTNESS},
    AutomaticControl{V4L2_CID_CHROMA_AGC, 0, V4L2_CID_CHROMA_GAIN},
    AutomaticControl{V4L2_CID_ISO_SENSITIVITY_AUTO, V4L2_ISO_SENSITIVITY_MANUAL, V4L2_CID_ISO_SENSITIVITY},
};

// Converts "Exposure Time, Absolute" to "exposure_time_absolute".
std::string NameOf(const std::string& title) {
  std::string name;
  for (const char letter : title) {
    if (std::isalnum(static_cast<unsigned char>(letter)))
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (name.ends_with('_')) name.pop_back();
  return name;
}

void FillMenu(const V4l2Node& node, V4l2Control& control) {
  for (int i = control.min; i <= control.max; ++i) {
    v4l2_querymenu entry{};
    entry.id = control.id;
    entry.index = static_cast<std::uint32_t>(i);
    if (node.Call(VIDIOC_QUERYMENU, &entry) != 0) continue;  // menus have holes
    control.menu.emplace_back(i, control.type == V4L2_CTRL_TYPE_MENU
                                     ? V4l2Text(entry.name, sizeof entry.name)
                                     : fmt::format("{}", static_cast<long long>(entry.value)));
  }
}

const V4l2Control* Find(const std::vector<V4l2Control>& controls, std::uint32_t id) {
  for (const V4l2Control& control : controls)
    if (control.id == id) return &control;
  return nullptr;
}

bool HasChoice(const V4l2Control& control, int value) {
  return std::any_of(control.menu.begin(), control.menu.end(),
                     [value](const auto& entry) { return entry.first == value; });
}

const char* RefusalText(int error) {
  if (error == 0) return "the driver does not switch it off";
  if (error == EBUSY) return "another control or program locks it";
  return error == EACCES ? "it cannot be written now" : std::strerror(error);
}

}  // namespace

std::vector<V4l2Control> V4l2Controls(const V4l2Node& node) {
  std::vector<V4l2Control> controls;
  std::string category = "User Controls";
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (int i = 0; i < kMostControls && node.Call(VIDIOC_QUERYCTRL, &query) == 0; ++i) {
    const std::string title = V4l2Text(query.name, sizeof query.name);
    if (query.type == V4L2_CTRL_TYPE_CTRL_CLASS) category = title;
    const bool is_number = query.type == V4L2_CTRL_TYPE_INTEGER || query.type == V4L2_CTRL_TYPE_BOOLEAN ||
                           query.type == V4L2_CTRL_TYPE_MENU || query.type == V4L2_CTRL_TYPE_INTEGER_MENU ||
                           query.type == V4L2_CTRL_TYPE_BITMASK || query.type == V4L2_CTRL_TYPE_BUTTON;
    if (is_number && !(query.flags & V4L2_CTRL_FLAG_DISABLED)) {
      V4l2Control control{.id = query.id,
                          .name = NameOf(title),
                          .short_name = "",
                          .title = title,
                          .category = category,
                          .type = query.type,
                          .flags = query.flags,
                          .min = query.minimum,
                          .max = query.maximum,
                          .step = std::max(query.step, 1),
                          .standard = query.default_value,
                          .menu = {}};
      for (const ShortName& known : kShortNames)
        if (known.id == query.id) control.short_name = known.name;
      if (control.IsMenu()) FillMenu(node, control);
      controls.push_back(std::move(control));
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return controls;
}

std::optional<int> GetV4l2Control(const V4l2Node& node, std::uint32_t id) {
  v4l2_control control{};
  control.id = id;
  if (node.Call(VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
  return control.value;
}

int SetV4l2Control(const V4l2Node& node, std::uint32_t id, int value) {
  v4l2_control control{};
  control.id = id;
  control.value = value;
  return node.Call(VIDIOC_S_CTRL, &control);
}

std::string V4l2ControlText(const V4l2Control& control, int value) {
  for (const auto& [number, words] : control.menu)
    if (number == value) return words;
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN) return value ? "true" : "false";
  return fmt::format("{}", value);
}

int V4l2ControlValue(const std::string& who, const V4l2Control& control, const std::string& text) {
  for (const auto& [number, words] : control.menu)
    if (text == words || NameOf(text) == NameOf(words)) return number;
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN) {
    if (text == "true" || text == "on" || text == "yes") return 1;
    if (text == "false" || text == "off" || text == "no") return 0;
  }
  char* end = nullptr;
  errno = 0;
  const long number = std::strtol(text.c_str(), &end, 0);
  const bool is_number = !text.empty() && *end == '\0' && errno == 0;
  if (control.IsMenu()) {
    if (is_number && HasChoice(control, static_cast<int>(number))) return static_cast<int>(number);
    std::string choices;
    for (const auto& [value, words] : control.menu)
      choices += fmt::format("{}{} ({})", choices.empty() ? "" : ", ", words, value);
    throw Refused(who, fmt::format("{} cannot be '{}'", control.name, text),
                  fmt::format("it takes {}", choices));
  }
  if (!is_number || number < control.min || number > control.max ||
      (control.type == V4L2_CTRL_TYPE_INTEGER && (number - control.min) % control.step != 0))
    throw Refused(who, fmt::format("{} cannot be '{}'", control.name, text),
                  fmt::format("it takes {} to {}{}", control.min, control.max,
                              control.step > 1 ? fmt::format(" in steps of {}", control.step) : ""));
  return static_cast<int>(number);
}

V4l2Frozen FreezeV4l2Automatics(const V4l2Node& node, const std::vector<V4l2Control>& controls,
                                const std::vector<std::string>& except) {
  V4l2Frozen frozen;
  for (const AutomaticControl& automatic : kAutomaticControls) {
    const V4l2Control* control = Find(controls, automatic.id);
    if (!control || std::any_of(except.begin(), except.end(),
                                [&](const std::string& name) { return control->Answers(name); }))
      continue;
    int off = automatic.off;
    // A camera without a manual mode may still keep its exposure time and change something else.
    if (automatic.id == V4L2_CID_EXPOSURE_AUTO && !HasChoice(*control, off))
      off = V4L2_EXPOSURE_SHUTTER_PRIORITY;
    if (GetV4l2Control(node, automatic.id) == off) continue;
    const V4l2Control* target = automatic.target ? Find(controls, automatic.target) : nullptr;
    const auto reached = target ? GetV4l2Control(node, target->id) : std::nullopt;
    const int error = SetV4l2Control(node, automatic.id, off);
    if (error != 0 || GetV4l2Control(node, automatic.id).value_or(off) != off) {
      frozen.refused.push_back(fmt::format("{} stays on ({}): pictures may change between views",
                                           control->name, RefusalText(error)));
      continue;
    }
    std::string message = control->name + " off";
    if (reached) {
      SetV4l2Control(node, target->id, *reached);
      if (const auto held = GetV4l2Control(node, target->id)) {
        frozen.values.emplace_back(target->name, *held);
        message += fmt::format(", {} held at {}", target->name, V4l2ControlText(*target, *held));
      }
    }
    frozen.held.push_back(std::move(message));
  }
  return frozen;
}

HeldAutomatics HeldV4l2Automatics(const V4l2Node& node, const std::vector<V4l2Control>& controls) {
  const auto off = [&](std::uint32_t id, int value_off) -> std::optional<bool> {
    if (!Find(controls, id)) return std::nullopt;
    const auto value = GetV4l2Control(node, id);
    return value ? std::optional(*value == value_off) : std::nullopt;
  };
  HeldAutomatics held{.exposure = off(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL),
                      .white_balance = off(V4L2_CID_AUTO_WHITE_BALANCE, 0),
                      .focus = off(V4L2_CID_FOCUS_AUTO, 0)};
  if (const auto gain = off(V4L2_CID_AUTOGAIN, 0)) held.exposure = held.exposure.value_or(true) && *gain;
  return held;
}

double V4l2ExposureSeconds(const V4l2Node& node, const std::vector<V4l2Control>& controls) {
  constexpr double kStepSeconds = 100e-6;  // V4L2's unit of exposure
  if (!Find(controls, V4L2_CID_EXPOSURE_ABSOLUTE)) return 0;
  if (Find(controls, V4L2_CID_EXPOSURE_AUTO)) {
    const auto mode = GetV4l2Control(node, V4L2_CID_EXPOSURE_AUTO);
    if (mode != V4L2_EXPOSURE_MANUAL && mode != V4L2_EXPOSURE_SHUTTER_PRIORITY) return 0;
  }
  const auto steps = GetV4l2Control(node, V4L2_CID_EXPOSURE_ABSOLUTE);
  return steps ? kStepSeconds * *steps : 0;
}

}  // namespace ulf::acquisition
