#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acquisition/device/feature_file.h"
#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/output_path.h"

namespace ulf::commands {
namespace {

using Json = nlohmann::ordered_json;

struct FeaturesArgs {
  std::string uri;
  std::vector<std::string> settings;
  std::string save, load, filter;
  std::string visibility = "guru";
  bool json = false;
};

struct SetResult {
  acquisition::CameraFeature feature;  // as read back afterwards
  std::string wanted, before;
};

std::string Access(const acquisition::CameraFeature& feature) {
  if (feature.type == acquisition::FeatureType::kCommand) return feature.writable ? "execute" : "locked";
  return feature.readable && feature.writable ? "rw"
         : feature.readable                   ? "ro"
         : feature.writable                   ? "wo"
                                              : "not available";
}

Json JsonOf(const acquisition::CameraFeature& feature) {
  Json json{{"name", feature.name},   {"category", feature.category}, {"type", Name(feature.type)},
            {"value", feature.value}, {"readable", feature.readable}, {"writable", feature.writable}};
  if (feature.min) json["min"] = *feature.min;
  if (feature.max) json["max"] = *feature.max;
  if (feature.step) json["step"] = *feature.step;
  if (!feature.unit.empty()) json["unit"] = feature.unit;
  if (!feature.choices.empty()) json["choices"] = feature.choices;
  if (!feature.selects.empty()) json["selects"] = feature.selects;
  json["description"] = feature.description;
  json["visibility"] = Name(feature.visibility);
  json["streamable"] = feature.streamable;
  return json;
}

Json JsonOf(const acquisition::FeatureLoadSummary& summary) {
  Json refused = Json::array();
  for (const acquisition::FeatureRefusal& refusal : summary.refused)
    refused.push_back({{"name", refusal.wanted.Text()},
                       {"wanted", refusal.wanted.value},
                       {"reads", refusal.reads},
                       {"reason", refusal.reason}});
  return {{"taken", summary.taken},
          {"changed", summary.changed},
          {"rounds", summary.rounds},
          {"refused", refused}};
}

std::string NearestFeatures(acquisition::FeatureAccess& access, const std::string& name, bool only_writable) {
  std::vector<std::string> names;
  for (const acquisition::CameraFeature& feature : access.List())
    if (feature.writable || !only_writable) names.push_back(feature.name);
  return fmt::format("{}", fmt::join(acquisition::NearestNames(name, names), ", "));
}

[[noreturn]] void RefuseUnknown(acquisition::FeatureAccess& access, const std::string& uri,
                                const std::string& name, bool only_writable) {
  throw UsageError("{}: has no feature '{}'; nearest are {}", uri, name,
                   NearestFeatures(access, name, only_writable));
}

[[noreturn]] void RefuseReadOnly(acquisition::FeatureAccess& access, const std::string& uri,
                                 const acquisition::CameraFeature& feature) {
  throw UsageError("{}: {} cannot be written just now ({}); nearest that can are {}", uri, feature.name,
                   feature.readable ? "read-only, or locked by another setting" : "not available",
                   NearestFeatures(access, feature.name, true));
}

SetResult ApplySetting(acquisition::FeatureAccess& access, const std::string& uri, const std::string& name,
                       const std::string& value) {
  SetResult result{.feature = *access.Find(name), .wanted = value, .before = ""};
  if (!result.feature.writable) RefuseReadOnly(access, uri, result.feature);
  result.before = result.feature.value;
  access.Set(name, value);
  result.feature = *access.Find(name);
  return result;
}

// Throws before anything is written if a feature is unknown or always read-only. A locked one is checked in
// its turn, because an earlier setting may unlock it: ExposureAuto=Off ExposureTime=5000.
std::vector<SetResult> ApplySettings(acquisition::FeatureAccess& access, const std::string& uri,
                                     const std::vector<std::pair<std::string, std::string>>& settings) {
  for (const auto& [name, value] : settings) {
    const auto feature = access.Find(name);
    if (!feature) RefuseUnknown(access, uri, name, true);
    if (feature->read_only) RefuseReadOnly(access, uri, *feature);
  }
  std::vector<SetResult> results;
  std::string set;
  for (const auto& [name, value] : settings) {
    try {
      results.push_back(ApplySetting(access, uri, name, value));
    } catch (const Refusal& error) {
      if (set.empty()) throw;
      throw UsageError("{}; already set: {}", error.what(), set);
    } catch (const Error& error) {
      if (set.empty()) throw;
      throw Error("{}; already set: {}", error.what(), set);
    }
    set += fmt::format("{}{}={}", set.empty() ? "" : ", ", name, results.back().feature.value);
  }
  return results;
}

Json JsonOf(const acquisition::OfferedFormat& format) {
  Json json{{"name", format.name}, {"supported", format.supported}};
  if (!format.code.empty()) json["fourcc"] = format.code;
  if (format.width > 0) {
    json[format.any_size ? "max_width" : "width"] = format.width;
    json[format.any_size ? "max_height" : "height"] = format.height;
  }
  if (!format.fps.empty() && format.any_fps)
    json["fps_range"] = format.fps;
  else if (!format.fps.empty())
    json["fps"] = format.fps;
  return json;
}

// Prints a line for each size, with its rates: "YUYV  640x480 at 30, 15".
void PrintFormats(const std::vector<acquisition::OfferedFormat>& formats) {
  if (formats.empty()) return;
  fmt::print("formats (size, frames a second)\n");
  std::size_t name_width = 0;
  const auto name_of = [](const acquisition::OfferedFormat& format) {
    return format.name + (format.code.empty() || format.code == format.name ? "" : " (" + format.code + ")");
  };
  for (const acquisition::OfferedFormat& format : formats)
    name_width = std::max(name_width, name_of(format).size());
  std::string name;
  for (const acquisition::OfferedFormat& format : formats) {
    const std::string same = name_of(format) == name ? "" : name_of(format);
    name = name_of(format);
    std::string rates;
    for (const double fps : format.fps)
      rates += fmt::format("{}{:g}", rates.empty() ? "" : format.any_fps ? " to " : ", ", fps);
    fmt::print("  {:<{}}  {}\n", same, name_width,
               !format.supported ? "not read by ulf"
                                 : fmt::format("{}{}x{}{}", format.any_size ? "up to " : "", format.width,
                                               format.height, rates.empty() ? "" : " at " + rates));
  }
}

void PrintTree(const std::vector<acquisition::CameraFeature>& features) {
  std::size_t name_width = 4, value_width = 5;
  for (const acquisition::CameraFeature& feature : features) {
    name_width = std::max(name_width, feature.name.size());
    value_width = std::clamp(feature.value.size(), value_width, std::size_t{32});
  }
  std::string category = "\n";
  for (const acquisition::CameraFeature& feature : features) {
    if (feature.category != category) {
      category = feature.category;
      fmt::print("{}\n", category.empty() ? "(no category)" : category);
    }
    fmt::print("  {:<{}}  {:<{}}  {:<13}  {:<11}  {}\n", feature.name, name_width, feature.value, value_width,
               Access(feature), Name(feature.type), acquisition::RangeText(feature));
  }
}

void PrintInFull(const acquisition::CameraFeature& feature) {
  fmt::print("{}\n", feature.name);
  const auto line = [](const char* what, const std::string& text) {
    if (!text.empty()) fmt::print("  {:<12} {}\n", what, text);
  };
  line("value", feature.value + (feature.value.empty() || feature.unit.empty() ? "" : " " + feature.unit));
  line("type", Name(feature.type));
  line("takes", acquisition::RangeText(feature));
  line("access", Access(feature));
  line("category", feature.category);
  line("visibility", Name(feature.visibility));
  line("selects", fmt::format("{}", fmt::join(feature.selects, ", ")));
  line("about", feature.description);
}

void PrintLoad(const std::string& path, const acquisition::FeatureLoadSummary& summary) {
  fmt::print("{}: {} as in the file, {} of them changed, in {}\n", path, Counted(summary.taken, "feature"),
             summary.changed, Counted(summary.rounds, "round"));
  for (const acquisition::FeatureRefusal& refusal : summary.refused)
    fmt::print("  not taken: {}={} (reads {}){}\n", refusal.wanted.Text(), refusal.wanted.value,
               refusal.reads.empty() ? "nothing" : refusal.reads,
               refusal.reason.empty() ? "" : ": " + refusal.reason);
}

acquisition::FeatureVisibility ParseVisibility(const std::string& text) {
  for (const auto visibility :
       {acquisition::FeatureVisibility::kBeginner, acquisition::FeatureVisibility::kExpert,
        acquisition::FeatureVisibility::kGuru, acquisition::FeatureVisibility::kInvisible})
    if (text == Name(visibility)) return visibility;
  throw UsageError("--visibility {}: must be beginner, expert, guru or invisible", text);
}

int RunFeatures(const FeaturesArgs& args) {
  const acquisition::FeatureVisibility visibility = ParseVisibility(args.visibility);
  if (!args.save.empty()) RequireWritable(args.save);
  std::vector<std::string> names;
  std::vector<std::pair<std::string, std::string>> settings;
  for (const std::string& text : args.settings) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos)
      names.push_back(text);
    else
      settings.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  std::optional<acquisition::FeatureFile> file;
  if (!args.load.empty()) file = acquisition::ReadFeatureFile(args.load);

