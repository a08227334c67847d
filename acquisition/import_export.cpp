#include "acquisition/import_export.h"

#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/atomic_file.h"
#include "acquisition/command_line.h"
#include "acquisition/error.h"
#include "acquisition/light_field_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// images/a/b.jpg, wherever the source kept it.
std::string PathUnderImages(const std::string& source_path) {
  constexpr std::string_view kFolder = "images/";
  return std::string(kFolder) +
         (source_path.starts_with(kFolder) ? source_path.substr(kFolder.size()) : source_path);
}

std::string PngBytes(const cv::Mat& pixels) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", pixels, bytes);
  return {bytes.begin(), bytes.end()};
}

void WriteInFolder(const fs::path& path, const std::string& bytes) {
  MakeFolder(path.parent_path());
  WriteFileAtomically(path, bytes);
}

// The master that the source has, or else an original of more than 8 bits, which every tool's photograph is
// then made from.
void TakeImage(const LightField& source, const View& view, const fs::path& dir, View& taken) {
  const Image image = ReadRecordedImage(source, view);
  const fs::path original = source.root / view.image_path;
  taken.image_path = PathUnderImages(view.image_path);
  const bool is_photograph = image.pixels.depth() == CV_8U;
  if (!view.master_path.empty()) {
    WriteInFolder(dir / view.master_path, ReadWholeFile(source.root / view.master_path));
  } else if (!is_photograph) {
    taken.master_path = "masters/" + taken.image_path.substr(std::string_view("images/").size());
    taken.master_transfer = image.transfer;
    WriteInFolder(dir / taken.master_path, ReadWholeFile(original));
  }
  if (!is_photograph)
    taken.image_path = fs::path(taken.image_path).replace_extension(".png").generic_string();
  // While the source is being captured, a photograph may still be in its master alone.
  WriteInFolder(dir / taken.image_path,
                is_photograph && fs::exists(original) ? ReadWholeFile(original) : PngBytes(Srgb8(image)));
}

}  // namespace

Subject ParseSubject(const std::string& text) {
  Subject subject;
  int used = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%n", &subject.center_in_world.x(),
                  &subject.center_in_world.y(), &subject.center_in_world.z(), &subject.radius, &used) != 4 ||
      static_cast<std::size_t>(used) != text.size() || !subject.center_in_world.allFinite() ||
      !std::isfinite(subject.radius))
    throw UsageError("'{}' is not a subject; write x,y,z,radius in world units, such as 0,0,-8.12,1.5", text);
  if (!(subject.radius > 0))
    throw UsageError("'{}' is not a subject: its radius, the last of x,y,z,radius, must be positive", text);
  return subject;
}

LightField Import(const fs::path& source_path, const fs::path& dir, const ImportOptions& options) {
  LightField source = ReadLightField(source_path);
  if (fs::exists(dir) && !(fs::is_directory(dir) && fs::is_empty(dir)))
    throw Error("{}: exists already; choose another folder", dir.string());
  if (options.subject) source.subject = options.subject;
  if (!source.subject) source.subject = SubjectFromAxes(source);
  if (!source.subject)
    throw UsageError(
        "{}: where the subject is cannot be told from the cameras (their axes are nearly parallel or do not "
        "meet in "
        "front of them); give it with --subject x,y,z,radius",
        source_path.string());

  MakeFolder(dir);
  LightField imported = source;
  imported.root = dir;
  if (imported.device_uri.empty()) imported.device_uri = "import:" + source_path.filename().string();
  Progress progress("import");
  for (std::size_t i = 0; i < source.views.size(); ++i) {
    TakeImage(source, source.views[i], dir, imported.views[i]);
    progress.Show(static_cast<double>(i + 1) / static_cast<double>(source.views.size()),
                  source.views[i].image_path);
  }
  WriteLightField(imported);
  return imported;
}

}  // namespace ulf
