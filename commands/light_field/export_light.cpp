#include "commands/light_field/export_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands/options/option_values.h"
#include "core/base/counted.h"
#include "core/base/lowercase.h"
#include "render/quality/evened_light.h"

namespace ulf::commands {
namespace {

// Returns the quality in "jpeg:95", or of "jpeg" alone that of `options`; 0 for anything else.
int QualityFrom(const std::string& format, int usual) {
  constexpr int kBest = 100;
  int quality = 0, end = 0;
  if (format == "jpeg") return usual;
  const bool is_whole = std::sscanf(format.c_str(), "jpeg:%d%n", &quality, &end) == 1 &&
                        static_cast<std::size_t>(end) == format.size();
  return is_whole && quality >= 1 && quality <= kBest ? quality : 0;
}

void SetFormat(const std::string& format, ExportOptions& options) {
  if (format.empty()) return;
  if (format == "exr") {
    options.format = PhotographFormat::kExr;
  } else if (format == "png16") {
    options.format = PhotographFormat::kPng16;
  } else if (const int quality = QualityFrom(format, options.jpeg_quality); quality > 0) {
    options.format = PhotographFormat::kJpeg;
    options.jpeg_quality = quality;
  } else {
    throw UsageError("--format {}: there are exr, png16 and jpeg:QUALITY, from 1 to 100, such as jpeg:95",
                     format);
  }
}

// Trainers take a part that is missing for 1, so that photographs with and without it contradict each other.
std::string MixedFacts(const ExposureCounts& said, std::size_t views) {
  const auto is_mixed = [&](std::size_t some) { return some > 0 && some < views; };
  if (!is_mixed(said.times) && !is_mixed(said.f_numbers) && !is_mixed(said.isos)) return {};
  return fmt::format(
      "{} of {} have an exposure time, {} an f-number, {} an ISO speed: trainers take what is missing for 1 "
      "and get these photographs' exposure wrong; --light even needs none",
      said.times, Counted(views, "photograph"), said.f_numbers, said.isos);
}

bool AreJpeg(const LightField& light_field, const ExportOptions& options, const ExportSummary& summary) {
  const auto is_jpeg = [](const View& view) {
    const std::string ending = Lowercase(std::filesystem::path(view.image_path).extension().string());
    return ending == ".jpg" || ending == ".jpeg";
  };
  return options.format == PhotographFormat::kJpeg ||
         (summary.made == 0 && std::ranges::all_of(light_field.views, is_jpeg));
}

std::vector<std::string> ExifWords(const LightField& light_field, const ExportOptions& options,
                                   const ExportSummary& summary) {
  const std::size_t views = light_field.views.size();
  std::vector<std::string> words{fmt::format("exposures: {} of {} say theirs", summary.exposures.photographs,
                                             Counted(views, "photograph"))};
  if (summary.exposures.photographs < views)
    words.emplace_back("of the others none is known, or they are neither JPEG, PNG nor EXR");
  if (const std::string mixed = MixedFacts(summary.exposures, views); !mixed.empty()) words.push_back(mixed);
  if (!AreJpeg(light_field, options, summary) && summary.exposures.photographs > 0)
    words.emplace_back(
        "gsplat's examples, 3dgrut and Spirula read exposures from JPEG alone: --format jpeg:95 writes them");
  return words;
}

std::size_t SensorColors(const LightField& light_field) {
  return static_cast<std::size_t>(
      std::ranges::count_if(light_field.views, [](const View& view) { return !HasRec709Colors(view); }));
}

}  // namespace

void AddLightOptions(CLI::App& form, LightArgs& args, bool has_format) {
  OfferValues(
      form.add_option("--light", args.light,
                      "Photographs as recorded (raw), with their exposures in them (exif), or evened: "
                      "exposure, white balance, vignetting (even); default raw"),
      "raw,even,exif");
  if (has_format)
    OfferValues(
        form.add_option("--format", args.format,
                        "Photographs as linear light in EXR, PNG of 16 bits, or JPEG of a quality: exr, "
                        "png16, jpeg:95 (default: as they are)"),
        "exr,png16,jpeg:95");
}

std::function<std::vector<std::string>(const ExportSummary& summary)> SetLight(const LightArgs& args,
                                                                               const LightField& light_field,
                                                                               ExportOptions& options) {
  SetFormat(args.format, options);
  std::vector<std::string> words;
  if (const std::size_t sensor = SensorColors(light_field);
      options.format == PhotographFormat::kExr && sensor > 0 &&
      (args.light != "even" || light_field.color_profiles.empty()))
    words.push_back(
        fmt::format("the colours of {} are the sensor's own, so their EXR names none; ulf calibrate "
                    "measures a colour profile, which --light even applies",
                    Counted(sensor, "photograph")));
  if (args.light == "raw") return [words](const ExportSummary&) { return words; };
  if (args.light == "exif") {
    options.with_exposures = true;
    return [words, options, &light_field](const ExportSummary& summary) {
      std::vector<std::string> all = ExifWords(light_field, options, summary);
      all.insert(all.end(), words.begin(), words.end());
      return all;
    };
  }
  if (args.light != "even") throw UsageError("--light {}: there are raw, even and exif", args.light);
  const auto light = std::make_shared<render::EvenedLight>(light_field);
  options.even_light = [light](const View& view) { return light->Of(view); };
  return [words, light](const ExportSummary&) {
    std::vector<std::string> all = light->Words();
    all.insert(all.end(), words.begin(), words.end());
    return all;
  };
}

}  // namespace ulf::commands
