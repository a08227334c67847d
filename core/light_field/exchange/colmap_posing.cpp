#include "core/light_field/exchange/colmap_posing.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <deque>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/available_memory.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/other_program.h"
#include "core/base/progress.h"
#include "core/image/files/exif.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/raw_file.h"
#include "core/image/image.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/exchange/writers/colmap_program.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/posed_set.h"
#include "core/light_field/formats/set_format.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostExhaustive = 150;  // photographs; 11,175 pairs
constexpr int kLongerSide_px = 1600;          // as ulf refine reduces pictures
constexpr int kMostFeatures = 4096;           // of a photograph, about: comparing takes most of the time
constexpr double kBytesOfThread = 1e9;        // of the extractor, for pictures of this size
// Shares of the bar at which the steps begin.
constexpr double kFeatures = 0, kMatches = 0.2, kPoses = 0.6;

struct PictureToPose {
  fs::path file;
  std::string name;  // in COLMAP: a folder of its own, which keeps the order, and the file's name
  cv::Size size;
  ExifFacts exif;
  View view;  // path and mask, relative to the folder
};

// A photograph whose lens and zoom are the same has the same text.
std::string LensOf(const PictureToPose& photograph) {
  const ExifFacts& exif = photograph.exif;
  return fmt::format("{}x{} {} {} {:g} {:g}", photograph.size.width, photograph.size.height, exif.model,
                     exif.lens, exif.focal_mm.value_or(0), exif.focal_35mm.value_or(0));
}

ExifFacts ExifOf(const fs::path& file) {
  return IsRawFile(file) ? ReadRawFacts(file.string()).exif : ReadExifOfFile(file);
}

// Returns the photographs among the pictures: masks that lie beside them are none.
std::vector<PictureToPose> WithMasks(const fs::path& folder, const std::vector<fs::path>& pictures) {
  const SetImages images(folder);
  LightField views;
  std::set<std::string> masks;
  for (const fs::path& file : pictures)
    masks.insert(AddView(file.filename().string(), {}, {}, images, views).mask_path);
  std::vector<PictureToPose> photographs;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (!masks.contains(views.views[i].image_path))
      photographs.push_back(
          {pictures[i], {}, ReadImageSize(pictures[i].string()), ExifOf(pictures[i]), views.views[i]});
  return photographs;
}

std::vector<PictureToPose> PhotographsToPose(const fs::path& folder) {
  std::error_code unknown;
  if (!fs::exists(folder, unknown))
    throw Error("{}: there is no such folder; check the path", folder.string());
  if (!fs::is_directory(folder, unknown))
    throw Error("{}: is a file; give the folder of the photographs", folder.string());
  const PictureFolder found = PicturesIn(folder);
  if (found.pictures.empty()) RefuseWithoutPictures(folder.string(), found);
  if (found.pictures.size() < 2)
    throw Error("{}: holds {}, and a pose needs others beside it{}; give the folder of the photographs",
                folder.string(), Counted(found.pictures.size(), "photograph"),
                found.left_out.empty() ? "" : fmt::format(" ({})", found.LeftOut()));
  std::vector<PictureToPose> photographs = WithMasks(folder, found.pictures);
  const bool uses_masks_folder = std::ranges::any_of(
      photographs, [](const PictureToPose& each) { return each.view.mask_path.starts_with("masks/"); });
  for (const std::string& line : PicturesIn(folder, {uses_masks_folder ? "masks" : ""}).left_out)
    spdlog::warn("{}: left out: {}", folder.string(), line);
  // Without the times of all photographs their names are in order.
  if (std::ranges::none_of(photographs, [](const PictureToPose& each) { return each.exif.taken.empty(); }))
    std::ranges::stable_sort(photographs, {}, [](const PictureToPose& each) { return each.exif.taken; });
  for (std::size_t i = 0; i < photographs.size(); ++i)
    photographs[i].name = fmt::format("{:06}/{}", i + 1, photographs[i].file.filename().string());
  return photographs;
}

// Returns whether every program reads the same from the file.
bool IsPlain(const fs::path& file) {
  const auto header = IsRawFile(file) ? std::nullopt : ReadImageHeader(file.string());
  return header && (header->kind == "JPEG" || header->kind == "PNG") && header->bits == 8 && !header->alpha &&
         (header->channels == 1 || header->channels == 3);
}