  const auto access = acquisition::OpenFeatures(args.uri);
  for (const std::string& name : names)
    if (!access->Find(name)) RefuseUnknown(*access, args.uri, name, false);
  const acquisition::DeviceInfo info = access->Info();
  Json json{{"device",
             {{"uri", info.uri},
              {"maker", info.maker},
              {"model", info.model},
              {"serial", info.serial},
              {"bus", info.bus}}}};
  int result = kOk;

  if (file) {
    const acquisition::FeatureLoadSummary summary = acquisition::ApplyFeatures(*file, *access);
    if (file->device.model != info.model)
      fmt::print(stderr, "{} was saved from a {} {}, this is a {} {}\n", args.load, file->device.maker,
                 file->device.model, info.maker, info.model);
    if (!summary.refused.empty()) result = kFailed;
    if (!args.json) PrintLoad(args.load, summary);
    json["load"] = JsonOf(summary);
  }
  json["set"] = Json::array();
  for (const SetResult& set : ApplySettings(*access, args.uri, settings)) {
    const bool matches = set.feature.type == acquisition::FeatureType::kCommand || !set.feature.readable ||
                         acquisition::SameValue(set.feature, set.feature.value, set.wanted);
    if (!args.json && set.feature.type == acquisition::FeatureType::kCommand)
      fmt::print("{} executed\n", set.feature.name);
    else if (!args.json)
      fmt::print("{} = {} (was {}){}\n", set.feature.name, set.feature.value, set.before,
                 matches ? "" : ": the camera changed " + set.wanted + " to this");
    json["set"].push_back({{"name", set.feature.name},
                           {"wanted", set.wanted},
                           {"value", set.feature.value},
                           {"before", set.before}});
  }
  if (!args.save.empty()) {
    const acquisition::FeatureFile saved = acquisition::CollectFeatures(*access);
    acquisition::WriteFeatureFile(args.save, saved);
    if (!args.json) fmt::print("{}: {} saved\n", args.save, Counted(saved.features.size(), "feature"));
    json["saved"] = {{"file", args.save}, {"features", saved.features.size()}};
  }

