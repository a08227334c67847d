#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acquisition/device/device.h"
#include "acquisition/device/device_files.h"
#include "acquisition/link/link_check.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/subcommands.h"
#include "core/base/counted.h"
#include "core/base/stop_signal.h"

namespace ulf::commands {
namespace {

struct DevicesArgs {
  std::string check;
  double seconds = acquisition::LinkCheckOptions{}.seconds;
  bool json = false;
};

bool HasRealCamera(const std::vector<acquisition::DeviceInfo>& devices) {
  return std::ranges::any_of(devices,
                             [](const acquisition::DeviceInfo& info) { return info.bus != "simulated"; });
}

// Mentions missing udev rules only if they may be the reason: no camera is found, or one is not available.
std::optional<std::string> UdevHint(const std::vector<acquisition::DeviceInfo>& devices) {
  const bool all_available = std::ranges::all_of(devices, &acquisition::DeviceInfo::available);
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

std::string TrialInWords(const acquisition::LinkTrial& trial) {
  const std::string counts = trial.LostFrames()
                                 ? fmt::format("{} whole, {} incomplete, {} missing",
                                               Counted(trial.whole, "frame"), trial.incomplete, trial.missing)
                                 : fmt::format("{}, none lost", Counted(trial.whole, "frame"));
  return fmt::format("{:.1f} s at {:.1f} frames a second{}: {}{}", trial.seconds, trial.fps,
                     trial.TooSlow()          ? fmt::format(", {:g} asked for", trial.asked_fps)
                     : trial.BelowWhatIsSet() ? fmt::format(", the camera is set to {:g}", trial.set_fps)
                                              : "",
                     counts,
                     trial.resent_packets > 0
                         ? fmt::format(", {} sent again",
                                       Counted(static_cast<std::uint64_t>(trial.resent_packets), "packet"))
                         : "");
}

std::string Verdict(const acquisition::LinkReport& report) {
  if (report.trials.empty()) return "stopped before the first trial";
  if (!report.camera_limit.empty() && report.remedy)
    return fmt::format(
        "the camera is the limit, not the link: {}; nothing is lost with {}: give it in the URI",
        report.camera_limit, *report.remedy);
  if (report.remedy) return fmt::format("nothing is lost with {}: give it in the URI", *report.remedy);
  if (report.Holds())
    return report.camera_limit.empty()
               ? "the link carries what the camera sends"
               : fmt::format("the link carries what the camera sends, which is less than it is set to: {}",
                             report.camera_limit);
  if (report.trials.front().whole + report.trials.front().incomplete + report.trials.front().missing == 0)
    return "no frame came: does the camera wait for a trigger, or a firewall keep its packets out?";
  if (!report.camera_limit.empty())
    return fmt::format("the camera is the limit, not the link: {}", report.camera_limit);
  if (!report.trials.front().LostFrames())
    return "the camera does not send as many frames as asked for: a long exposure, its own limits or the "
           "link hold it back";
  return "frames are lost with every setting that was tried: check cables, plugs and switches, and what else "
         "uses the link; where a switch cannot hold a whole frame, packet_delay_ns spreads its packets";
}

void PrintLink(const acquisition::LinkReport& report) {
  const auto line = [](const std::string& name, const std::string& value) {
    fmt::print("{:<14} {}\n", name, value);
  };
  line("camera", fmt::format("{} {} (serial {}), {}", report.camera.maker, report.camera.model,
                             report.camera.serial, report.camera.bus));
  if (report.payload_bytes > 0)
    line("needs", fmt::format("{:.1f} MB/s: {:.0f} bytes a frame",
                              1e-6 * report.payload_bytes *
                                  std::max(report.trials.front().fps, report.trials.front().asked_fps),
                              report.payload_bytes));
  for (const acquisition::LinkFact& fact : report.facts) {
    line(fact.name, fact.value);
    if (!fact.advice.empty()) line("", fact.advice);
  }
  if (report.most_fps) line("carries", fmt::format("at most {:.1f} such frames a second", *report.most_fps));
  for (const acquisition::LinkTrial& trial : report.trials)
    line(trial.settings.empty() ? "as asked for" : trial.settings, TrialInWords(trial));
  line("result", Verdict(report));
}

void PrintLinkJson(const acquisition::LinkReport& report) {
  nlohmann::ordered_json json{{"uri", report.camera.uri}, {"serial", report.camera.serial},
                              {"bus", report.camera.bus}, {"payload_bytes", report.payload_bytes},
                              {"holds", report.Holds()},  {"remedy", nullptr},
                              {"most_fps", nullptr}};
  if (report.remedy) json["remedy"] = *report.remedy;
  if (!report.camera_limit.empty()) json["camera_limit"] = report.camera_limit;
  if (report.most_fps) json["most_fps"] = *report.most_fps;
  json["facts"] = nlohmann::ordered_json::array();
  for (const acquisition::LinkFact& fact : report.facts)
    json["facts"].push_back({{"name", fact.name}, {"value", fact.value}, {"advice", fact.advice}});
  json["trials"] = nlohmann::ordered_json::array();
  for (const acquisition::LinkTrial& trial : report.trials)
    json["trials"].push_back({{"settings", trial.settings},
                              {"seconds", trial.seconds},
                              {"fps", trial.fps},
                              {"set_fps", trial.set_fps},
                              {"whole", trial.whole},
                              {"incomplete", trial.incomplete},
                              {"missing", trial.missing},
                              {"resent_packets", trial.resent_packets}});
  json["verdict"] = Verdict(report);
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

int RunLinkCheck(const DevicesArgs& args) {
  const StopOnSignal signals;
  acquisition::LinkCheckOptions options;
  options.seconds = args.seconds;
  options.stop = [] { return StopOnSignal::Requested(); };
  options.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  const acquisition::LinkReport report = acquisition::CheckLink(args.check, options);
  args.json ? PrintLinkJson(report) : PrintLink(report);
  return report.Holds() && !report.remedy ? kOk : kFailed;
}

int RunDevices(const DevicesArgs& args) {
  if (!args.check.empty()) return RunLinkCheck(args);
  const std::vector<acquisition::DeviceInfo> devices = acquisition::ListDevices();
  args.json ? PrintJson(devices) : PrintTable(devices);
  return kOk;
}

}  // namespace

void AddDevicesCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "devices", "List every camera in reach, and why one cannot be used", RunDevices);
  CLI::Option* check =
      command->add_option("--check", args->check,
                          "Check the link to this camera: stream from it with these settings, and where "
                          "frames are lost find those that hold (exit code 1)");
  command->add_option("--seconds", args->seconds, "With --check: length of each trial")
      ->check(CLI::Range(0.5, 3600.0))
      ->needs(check)
      ->capture_default_str();
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf devices\nThen:    ulf devices --check 'aravis:192.168.1.20?fps=60'\n"
      "         ulf capture aravis:192.168.1.20 -o light_field");
}

}  // namespace ulf::commands