// Puts the photograph there by a link where the file system has them. COLMAP tells a picture's kind by its
// first bytes, so that a converted one keeps its name.
void PutThere(const PictureToPose& photograph, const fs::path& there) {
  MakeFolder(there.parent_path());
  if (!IsPlain(photograph.file)) {
    const Image image{.pixels = ReadImageFile(photograph.file.string()),
                      .transfer = TransferOfFile(photograph.file)};
    return WriteFileAtomically(there, PngBytes(Srgb8(image)));
  }
  std::error_code refused;
  fs::create_symlink(fs::absolute(photograph.file), there, refused);
  if (refused) WriteFileAtomically(there, ReadWholeFile(photograph.file));
}

// Writes masks for COLMAP, which finds no features where they are 0, if a photograph has one or has alpha;
// then all get one, because not every version takes some. Returns whether it did.
bool WriteMasks(const fs::path& folder, const std::vector<PictureToPose>& photographs,
                const fs::path& masks) {
  LightField light_field;
  light_field.root = folder;
  for (const PictureToPose& photograph : photographs) {
    View& view = light_field.views.emplace_back(photograph.view);
    view.camera = static_cast<int>(light_field.cameras.size());
    light_field.cameras.push_back(CameraModel::Pinhole(photograph.size.width, photograph.size.height, 1));
  }
  if (std::ranges::none_of(light_field.views, [&](const View& view) { return HasMask(light_field, view); }))
    return false;
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    cv::Mat mask = ReadViewMask(light_field, light_field.views[i]);
    if (mask.empty()) mask = cv::Mat(photographs[i].size, CV_8U, cv::Scalar(255));
    const fs::path file = masks / (photographs[i].name + ".png");
    MakeFolder(file.parent_path());
    WriteFileAtomically(file, PngBytes(mask));
  }
  return true;
}

class Colmap {
 public:
  Colmap(fs::path photographs, StagedFolder& work, const std::function<bool()>& stop)
      : photographs_(std::move(photographs)),
        work_(work),
        stop_(stop),
        program_(ProgramInPath("colmap")),
        log_(work.path() / "colmap.log") {}

  // Throws the Error that names command, last lines and working folder if the command fails.
  void Run(const std::string& command, const std::vector<ColmapOption>& options,
           const std::function<void(const std::string&)>& see) {
    const int status = Try(command, options, see);
    if (status != 0) Fail(fmt::format("COLMAP's {} failed ({})", command, InWords(status)));
  }

  // Returns the command's exit status.
  int Try(const std::string& command, const std::vector<ColmapOption>& options,
          const std::function<void(const std::string&)>& see) {
    const std::set<std::string> known = OptionsOf(command);
    std::vector<std::string> arguments{command};
    std::ranges::move(ColmapArguments(options, known), std::back_inserter(arguments));
    return Start(arguments, see);
  }

  // Keeps the working folder.
  [[noreturn]] void Fail(const std::string& what) {
    work_.Keep();
    log_.flush();
    throw Error("{}: {}; COLMAP's last lines: {}; its files stay in {}", photographs_.string(), what,
                last_lines_.empty() ? "none" : fmt::format("{}", fmt::join(last_lines_, " / ")),
                work_.path().string());
  }

  static std::string InWords(int status) {
    constexpr int kSignalled = 128, kKilled = kSignalled + 9;
    if (status == kKilled) return "killed, as the system does when memory runs out";
    return status > kSignalled ? fmt::format("signal {}", status - kSignalled)
                               : fmt::format("exit status {}", status);
  }

 private:
  std::set<std::string> OptionsOf(const std::string& command) {
    std::set<std::string> names;
    const int status = Start({command, "--" + std::string("help")}, [&](const std::string& line) {
      if (const auto name = OptionInHelp(line)) names.insert(*name);
    });
    if (names.empty())
      Fail(fmt::format("{} does not tell the options of {} ({})", program_.string(), command,
                       InWords(status)));
    return names;
  }

