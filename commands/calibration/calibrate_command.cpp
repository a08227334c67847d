// `ulf calibrate`: estimates intrinsics from a board, the flat field from a card, or colours from a chart or
// a grey card.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/calibration_picture.h"
#include "commands/calibration/calibrate_source.h"
#include "commands/calibration/calibration_report.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/stop_signal.h"
#include "core/geometry/sensor_window.h"
#include "core/image/clipped.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/raw_file.h"
#include "core/image/image.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<Image> Cards(const CalibrateArgs& args, CalibrationSource& source, double& black_level) {
  std::vector<Image> cards;
  if (source.device) {
    Progress progress("looking at the card", args.json);
    for (Frame& frame :
         acquisition::CollectFrames(*source.device, args.frames, CaptureOptions(args, progress))) {
      black_level = frame.black_level;
      cards.push_back(std::move(frame.image));
    }
    return cards;
  }
  for (const std::string& file : source.files) {
    Image card{ReadImageFile(file), TransferOfFile(file)};
    if (card.pixels.depth() == CV_32F) card.transfer = Transfer::kLinear;
    cards.push_back(std::move(card));
  }
  return cards;
}

Json FlatFieldJson(const FlatFieldResult& result, const std::string& file) {
  return {{"file", file},
          {"refusal", result.refusal},
          {"model", result.model},
          {"corner_light_bgr", result.corner_bgr},
          {"residual", result.residual},
          {"gradient", result.gradient},
          {"dust", result.dust},
          {"frames", result.frames}};
}

std::string FlatFieldText(const FlatFieldResult& result) {
  if (!result.ok()) return "refused: " + result.refusal + "\n";
  std::string text = fmt::format(
      "model            {}\ncorners          {:.1f} % of the light in the middle (darkest of B, G, R)\n",
      result.model, 100 * std::min({result.corner_bgr[0], result.corner_bgr[1], result.corner_bgr[2]}));
  text += fmt::format("residual         {:.2f} %, lighting falls off by {:.1f} % over the card\n",
                      100 * result.residual, 100 * result.gradient);
  if (result.dust > 0)
    text += fmt::format(
        "warning          {} dark spots: clean the sensor and the lens, and take the card again\n",
        result.dust);
  return text;
}

// Throws Error if the cards are of another camera, or another part of its sensor, than the calibration.
void RequireAsCalibrated(const CalibrationSource& source, const acquisition::CalibrationFile& file,
                         const acquisition::ModeCalibration& mode, const std::vector<Image>& cards,
                         const std::string& output) {
  if (!source.identity.serial.empty() && !file.identity.serial.empty() &&
      source.identity.serial != file.identity.serial)
    throw Error("{}: belongs to serial '{}', this camera has '{}'; name its own file", output,
                file.identity.serial, source.identity.serial);
  if (source.window && mode.window && *source.window != *mode.window)
    throw Error(
        "{}: was calibrated with {}, the camera is set to {}: the flat field would be at the wrong place; "
        "set region and binning as in the calibration",
        output, Describe(*mode.window), Describe(*source.window));
  if (!cards.empty() && (cards[0].width() != mode.camera.width || cards[0].height() != mode.camera.height))
    throw Error("{}: the frames are {}x{}, the calibration is for {}x{}; set the camera as it was calibrated",
                output, cards[0].width(), cards[0].height(), mode.camera.width, mode.camera.height);
}

int RunFlatField(const CalibrateArgs& args) {
  CalibrationSource source = OpenCalibrationSource(args);
  const std::string output = CalibrationOutput(args, source);
  RequireReportFolder(args);
  if (!fs::exists(output))
    throw Error("{}: the flat field is stored with a camera's intrinsics: calibrate it with a board first",
                args.output.empty() && source.identity.serial.empty() ? "-o FILE is missing" : output);
  acquisition::CalibrationFile file = acquisition::ReadCalibrationFile(output);
  acquisition::ModeCalibration mode = acquisition::ModeOf(file, args.mode, output);
  RequireAsCalibrated(source, file, mode, {}, output);
  const StopOnSignal stop_on_signal;
  double black_level = 0;
  const std::vector<Image> cards = Cards(args, source, black_level);
  RequireAsCalibrated(source, file, mode, cards, output);
  const FlatFieldResult result = EstimateFlatField(cards, black_level);
  const std::string text = FlatFieldText(result);
  if (!args.report.empty()) {
    const fs::path folder = args.report;
    WriteFileAtomically(folder / "flat_field.txt", text);
    WriteFileAtomically(folder / "flat_field.json",
                        FlatFieldJson(result, result.ok() ? output : "").dump(2) + "\n");
    if (result.ok())
      WriteFileAtomically(folder / "flat_field.png", PngBytes(acquisition::DrawFlatField(result)));
  }
  if (args.json) fmt::print("{}\n", FlatFieldJson(result, result.ok() ? output : "").dump(2));
  if (!result.ok()) throw Error("no flat field: {}{}", source.RetakeAdvice(), result.refusal);
  mode.flat_field = result.flat_field;
  file.modes[args.mode] = mode;
  acquisition::WriteCalibrationFile(output, file);
  if (!args.json)
    fmt::print("{}\n{}: flat field written from {}, mode {}\n", text, output, Counted(result.frames, "frame"),
               args.mode);
  return kOk;
}

