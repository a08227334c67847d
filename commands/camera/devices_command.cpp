#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/device/device.h"
#include "acquisition/device/udev_rules.h"
#include "commands/commands.h"

namespace ulf::commands {
namespace {

struct DevicesArgs {
  bool json = false;
};

bool HasRealCamera(const std::vector<acquisition::DeviceInfo>& devices) {
  return std::any_of(devices.begin(), devices.end(),
                     [](const acquisition::DeviceInfo& info) { return info.bus != "simulated"; });
}

// Mentions missing udev rules only where they may be the reason: no camera is found, or one is not available.
std::optional<std::string> UdevHint(const std::vector<acquisition::DeviceInfo>& devices) {
  const bool all_available = std::all_of(devices.begin(), devices.end(),
                                         [](const acquisition::DeviceInfo& info) { return info.available; });
  if (all_available && HasRealCamera(devices)) return std::nullopt;
  return acquisition::MissingUdevRulesHintForThisUser();
}

void PrintJson(const std::vector<acquisition::DeviceInfo>& devices) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const acquisition::DeviceInfo& info : devices)
    list.push_back({{"uri", info.uri},
                    {"maker", info.maker},
                    {"model", info.model},
                    {"serial", info.serial},
                    {"bus", info.bus},
                    {"available", info.available},
                    {"problem", info.problem},
                    {"remark", info.remark}});
  nlohmann::ordered_json json{{"devices", list}};
  if (const auto hint = UdevHint(devices)) json["hint"] = *hint;
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

std::string StateText(const acquisition::DeviceInfo& info) {
  if (!info.available) return "not available: " + info.problem;
  return info.remark.empty() ? "ready" : "ready, but " + info.remark;
}

void PrintTable(const std::vector<acquisition::DeviceInfo>& devices) {
  std::size_t uri_width = 3, camera_width = 6, bus_width = 3;
  const auto camera_of = [](const acquisition::DeviceInfo& info) {
    return info.maker + " " + info.model + (info.serial.empty() ? "" : " (serial " + info.serial + ")");
  };
  for (const acquisition::DeviceInfo& info : devices) {
    uri_width = std::max(uri_width, info.uri.size());
    camera_width = std::max(camera_width, camera_of(info).size());
    bus_width = std::max(bus_width, info.bus.size());
  }
  fmt::print("{:<{}}  {:<{}}  {:<{}}  STATE\n", "URI", uri_width, "CAMERA", camera_width, "BUS", bus_width);
  for (const acquisition::DeviceInfo& info : devices)
    fmt::print("{:<{}}  {:<{}}  {:<{}}  {}\n", info.uri, uri_width, camera_of(info), camera_width, info.bus,
               bus_width, StateText(info));
  if (!HasRealCamera(devices))
    fmt::print(
        "No real camera answers: searched for GigE Vision on every network, USB3 Vision, tethered cameras "
        "and webcams. Check power, cable and firewall (UDP port 3956); a camera behind a router opens by "
        "address, aravis:192.0.2.7.\n");
  if (const auto hint = UdevHint(devices)) fmt::print("{}\n", *hint);
}

int RunDevices(const DevicesArgs& args) {
  const std::vector<acquisition::DeviceInfo> devices = acquisition::ListDevices();
  args.json ? PrintJson(devices) : PrintTable(devices);
  return kOk;
}

}  // namespace

void AddDevicesCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<DevicesArgs>();
  CLI::App* command = app.add_subcommand("devices", "List every camera in reach, and why one cannot be used");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf devices\nThen:    ulf capture aravis:192.168.1.20 -o light_field");
  command->callback([args, &chosen] { chosen = [args] { return RunDevices(*args); }; });
}

}  // namespace ulf::commands
