#include "core/light_field/exchange/import_light_field.h"

#include <opencv2/core.hpp>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/light_field/exchange/image_names.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/exchange/transforms_json.h"
#include "core/light_field/light_field_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// images/a/b.jpg, wherever the source kept it, safe as a field of a text file and different from all names
// that are `taken`.
std::string PathUnderImages(const std::string& source_path, std::set<std::string>& taken) {
  return UniqueName("images/" + SafeName(NameInImagesFolder(source_path)), taken);
}

// folder/a/b.ending for images/a/b.jpg.
std::string Beside(const char* folder, const std::string& image_path, const std::string& ending) {
  const fs::path path = fs::path(folder) / fs::path(image_path).lexically_relative("images");
  return fs::path(path).replace_extension(ending).generic_string();
}

void WriteInFolder(const fs::path& path, const std::string& bytes) {
  MakeFolder(path.parent_path());
  WriteFileAtomically(path, bytes);
}

// The master is the source's own, or else an original of more than 8 bits; the photograph is made from it.
void TakeImage(const LightField& source, const View& view, const fs::path& dir, View& taken) {
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
  }
  if (!is_photograph)
    taken.image_path = fs::path(taken.image_path).replace_extension(".png").generic_string();
  // While the source is being captured, a photograph may still be in its master alone.
  WriteInFolder(dir / taken.image_path,
                is_photograph && fs::exists(original) ? ReadWholeFile(original) : PngBytes(Srgb8(image)));
}

bool HoldsPhotographs(const fs::path& folder) {
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder, unknown)) {
    const std::string ending = Lowercase(entry.path().extension().string());
    for (const char* photograph : {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"})
      if (ending == photograph) return true;
  }
  return false;
}

// A mask as PNG of one channel, whether it was a file or the image's alpha; none where nothing is masked.
void TakeMask(const LightField& source, const View& view, const fs::path& dir, View& taken) {
  taken.mask_path.clear();
  const cv::Mat mask = ReadViewMask(source, view);
  if (mask.empty() || cv::countNonZero(mask) == static_cast<int>(mask.total())) return;
  taken.mask_path = Beside("masks", taken.image_path, ".png");
  WriteInFolder(dir / taken.mask_path, PngBytes(mask));
}

// Refuses videos, COLMAP models and plain photographs with the way in which each can be used.
void RequirePosedSet(const fs::path& source) {
  std::error_code unknown;
  const std::string path = source.string(), word = ShellWord(path);
  if (fs::is_regular_file(source, unknown)) {
    if (Lowercase(source.extension().string()) == ".json") return;
    throw Error(
        "{}: is no transforms.json; a video is posed and recorded by 'ulf capture replay:{} -o DIR "
        "--focal-px F --no-subject'",
        path, word);
  }
  if (fs::exists(source / kTransformsFile, unknown) || fs::exists(source / kJournalFile, unknown)) return;
  for (const char* model : {".", "sparse/0", "sparse", "colmap/sparse/0"})
    for (const char* images : {"images.bin", "images.txt"})
      if (fs::exists(source / model / images, unknown))
        throw Error(
            "{}: a COLMAP model ({}), which ulf does not import; instant-ngp's colmap2nerf.py or "
            "nerfstudio's ns-process-data makes a transforms.json of it",
            path, (fs::path(model) / images).lexically_normal().string());
  if (fs::is_directory(source, unknown) && HoldsPhotographs(source))
    throw Error(
        "{}: photographs without poses (no transforms.json); they are posed and recorded by 'ulf capture "
        "replay:{} -o DIR --focal-px F --no-subject'",
        path, word);
}

}  // namespace

LightField Import(const fs::path& source_path, const fs::path& dir, const ImportOptions& options) {
  RequirePosedSet(source_path);
  LightField source = ReadLightField(source_path);
  StagedFolder folder(dir);
  if (options.subject) source.subject = options.subject;
  if (!source.subject) source.subject = SubjectFromAxes(source);
  if (!source.subject)
    throw UsageError(
        "{}: the subject cannot be found from the cameras (their axes are nearly parallel or do not meet in "
        "front of them); give it with --subject x,y,z,radius",
        source_path.string());

  LightField imported = source;
  imported.root = folder.path();
  imported.doubts.clear();
  if (imported.device_uri.empty()) imported.device_uri = "import:" + source_path.filename().string();
  Progress progress("import");
  std::set<std::string> names;
  try {
    for (std::size_t i = 0; i < source.views.size(); ++i) {
      View& taken = imported.views[i];
      taken.image_path = PathUnderImages(source.views[i].image_path, names);
      TakeImage(source, source.views[i], folder.path(), taken);
      TakeMask(source, source.views[i], folder.path(), taken);
      progress.Show(static_cast<double>(i + 1) / static_cast<double>(source.views.size()),
                    source.views[i].image_path);
    }
    WriteLightField(imported);
    folder.Commit();
  } catch (const DiskFullError& error) {
    throw DiskFullError("{}: not imported, and no file was left behind: {}", dir.string(), error.what());
  }
  imported.root = dir;
  return imported;
}

}  // namespace ulf
