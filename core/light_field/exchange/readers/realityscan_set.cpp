#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/image.h"
#include "core/light_field/formats/xml_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr double kWidthOf35mm = 36;  // millimetres, the larger side
constexpr const char* kExportBrown3 =
    "align and export with the model Brown 3 (Alignment Settings > Distortion model), or export undistorted "
    "photographs with their XMP files";

// The values of an XMP file.
class XmpValues {
 public:
  explicit XmpValues(const fs::path& file) : file_(file.string()) {
    const XmlElement top = ReadXmlFile(file);
    descriptions_ = top.Descendants("rdf:Description");
    if (top.Name() == "rdf:Description") descriptions_.push_back(top);
  }

  std::optional<std::string> Text(const std::string& name) const {
    const std::string full = "xcr:" + name;
    for (const XmlElement& description : descriptions_) {
      if (auto text = description.Attribute(full.c_str())) return text;
      if (const auto element = description.Find(full.c_str())) return element->Text();
    }
    return std::nullopt;
  }

  std::optional<std::vector<double>> Numbers(const std::string& name, std::size_t count) const {
    const auto text = Text(name);
    if (!text) return std::nullopt;
    return NumbersOf(*text, count, file_, "xcr:" + name);
  }
  double Number(const std::string& name, double otherwise) const {
    const auto numbers = Numbers(name, 1);
    return numbers ? numbers->front() : otherwise;
  }

  const std::string& file() const { return file_; }

 private:
  std::string file_;
  std::vector<XmlElement> descriptions_;
};

std::array<double, 5> XmpDistortion(const XmpValues& xmp) {
  const std::string given = xmp.Text("DistortionModel").value_or("none");
  const std::string model = Lowercase(given);
  const auto found = xmp.Numbers("DistortionCoeficients", 6);
  if (model == "none" || model == "perspective" || !found) return {};
  const std::vector<double>& c = *found;
  const bool is_straight = std::ranges::all_of(c, [](double value) { return value == 0; });
  if (model == "division") {
    if (is_straight) return {};
    throw Error(
        "{}: xcr:DistortionModel is 'division' (xcr:DistortionCoeficients {}), which is not supported; {}",
        xmp.file(), fmt::join(c, " "), kExportBrown3);
  }
  if (model != "brown3" && model != "brown4" && model != "brown3t2" && model != "brown4t2")
    throw Error("{}: xcr:DistortionModel is '{}', which is not supported; {}", xmp.file(), given,
                kExportBrown3);
  if (c[3] != 0)
    throw Error("{}: the fourth of xcr:DistortionCoeficients (k4) is {}, which is not supported; {}",
                xmp.file(), c[3], kExportBrown3);
  return {c[0], c[1], c[5], c[4], c[2]};
}

CameraModel ModelOfXmp(const XmpValues& xmp, const fs::path& image) {
  if (const double skew = xmp.Number("Skew", 0); skew != 0)
    throw Error("{}: xcr:Skew is {}, which is not supported; {}", xmp.file(), skew, kExportBrown3);
  const auto focal = xmp.Numbers("FocalLength35mm", 1);
  if (!focal)
    throw Error(
        "{}: has a pose and no xcr:FocalLength35mm; export the XMP files with the cameras' calibration",
        xmp.file());
  const cv::Size size = ReadImageSize(image.string());
  const double scale = std::max(size.width, size.height);
  CameraModel camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = focal->front() / kWidthOf35mm * scale;
  camera.fy = camera.fx * xmp.Number("AspectRatio", 1);
  camera.cx = 0.5 * size.width + scale * xmp.Number("PrincipalPointU", 0);
  camera.cy = 0.5 * size.height + scale * xmp.Number("PrincipalPointV", 0);
  camera.coefficients = XmpDistortion(xmp);
  if (camera.coefficients != std::array<double, 5>{}) camera.distortion = Distortion::kRadialTangential;
  camera.Validate(xmp.file());
  return camera;
}

// Returns none if the file has no pose.
std::optional<Rigid3> PoseOfXmp(const XmpValues& xmp, PoseRotations& rotations) {
  const auto rotation = xmp.Numbers("Rotation", 9), position = xmp.Numbers("Position", 3);
  if (!rotation && !position) return std::nullopt;
  if (!rotation || !position)
    throw Error("{}: has xcr:{} and no xcr:{}; export the XMP files again", xmp.file(),
                rotation ? "Rotation" : "Position", rotation ? "Position" : "Rotation");
  Rigid3 cam_from_world;
  cam_from_world.rotation =
      rotations.Read(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation->data()),
                     xmp.file(), "xcr:Rotation");
  cam_from_world.translation =
      -(cam_from_world.rotation * Eigen::Vector3d((*position)[0], (*position)[1], (*position)[2]));
  return cam_from_world;
}

