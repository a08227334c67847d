#include "core/light_field/exchange/import_light_field.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/raw_file.h"
#include "core/light_field/exchange/conversions.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/exchange/subject_of_set.h"
#include "core/light_field/folder/kept_findings.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/quick_checks.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/image_names.h"
#include "core/light_field/formats/raw_beside.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/light_field.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Returns images/a/b.jpg for any source folder, safe as a field of a text file and different from all names
// that are `taken`.
std::string PathUnderImages(const std::string& source_path, std::set<std::string>& taken) {
  fs::path name = fs::path(NameInImagesFolder(source_path)).lexically_normal();
  if (name.is_absolute() || (!name.empty() && *name.begin() == "..")) name = name.filename();
  return UniqueName("images/" + SafeName(name.generic_string()), taken);
}

// Returns folder/a/b.ending for images/a/b.jpg.
std::string Beside(const char* folder, const std::string& image_path, const std::string& ending) {
  const fs::path path = fs::path(folder) / fs::path(image_path).lexically_relative("images");
  return fs::path(path).replace_extension(ending).generic_string();
}

void WriteInFolder(const fs::path& path, const std::string& bytes) {
  MakeFolder(path.parent_path());
  WriteFileAtomically(path, bytes);
}

// Compares the two; if undecided, they are assumed to be the same.
bool ShowsTheSame(const cv::Mat& light, const cv::Mat& photograph, double* shift_px) {
  constexpr double kMostShift_px = 1;
  const cv::Mat developed = Srgb8({.pixels = light, .transfer = Transfer::kLinear});
  *shift_px = LargestShiftPx(developed, photograph).value_or(0);
  return *shift_px <= kMostShift_px;
}

// Returns the JPEG beside a raw file, if it shows the same; empty if there is none.
fs::path QuickLookOf(const fs::path& raw, const cv::Mat& light) {
  const fs::path jpeg = JpegBeside(raw);
  double shift_px = 0;
  try {
    const cv::Mat photograph = jpeg.empty() ? cv::Mat() : ReadImageFile(jpeg.string());
    return photograph.type() == CV_8UC3 && photograph.size() == light.size() &&
                   ShowsTheSame(light, photograph, &shift_px)
               ? jpeg
               : fs::path();
  } catch (const Error& error) {
    spdlog::warn("{}", error.what());
    return {};
  }
}

// Takes a raw file as the master, and the camera's JPEG beside it as the photograph; if none shows the same,
// it is made from the raw file.
void TakeRaw(const LightField& source, const View& view, const fs::path& dir, View& taken,
             RawSetDoubts& doubts) {
  const fs::path raw = source.root / view.image_path;
  const RawFacts facts = ReadRawFacts(raw.string());
  taken.raw_white_balance = doubts.Add(view.image_path, facts);
  const cv::Mat light = ReadRawFile(raw.string(), SizeOf(source.CameraOf(view)), taken.raw_white_balance);
  NoteRawFacts(facts, taken);
  const fs::path jpeg = QuickLookOf(raw, light);
  taken.image_path =
      fs::path(taken.image_path).replace_extension(jpeg.empty() ? ".png" : ".jpg").generic_string();
  taken.master_path = Beside("masters", taken.image_path, Lowercase(raw.extension().string()));
  WriteInFolder(dir / taken.master_path, ReadWholeFile(raw));
  WriteInFolder(
      dir / taken.image_path,
      jpeg.empty() ? PngBytes(Srgb8({.pixels = light, .transfer = Transfer::kLinear})) : ReadWholeFile(jpeg));
}

// Takes the raw file beside a photograph as its master, if it shows the same.
void TakeRawBeside(const LightField& source, const View& view, const cv::Mat& photograph, const fs::path& dir,
                   View& taken, RawSetDoubts& doubts) {
  const fs::path raw = RawBeside(source.root / view.image_path);
  if (raw.empty()) return;
  try {
    const RawFacts facts = ReadRawFacts(raw.string());
    const cv::Mat light = ReadRawFile(raw.string(), SizeOf(source.CameraOf(view)));
    double shift_px = 0;
    if (!ShowsTheSame(light, photograph, &shift_px))
      return doubts.AddUnlike(raw.filename().string(), shift_px);
    taken.raw_white_balance = doubts.Add(raw.filename().string(), facts);
    NoteRawFacts(facts, taken);
  } catch (const DiskFullError&) {
    throw;
  } catch (const Error& error) {
    return doubts.AddUnusable(fmt::format("{}; its JPEG is used alone", error.what()));
  }
  taken.master_path = Beside("masters", taken.image_path, Lowercase(raw.extension().string()));
  WriteInFolder(dir / taken.master_path, ReadWholeFile(raw));
}