// ---- Colours ----

// A picture of a chart or card, in the form that a light field's readers see.
struct ColorPicture {
  Image image;
  double black_level = 0;
  cv::Mat clipped;
  std::optional<WhiteBalance> developed_by;  // for a raw file
};

// The white balance of the first raw file develops all of them.
class ColorPictures {
 public:
  void AddRaw(const std::string& bytes, const std::string& name) {
    if (!developed_by_) developed_by_ = RawFactsOf(bytes, name).white_balance;
    ColorPicture picture{.image = {}, .black_level = 0, .clipped = {}, .developed_by = developed_by_};
    picture.image = {
        DecodeRaw(bytes, name, RawQuality::kBest, std::nullopt, developed_by_, &picture.clipped).light,
        Transfer::kLinear};
    pictures_.push_back(std::move(picture));
  }
  void Add(const Image& image, double black_level) {
    pictures_.push_back({image, black_level, ClippedPixels(image), std::nullopt});
  }
  std::vector<ColorPicture> Take() { return std::move(pictures_); }

 private:
  std::optional<WhiteBalance> developed_by_;
  std::vector<ColorPicture> pictures_;
};

std::vector<ColorPicture> PicturesOf(const CalibrateArgs& args, CalibrationSource& source) {
  ColorPictures pictures;
  if (source.device) {
    Progress progress(args.grey ? "looking at the card" : "looking at the chart", args.json);
    for (const Frame& frame :
         acquisition::CollectFrames(*source.device, args.frames, CaptureOptions(args, progress))) {
      if (frame.raw)
        pictures.AddRaw(*frame.raw->bytes, source.name);
      else
        pictures.Add(frame.image, frame.black_level);
    }
    return pictures.Take();
  }
  for (const std::string& file : source.files) {
    if (IsRawFile(file)) {
      pictures.AddRaw(ReadWholeFile(file), file);
      continue;
    }
    Image image{ReadImageFile(file), TransferOfFile(file)};
    if (image.pixels.depth() == CV_32F) image.transfer = Transfer::kLinear;
    pictures.Add(image, 0);
  }
  return pictures.Take();
}

void WarnOfEncodedColours(const std::vector<ColorPicture>& pictures, FrameSource source) {
  if (std::ranges::any_of(pictures, [](const ColorPicture& picture) {
        return picture.image.transfer == Transfer::kSrgb && picture.image.pixels.channels() == 3;
      }))
    spdlog::warn(
        "the camera encodes these pictures for displays, with its own white balance, contrast and "
        "saturation: the profile holds as long as all of these stay as they are{}",
        IsTaken(source) ? "" : fmt::format("; lock them ({}), or take raw pictures", WhereToSet(source)));
}

// Returns the profile of these pictures; throws Error if there is none. `kept` is the camera's former
// profile.
ColorProfile ProfileOf(const CalibrateArgs& args, const CalibrationSource& source,
                       const std::vector<ColorPicture>& pictures, const std::string& output,
                       const std::optional<ColorProfile>& kept) {
  const auto report = [&](const Json& json, const std::string& text, const char* name) {
    if (!args.report.empty()) {
      WriteFileAtomically(fs::path(args.report) / fmt::format("{}.txt", name), text);
      WriteFileAtomically(fs::path(args.report) / fmt::format("{}.json", name), json.dump(2) + "\n");
    }
    if (args.json)
      fmt::print("{}\n", json.dump(2));
    else
      fmt::print("{}", text);
  };
  if (args.grey) {
    const ColorPicture& picture = pictures.front();
    const acquisition::GreyCard card =
        acquisition::BalanceOfGreyCard(picture.image, picture.black_level, picture.clipped);
    Json json = GreyCardJson(card);
    json["file"] = card.ok() ? output : "";
    report(json, card.ok() ? GreyCardText(card) : "", "grey_card");
    if (!card.ok()) throw Error("no white balance: {}{}", source.RetakeAdvice(), card.refusal);
    // The matrix belongs to the camera and holds for every lamp.
    ColorProfile profile = kept.value_or(ColorProfile{});
    profile.white_balance = card.white_balance;
    profile.delta_e.reset();  // it was measured under another lamp
    profile.source = kept ? kept->source + ", white balance of a grey card" : "grey card";
    return profile;
  }
  std::vector<acquisition::MeasuredChart> charts;
  for (const ColorPicture& picture : pictures)
    if (const auto chart = acquisition::FindColorChart(picture.image, picture.black_level, picture.clipped))
      charts.push_back(*chart);
  const acquisition::ColorFit fit = acquisition::FitColorProfile(charts);
  Json json = ColorFitJson(fit, charts.size(), pictures.size());
  json["file"] = fit.ok() ? output : "";
  report(json, fit.ok() ? ColorFitText(fit, charts.size(), pictures.size()) : "", "colours");
  if (!fit.ok()) throw Error("no colour profile: {}{}", source.RetakeAdvice(), fit.refusal);
  ColorProfile profile = fit.profile;
  profile.source = fmt::format("chart of 24 patches, {} of them used", fit.patches.size());
  return profile;
}