// Returns the frame of the position. As in RealityScan, a file that names no component is absolute.
std::string FrameOfXmp(const XmpValues& xmp) {
  const std::string coordinates = Lowercase(xmp.Text("Coordinates").value_or("absolute"));
  if (coordinates == "absolute") return {};
  if (coordinates != "relative" && coordinates != "rigid")
    throw Error(
        "{}: xcr:Coordinates is '{}'; absolute, relative and rigid are known: export the XMP files again",
        xmp.file(), coordinates);
  return xmp.Text("ComponentId").value_or("");
}

// Returns the XMP files of a folder by their stem, and in lower case by those that are not there.
std::map<std::string, fs::path> XmpFilesIn(const fs::path& folder) {
  std::map<std::string, fs::path> files;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder, unknown))
    if (Lowercase(entry.path().extension().string()) == ".xmp" && entry.is_regular_file(unknown))
      files.emplace(entry.path().stem().string(), entry.path());
  for (const auto& [stem, file] : std::map(files)) files.emplace(Lowercase(stem), file);
  return files;
}

// Masks lie beside photographs as NAME.mask.png.
bool IsMaskBeside(const std::string& name) { return fs::path(name).stem().extension() == ".mask"; }

// Returns those of the folder itself, or if it holds none, those of its subfolders.
std::vector<std::string> PhotographsOf(const SetImages& images) {
  std::vector<std::string> names = images.names();
  std::error_code unknown;
  if (names.empty())
    for (const auto& folder : fs::directory_iterator(images.folder(), unknown))
      for (const auto& entry : fs::directory_iterator(folder.path(), unknown))
        if (HasImageEnding(entry.path()) && entry.is_regular_file(unknown))
          names.push_back((folder.path().filename() / entry.path().filename()).generic_string());
  LeaveOutRawTwins(names);
  std::erase_if(names, IsMaskBeside);
  std::ranges::sort(names, NameOrder);
  return names;
}

struct PosedPhotograph {
  std::string path;
  Rigid3 cam_from_world;
  CameraModel camera;
  std::string frame;
};

}  // namespace

PosedSet ReadRealityScanSet(const fs::path& folder, const fs::path& chosen) {
  const fs::path base = fs::absolute(folder).lexically_normal();
  std::error_code unknown;
  if (!fs::is_directory(base, unknown))
    throw Error("{}: is no folder; give the folder of the XMP files", folder.string());
  const SetImages images(base, chosen, {".", "images", "photos"});
  std::map<fs::path, std::map<std::string, fs::path>> beside;  // XMP files, by folder and stem
  const auto xmp_of = [&](const std::string& name) -> fs::path {
    const fs::path inside = fs::path(name).parent_path();
    for (const fs::path& place :
         {(images.folder() / inside).lexically_normal(), (base / inside).lexically_normal(), base}) {
      if (!beside.contains(place)) beside[place] = XmpFilesIn(place);
      const std::string stem = fs::path(name).stem().string(), whole = fs::path(name).filename().string();
      for (const std::string& key : {stem, whole, Lowercase(stem), Lowercase(whole)})
        if (const auto found = beside[place].find(key); found != beside[place].end()) return found->second;
    }
    return {};
  };

  PosedSet set;
  set.format = "RealityScan";
  LightField& light_field = set.light_field;
  light_field.root = images.folder();
  std::vector<PosedPhotograph> posed;
  std::map<std::string, std::size_t> frames;
  std::set<fs::path> taken;
  std::size_t without_file = 0, without_pose = 0, twice = 0;
  PoseRotations rotations;
  const ToldOnFailure told(light_field.doubts);
  for (const std::string& name : PhotographsOf(images)) {
    const fs::path file = xmp_of(name);
    if (file.empty()) {
      ++without_file;
      continue;
    }
    if (!taken.insert(file).second) {
      ++twice;
      continue;
    }
    const XmpValues xmp(file);
    const auto cam_from_world = PoseOfXmp(xmp, rotations);
    if (!cam_from_world) {
      ++without_pose;
      continue;
    }
    const CameraModel camera = ModelOfXmp(xmp, images.folder() / name);
    posed.push_back({name, *cam_from_world, camera, FrameOfXmp(xmp)});
    ++frames[posed.back().frame];
  }
  if (posed.empty())
    throw Error(
        "{}: no XMP file with a pose (xcr:Rotation, xcr:Position) belongs to a photograph in {}; export "
        "them with Alignment > Export > XMP, or say where the photographs lie with {} FOLDER",
        folder.string(), images.folder().string(), Parameter("images"));

  const std::string frame =
      std::ranges::max_element(frames, {}, [](const auto& entry) { return entry.second; })->first;
  for (const PosedPhotograph& photograph : posed)
    if (photograph.frame == frame)
      AddView(photograph.path, photograph.camera, photograph.cam_from_world, images, light_field);
  rotations.Tell(base.string(), light_field.doubts);
  NoteUnposed(without_file, "photograph", "no XMP file", set);
  NoteUnposed(without_pose, "photograph", "no pose in the XMP file", set);
  NoteUnposed(twice, "photograph", "another photograph has the same XMP file", set);
  NoteUnposed(posed.size() - light_field.views.size(), "photograph",
              "positions count from another component than the largest", set);
  return set;
}

}  // namespace ulf