  const bool only_listing = args.settings.empty() && args.save.empty() && args.load.empty();
  std::vector<acquisition::CameraFeature> shown;
  for (const std::string& name : names) shown.push_back(*access->Find(name));
  if (only_listing || (args.json && settings.empty() && names.empty()) || !args.filter.empty())
    for (acquisition::CameraFeature& feature : access->List()) {
      const std::string everything = feature.name + " " + feature.category + " " + feature.description;
      if (feature.visibility <= visibility &&
          Lowercase(everything).find(Lowercase(args.filter)) != std::string::npos)
        shown.push_back(std::move(feature));
    }
  json["features"] = Json::array();
  for (const acquisition::CameraFeature& feature : shown) json["features"].push_back(JsonOf(feature));
  const bool show_formats = only_listing && args.filter.empty();
  const std::vector<acquisition::OfferedFormat> formats =
      show_formats ? access->Formats() : std::vector<acquisition::OfferedFormat>{};
  if (show_formats) {
    json["formats"] = Json::array();
    for (const acquisition::OfferedFormat& format : formats) json["formats"].push_back(JsonOf(format));
  }
  if (args.json) {
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
  } else if (!names.empty()) {
    for (const acquisition::CameraFeature& feature : shown) PrintInFull(feature);
  } else {
    PrintFormats(formats);
    PrintTree(shown);
    if (shown.empty() && !args.filter.empty())
      fmt::print("No feature's name, category or description contains '{}'.\n", args.filter);
  }
  return result;
}

}  // namespace

void AddFeaturesCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "features", "Show a camera's formats and settings; set these by name; keep them in a file",
      RunFeatures);
  command->add_option("URI", args->uri, "Camera, as 'ulf devices' lists it")->required();
  command->add_option("SETTING", args->settings,
                      "NAME shows one in full, NAME=VALUE sets it (a command: NAME=execute)");
  command->add_option("--save", args->save, "Save the settings in this file");
  command->add_option("--load", args->load,
                      "Set the values of this file and report those that the camera refuses");
  command->add_option("--filter", args->filter, "Show only features that contain this text");
  command
      ->add_option("--visibility", args->visibility, "Show features for: beginner, expert, guru or invisible")
      ->capture_default_str();
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf features aravis:192.168.1.20 --filter exposure\n"
      "         ulf features aravis:192.168.1.20 ExposureAuto=Off ExposureTime=5000\n"
      "         ulf features aravis:192.168.1.20 --save studio.json");
}

}  // namespace ulf::commands