int RunColorProfile(const CalibrateArgs& args) {
  if (args.colour && args.grey) throw UsageError("--colour and --grey: one at a time");
  CalibrationSource source = OpenCalibrationSource(args);
  const std::string output = CalibrationOutput(args, source);
  RequireReportFolder(args);
  if (!fs::exists(output))
    throw Error("{}: colours are stored with a camera's intrinsics: calibrate it with a board first",
                args.output.empty() && source.identity.serial.empty() ? "-o FILE is missing" : output);
  acquisition::CalibrationFile file = acquisition::ReadCalibrationFile(output);
  acquisition::ModeCalibration mode = acquisition::ModeOf(file, args.mode, output);
  RequireAsCalibrated(source, file, mode, {}, output);
  const StopOnSignal stop_on_signal;
  std::vector<ColorPicture> pictures = PicturesOf(args, source);
  if (pictures.empty()) throw Error("{}: gave no picture; check the camera (ulf devices)", source.name);
  const bool is_raw = pictures.front().developed_by.has_value();
  if (std::ranges::any_of(pictures,
                          [&](const ColorPicture& p) { return p.developed_by.has_value() != is_raw; }))
    throw UsageError("{}: raw files and others together; a profile is of one kind", source.name);
  if (std::ranges::any_of(pictures, [](const ColorPicture& p) {
        return p.image.pixels.channels() == 1 && p.image.mosaic == Mosaic::kNone;
      }))
    throw Error("{}: the pictures are grey; {}", source.name,
                IsTaken(source.Frames())
                    ? "give pictures in colour"
                    : "choose a colour pixel format (ulf features, or ?format= in the URI)");
  WarnOfEncodedColours(pictures, source.Frames());
  if (mode.flat_field) {
    std::vector<Image> images;
    for (const ColorPicture& picture : pictures) images.push_back(picture.image);
    RequireAsCalibrated(source, file, mode, images, output);
    for (ColorPicture& picture : pictures)
      picture.image = mode.flat_field->Corrected(picture.image, picture.black_level);
  }
  const auto& kept = mode.color_profile;
  ColorProfile profile =
      ProfileOf(args, source, pictures, output,
                kept && kept->raw_white_balance.has_value() == is_raw ? kept : std::nullopt);
  profile.raw_white_balance = pictures.front().developed_by;
  mode.color_profile = profile;
  file.modes[args.mode] = mode;
  acquisition::WriteCalibrationFile(output, file);
  if (!args.json) fmt::print("\n{}: colours written, mode {}\n", output, args.mode);
  return kOk;
}

}  // namespace

void AddCalibrateCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<CalibrateArgs>();
  CLI::App* command = app.add_subcommand("calibrate",
                                         "Find a camera's intrinsics from a printed board, its flat field "
                                         "from a card, or its colours from a chart");
  command->add_option("SOURCE", args->sources, "Device URI, folder of images, image files, or a video")
      ->required();
  command->add_option("--board", args->board, "Board, as its text is printed on the sheet (ulf board)")
      ->capture_default_str();
  command
      ->add_option("--mode", args->mode, "Calibrate live frames, or still: photographs of a tethered camera")
      ->check(CLI::IsMember({"live", "still"}))
      ->capture_default_str();
  command->add_option("-o,--output", args->output,
                      "Calibration file (default: stored for the camera; for images: calibration.json)");
  command->add_option("--report", args->report,
                      "Folder for report, picture of the residuals, and the frames used (default: none)");
  command->add_option("--preview", args->preview,
                      "PNG file that shows the picture of a device, once a second, where no window can "
                      "(default: a window, in a terminal with a display)");
  command->add_option("--serial", args->serial,
                      "Serial number of the camera, for image files (default: unknown)");
  command->add_option("--views", args->views, "Least number of views from a device")
      ->check(CLI::Range(4, 60))
      ->capture_default_str();
  command->add_flag("--explain", args->explain, "Print all lens models that were tried");
  command->add_flag("--flat", args->flat, "Estimate the flat field from frames of a plain, evenly lit card");
  command->add_flag("--colour,--color", args->colour,
                    "Find white balance and colour matrix from a chart of 24 patches");
  command->add_flag("--grey,--gray", args->grey,
                    "Find the white balance from a grey card that fills the middle of the picture");
  command
      ->add_option("--frames", args->frames, "Number of frames to average with --flat, --colour and --grey")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf calibrate sim:board -o camera.json --report report\n"
      "Then:    ulf capture aravis:192.168.1.20 --calibration camera.json -o light_field");
  command->callback([args, &chosen] {
    chosen = [args] {
      if (args->colour || args->grey) return RunColorProfile(*args);
      return args->flat ? RunFlatField(*args) : RunBoardCalibration(*args);
    };
  });
}

}  // namespace ulf::commands