// The master is the source's own, or an original of more than 8 bits; the photograph is made from it.
void TakeImage(const LightField& source, const View& view, const fs::path& dir, View& taken,
               RawSetDoubts& doubts) {
  const Image image = ReadRecordedImage(source, view);
  const fs::path original = source.root / view.image_path;
  const bool is_photograph = image.pixels.depth() == CV_8U;
  if (!view.master_path.empty()) {
    taken.master_path = Beside("masters", taken.image_path, fs::path(view.master_path).extension());
    WriteInFolder(dir / taken.master_path, ReadWholeFile(source.root / view.master_path));
  } else if (!is_photograph) {
    taken.master_path = Beside("masters", taken.image_path, original.extension());
    taken.master_transfer = image.transfer;
    WriteInFolder(dir / taken.master_path, ReadWholeFile(original));
  } else {
    TakeRawBeside(source, view, image.pixels, dir, taken, doubts);
  }
  if (!is_photograph)
    taken.image_path = fs::path(taken.image_path).replace_extension(".png").generic_string();
  // While the source is being captured, a photograph may still be in its master alone.
  WriteInFolder(dir / taken.image_path,
                is_photograph && fs::exists(original) ? ReadWholeFile(original) : PngBytes(Srgb8(image)));
}

// Writes a mask as PNG of one channel, from a file or the image's alpha; none if nothing is masked.
void TakeMask(const LightField& source, const View& view, const fs::path& dir, View& taken) {
  taken.mask_path.clear();
  taken.mask_marks_unused = false;
  const cv::Mat mask = ReadViewMask(source, view);
  if (mask.empty() || cv::countNonZero(mask) == static_cast<int>(mask.total())) return;
  taken.mask_path = Beside("masks", taken.image_path, ".png");
  WriteInFolder(dir / taken.mask_path, PngBytes(mask));
}

// Keeps their names.
void TakeExposures(const LightField& source, const View& view, const fs::path& dir) {
  View alone;
  alone.exposures = view.exposures;
  alone.merged = view.merged;
  for (const std::string& file : FilesOf(alone)) WriteInFolder(dir / file, ReadWholeFile(source.root / file));
}

// Blends pictures with alpha over a colour; masks do not apply to them.
void TakeOverBackground(const LightField& source, const View& view, const cv::Mat& over, const fs::path& dir,
                        View& taken) {
  const CameraModel& camera = source.CameraOf(view);
  if (over.cols != camera.width || over.rows != camera.height)
    throw Error("{}: the image is {}x{}, its camera says {}x{}; correct the intrinsics or restore the image",
                (source.root / view.image_path).string(), over.cols, over.rows, camera.width, camera.height);
  taken.image_path = fs::path(taken.image_path).replace_extension(".png").generic_string();
  if (over.depth() == CV_8U) return WriteInFolder(dir / taken.image_path, PngBytes(over));
  taken.master_path = Beside("masters", taken.image_path, ".png");
  taken.master_transfer = Transfer::kSrgb;
  WriteInFolder(dir / taken.master_path, PngBytes(over));
  WriteInFolder(dir / taken.image_path, PngBytes(Srgb8({.pixels = over, .transfer = Transfer::kSrgb})));
}

// Returns, by folder, the files and folders in it that views of the set name.
std::map<fs::path, std::set<std::string>> NamesUsed(const LightField& source) {
  std::map<fs::path, std::set<std::string>> used;
  for (const View& view : source.views) {
    std::set<std::string> files = FilesOf(view);
    if (!view.mask_path.empty()) files.insert(view.mask_path);
    for (const std::string& file : files)
      for (fs::path at = (source.root / file).lexically_normal();
           at.has_filename() && used[at.parent_path()].insert(at.filename().string()).second;)
        at = at.parent_path();
  }
  return used;
}

// Matches "r_0_depth_0001.png" beside "r_0.png", as renderers of sets write it.
bool IsMapBeside(const std::set<fs::path>& taken, const fs::path& folder, const fs::path& file) {
  const std::string stem = file.stem().string();
  return std::ranges::any_of(std::array{"depth", "normal", "mask"}, [&](const char* map) {
    const std::size_t at = stem.rfind(std::string("_") + map);
    return at != std::string::npos && taken.contains(folder / stem.substr(0, at));
  });
}

// Warns of files beside the photographs of the set that its reader has not counted.
void ReportUnusedFiles(const PosedSet& set) {
  const LightField& source = set.light_field;
  const bool has_endings =
      std::ranges::all_of(source.views, [](const View& view) { return HasImageEnding(view.image_path); });
  auto used = NamesUsed(source);
  std::set<fs::path> folders, taken;
  for (const View& view : source.views) {
    folders.insert(fs::path(view.image_path).parent_path());
    for (const std::string& file : {view.image_path, view.mask_path, view.master_path})
      if (!file.empty()) taken.insert(fs::path(file).replace_extension());
  }
  for (const fs::path& folder : folders) {
    std::error_code refused;
    const fs::path place = (source.root / folder).lexically_normal();
    if (fs::directory_iterator(place, refused); refused) continue;  // its photographs may still be readable
    const PictureFolder found = PicturesIn(place, used[(place / "any").lexically_normal().parent_path()]);
    std::vector<std::string> names;
    for (const fs::path& file : found.pictures)
      if (!taken.contains((folder / file.filename()).replace_extension()) &&
          !IsMapBeside(taken, folder, file))
        names.push_back(file.filename().string());
    if (!names.empty() && !set.counts_unposed)
      spdlog::info("{}: left out: {} without a pose ({})", place.string(),
                   Counted(names.size(), "photograph"), AbbreviatedList(names));
    for (const std::string& line : has_endings ? found.left_out : std::vector<std::string>())
      spdlog::info("{}: left out: {}", place.string(), line);
  }
}