  int Start(const std::vector<std::string>& arguments, const std::function<void(const std::string&)>& see) {
    constexpr std::size_t kKeptLines = 4;
    log_ << fmt::format("$ {} {}\n", program_.string(), fmt::join(arguments, " "));
    last_lines_.clear();
    const ProgramEnd end = RunOtherProgram(
        program_, arguments,
        [&](const std::string& line) {
          log_ << line << '\n';
          if (std::ranges::any_of(line, [](unsigned char c) { return std::isalnum(c) != 0; }))
            last_lines_.push_back(line.substr(line.find_first_not_of(" \t")));
          if (last_lines_.size() > kKeptLines) last_lines_.pop_front();
          see(line);
        },
        stop_);
    if (end.stopped) throw Error("stopped before the end, as asked; nothing was imported");
    return end.status;
  }

  const fs::path photographs_;
  StagedFolder& work_;
  const std::function<bool()>& stop_;
  const fs::path program_;
  std::ofstream log_;
  std::deque<std::string> last_lines_;
};

// Returns a/b of the first "[a/b" in the line.
std::optional<double> ShareIn(const std::string& line) {
  unsigned part = 0, whole = 0;
  const std::size_t at = line.find('[');
  if (at == std::string::npos || std::sscanf(line.c_str() + at, "[%u/%u", &part, &whole) != 2 || whole == 0)
    return std::nullopt;
  return std::min(1.0, static_cast<double>(part) / whole);
}

void ExtractFeatures(Colmap& colmap, const fs::path& work, const std::vector<PictureToPose>& photographs,
                     const std::vector<ColmapOption>& database, bool are_masked, Progress& progress) {
  const double threads = std::clamp(static_cast<double>(AvailableMemory()) / kBytesOfThread, 1.0,
                                    static_cast<double>(std::max(1U, std::thread::hardware_concurrency())));
  std::map<std::string, std::vector<const PictureToPose*>> by_lens;
  for (const PictureToPose& photograph : photographs) by_lens[LensOf(photograph)].push_back(&photograph);
  std::size_t done = 0;
  for (const auto& of_lens : by_lens) {
    const std::vector<const PictureToPose*>& same = of_lens.second;
    std::string list;
    for (const PictureToPose* photograph : same) list += photograph->name + "\n";
    const fs::path list_file = work / "photographs.txt";
    WriteFileAtomically(list_file, list);
    std::vector<ColmapOption> options = database;
    options.insert(options.end(), {{{"image_path"}, (work / "images").string()},
                                   {{"image_list_path"}, list_file.string()},
                                   {{"ImageReader.single_camera"}, "1"},
                                   {{"ImageReader.camera_model"}, "SIMPLE_RADIAL"},
                                   ExtractorGpu("0"),
                                   ExtractorThreads(fmt::format("{:.0f}", std::floor(threads))),
                                   {{"SiftExtraction.max_image_size", "FeatureExtraction.max_image_size"},
                                    std::to_string(kLongerSide_px)},
                                   {{"SiftExtraction.max_num_features"}, std::to_string(kMostFeatures)}});
    if (are_masked) options.push_back({{"ImageReader.mask_path"}, (work / "masks").string()});
    const cv::Size size = same.front()->size;
    // Without the data for 36 x 24 mm COLMAP looks for those of the sensor itself, else it guesses.
    if (const auto focal_px = FocalPx(same.front()->exif, size.width, size.height))
      options.push_back({{"ImageReader.camera_params"},
                         fmt::format("{:.3f},{:g},{:g},0", *focal_px, 0.5 * size.width, 0.5 * size.height)});
    colmap.Run("feature_extractor", options, [&](const std::string& line) {
      const auto share = ShareIn(line);
      if (!share) return;
      const double seen = static_cast<double>(done) + *share * static_cast<double>(same.size());
      progress.Show(kFeatures + (kMatches - kFeatures) * seen / static_cast<double>(photographs.size()),
                    fmt::format("features, photograph {:.0f} of {}", seen, photographs.size()));
    });
    done += same.size();
  }
}

void Match(Colmap& colmap, std::size_t photographs, std::vector<ColmapOption> options, Progress& progress) {
  options.push_back(MatcherGpu("0"));
  options.push_back({{"ExhaustiveMatching.block_size"}, "10"});  // the bar moves with every block
  const auto see = [&](const std::string& line) {
    if (const auto share = ShareIn(line))
      progress.Show(kMatches + (kPoses - kMatches) * *share, "comparing photographs");
  };
  if (photographs <= kMostExhaustive) return colmap.Run("exhaustive_matcher", options, see);
  colmap.Run("sequential_matcher", options, see);
  colmap.Run("transitive_matcher", options, see);
}