// Sums the files that are copied.
std::uint64_t BytesOf(const LightField& source) {
  std::uint64_t bytes = 0;
  for (const View& view : source.views)
    for (const std::string& file : {view.image_path, view.master_path}) {
      std::error_code missing;
      const std::uint64_t size = file.empty() ? 0 : fs::file_size(source.root / file, missing);
      if (!missing) bytes += size;
    }
  return bytes;
}

}  // namespace

Imported Import(const fs::path& source_path, const fs::path& dir, const ImportOptions& options) {
  if (options.subject && options.without_subject)
    throw Refusal(Parameter("no_subject"), "", "a subject is given, too", "leave out one of the two");
  StagedFolder{dir};  // refuses a folder in use before the set is read
  PosedSet set = options.model.empty()
                     ? ReadPosedSet(source_path, options.format, options.images, options.camera)
                     : ReadColmapSet(options.model, source_path);
  LightField& source = set.light_field;
  StagedFolder folder(dir);
  std::optional<cv::Vec3d> background = options.background;
  if (!background) background = set.background;
  Imported imported{source, set.format, {}};
  if (options.subject) PlaceSubject(*options.subject, source);
  if (options.without_subject) {
    source.subject.reset();
    source.goal.reset();
    source.measured.reset();
  } else if (!source.subject) {
    if (const auto found = FindSubject(set)) {
      source.subject = found->subject;
      imported.subject_told_by = found->told_by;
    }
  }
  for (const Check check : {Check::kPoints, Check::kSubject}) Replace(check, {}, source.findings);
  const std::vector<Finding> quick = QuickFindings(source);
  source.findings.insert(source.findings.end(), quick.begin(), quick.end());
  WarnOnce(dir, source.findings);
  for (const std::string& doubt : source.doubts) spdlog::warn("{}", doubt);
  // Poses that took long to find are worth keeping.
  if (!source.subject && !options.without_subject && options.model.empty() &&
      set.format != Name(SetFormat::kUlf))
    throw Refusal(source_path.string(), "", "the subject cannot be found: " + WhyNoSubject(source), "");

  LightField& made = imported.light_field;
  made = source;
  made.root = folder.path();
  made.doubts.clear();
  if (made.device_uri.empty()) made.device_uri = "import:" + source_path.filename().string();
  for (const Conversion& conversion : ConversionsOf(source))
    spdlog::info("{}: {}", conversion.file.string(), conversion.words);
  if (set.format != Name(SetFormat::kUlf)) ReportUnusedFiles(set);
  Progress progress("import");
  std::set<std::string> names;
  std::size_t laid_over = 0;
  RawSetDoubts raw_doubts;
  try {
    if (!background) RequireRoom(folder.path(), BytesOf(source));
    for (std::size_t i = 0; i < source.views.size(); ++i) {
      const View& view = source.views[i];
      View& taken = made.views[i];
      taken.image_path = PathUnderImages(view.image_path, names);
      const cv::Mat over =
          background ? ReadOverBackground((source.root / view.image_path).string(), *background) : cv::Mat();
      if (over.empty()) {
        if (IsRawFile(view.image_path))
          TakeRaw(source, view, folder.path(), taken, raw_doubts);
        else
          TakeImage(source, view, folder.path(), taken, raw_doubts);
        TakeMask(source, view, folder.path(), taken);
      } else {
        ++laid_over;
        taken.mask_path.clear();
        TakeOverBackground(source, view, over, folder.path(), taken);
      }
      TakeExposures(source, view, folder.path());
      progress.Show(static_cast<double>(i + 1) / static_cast<double>(source.views.size()), view.image_path);
    }
    for (const std::string& doubt : raw_doubts.Lines()) spdlog::warn("{}", doubt);
    if (laid_over > 0 && !options.background)
      spdlog::warn("{} with alpha: laid over white, as in the papers ({} COLOUR)",
                   Counted(laid_over, "picture"), Parameter("background"));
    WriteLightField(made);
    for (const Check check : {Check::kPoses, Check::kLight}) {
      std::vector<Finding> found;
      std::ranges::copy_if(made.findings, std::back_inserter(found),
                           [check](const Finding& each) { return each.check == Name(check); });
      if (!found.empty()) KeepFindings(folder.path(), check, found);
    }
    folder.Commit();
  } catch (const DiskFullError& error) {
    throw DiskFullError("{}: not imported, and no file was left behind: {}", dir.string(), error.what());
  }
  made.root = dir;
  return imported;
}

}  // namespace ulf