[[noreturn]] void FailWithoutPoses(Colmap& colmap, std::size_t photographs) {
  colmap.Fail(fmt::format(
      "COLMAP finds no poses for the {}: neighbours must show mostly the same from places that differ, of a "
      "scene with texture that stands still",
      Counted(photographs, "photograph")));
}

void FindPoses(Colmap& colmap, const fs::path& work, std::size_t photographs,
               std::vector<ColmapOption> options, Progress& progress) {
  MakeFolder(work / "models");
  options.push_back({{"image_path"}, (work / "images").string()});
  options.push_back({{"output_path"}, (work / "models").string()});
  const int status = colmap.Try("mapper", options, [&](const std::string& line) {
    unsigned image = 0, registered = 0;
    if (std::sscanf(line.c_str(), "Registering image #%u (%u)", &image, &registered) == 2)
      progress.Show(kPoses + (1 - kPoses) * std::min(1.0, registered / static_cast<double>(photographs)),
                    fmt::format("poses, photograph {} of {}", registered, photographs));
  });
  // It also ends with 1 when it finds no model.
  if (status > 1) colmap.Fail(fmt::format("COLMAP's mapper failed ({})", Colmap::InWords(status)));
  if (ColmapModelsIn(work / "models").empty()) FailWithoutPoses(colmap, photographs);
}

// Chooses among the models, which have worlds of their own.
void TakeLargest(const fs::path& models, PosedByColmap& posed) {
  std::vector<std::string> others;
  for (const fs::path& model : ColmapModelsIn(models)) {
    std::size_t images = ImagesOfColmapModel(model);
    if (images > posed.posed) {
      std::swap(images, posed.posed);
      posed.model = model;
    }
    if (images > 0) others.push_back(std::to_string(images));
  }
  if (!others.empty())
    posed.doubts.push_back(fmt::format(
        "COLMAP could not join all photographs: {} have poses in one world, and groups of {} in others, "
        "which are left out; photographs that show both places join them",
        posed.posed, fmt::join(others, " and ")));
}

}  // namespace

PosedByColmap PoseByColmap(const fs::path& folder, const fs::path& dir, const std::function<bool()>& stop) {
  if (ProgramInPath("colmap").empty())
    throw Error(
        "COLMAP, which finds the poses, is not installed: no program colmap in PATH; install it (on Debian: "
        "apt install colmap), or bring the poses of another program (docs/exchange.md)");
  StagedFolder{dir};  // refuses a folder in use before the work begins
  const std::vector<PictureToPose> photographs = PhotographsToPose(folder);
  PosedByColmap posed;
  fs::path beside = fs::absolute(dir).lexically_normal();
  if (!beside.has_filename()) beside = beside.parent_path();
  posed.work = std::make_unique<StagedFolder>(beside += ".colmap");
  posed.photographs = photographs.size();
  const fs::path& work = posed.work->path();
  for (const PictureToPose& photograph : photographs) PutThere(photograph, work / "images" / photograph.name);
  const bool are_masked = WriteMasks(folder, photographs, work / "masks");
  std::set<std::string> lenses;
  for (const PictureToPose& photograph : photographs) lenses.insert(LensOf(photograph));
  spdlog::info("{}: COLMAP poses {} of {}{}; {}", folder.string(), Counted(photographs.size(), "photograph"),
               Counted(lenses.size(), "camera"), are_masked ? ", by what masks do not exclude" : "",
               photographs.size() <= kMostExhaustive
                   ? "all are compared with each other"
                   : fmt::format("above {} they are compared along their order, and then where a third one "
                                 "joins two (sequential_matcher, transitive_matcher)",
                                 kMostExhaustive));
  const std::vector<ColmapOption> database{{{"database_path"}, (work / "database.db").string()}};
  Colmap colmap(folder, *posed.work, stop);
  Progress progress("pose");
  ExtractFeatures(colmap, work, photographs, database, are_masked, progress);
  Match(colmap, photographs.size(), database, progress);
  FindPoses(colmap, work, photographs.size(), database, progress);
  TakeLargest(work / "models", posed);
  return posed;
}

}  // namespace ulf
