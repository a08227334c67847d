#include "core/light_field/formats/transforms_json.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/base/json_text.h"
#include "core/base/lowercase.h"
#include "core/base/shell_word.h"
#include "core/geometry/camera_json.h"
#include "core/image/files/image_header.h"
#include "core/light_field/formats/fitted_lens.h"
#include "core/light_field/formats/frame_files.h"
#include "core/light_field/formats/transforms_camera.h"
#include "core/light_field/formats/transforms_keys.h"
#include "core/light_field/formats/view_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFormatVersion = 1;
constexpr const char* kPointsFile = "points.ply";

// Converts between camera axes with y up, z back (OpenGL) and y down, z forward (ours); it is its own
// inverse.
Eigen::Matrix4d OpenGlFromOurs() { return Eigen::Vector4d(1, -1, -1, 1).asDiagonal(); }

Eigen::Matrix4d WorldFromCam(const JsonPlace& frame, const char* key) {
  const json& rows = frame.Raw(key);
  if (!rows.is_array() || (rows.size() != 4 && rows.size() != 3))
    throw Error("{}: '{}' must be 4 rows of 4 numbers", frame.where, key);
  Eigen::Matrix4d world_from_cam = Eigen::Matrix4d::Identity();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (!rows[r].is_array() || rows[r].size() != 4)
      throw Error("{}: '{}' must be 4 rows of 4 numbers", frame.where, key);
    for (std::size_t c = 0; c < 4; ++c) {
      if (!rows[r][c].is_number() || !std::isfinite(rows[r][c].get<double>()))
        throw Error("{}: '{}' holds {} in row {}, which is not a finite number", frame.where, key,
                    JsonText(rows[r][c]), r);
      world_from_cam(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = rows[r][c].get<double>();
    }
  }
  return world_from_cam;
}

// Returns when the middle of the picture was taken: 0 at transform_matrix_start, 1 at transform_matrix_end.
// Instant-ngp's rolling_shutter is A, B, C and perhaps D: A + B u + C v + D of the time of exposure, where u
// and v go from 0 to 1 across the picture.
double MiddleTime(const JsonPlace& frame, const JsonPlace& set) {
  const JsonPlace& place = frame.Has("rolling_shutter") ? frame : set;
  if (!place.Has("rolling_shutter")) return 0.5;
  const json& given = place.Raw("rolling_shutter");
  const bool is_list = given.is_array() && (given.size() == 3 || given.size() == 4) &&
                       std::ranges::all_of(given, [](const json& value) { return value.is_number(); });
  if (!is_list)
    throw Error("{}: 'rolling_shutter' is {}; instant-ngp has three or four numbers there", place.where,
                JsonText(given).substr(0, 80));
  double time = given[0].get<double>();
  for (std::size_t i = 1; i < given.size(); ++i) time += 0.5 * given[i].get<double>();
  return time;
}

// Our own frames have the picture's pose as well.
bool IsOfTwoPoses(const JsonPlace& frame) {
  const bool is_ours = frame.Has("ulf") && frame.Has("transform_matrix");
  return !is_ours && frame.Has("transform_matrix_start") && frame.Has("transform_matrix_end");
}

// Returns the camera axes of the set's matrices in OpenGL's. Two loaders that read the same keys otherwise
// take OpenGL's: instant-ngp takes x left, y up, z forward where Mitsuba's arguments are, NeuS2 OpenCV's
// where `from_na` is set.
Eigen::Vector4d AxesInOpenGl(const JsonPlace& set) {
  const auto is_set = [&](const char* key) { return set.Has(key) && !IsOff(set.Raw(key)); };
  if (set.Has("normal_mts_args")) return {-1, 1, -1, 1};
  return is_set("from_na") ? Eigen::Vector4d(1, -1, -1, 1) : Eigen::Vector4d::Ones();
}

Rigid3 CamFromWorld(const JsonPlace& frame, const JsonPlace& set, PoseRotations& rotations) {
  const auto pose = [&](const char* key) {
    return CamFromOpenGl(WorldFromCam(frame, key) * AxesInOpenGl(set).asDiagonal(), frame.where, key,
                         rotations);
  };
  if (!IsOfTwoPoses(frame))
    return pose(frame.Has("transform_matrix_start") && !frame.Has("transform_matrix")
                    ? "transform_matrix_start"
                    : "transform_matrix");
  return Interpolated(pose("transform_matrix_start"), pose("transform_matrix_end"), MiddleTime(frame, set));
}

std::optional<JournalStamp> StampFrom(const JsonPlace& top) {
  if (!top.Has("ulf") || !top.Raw("ulf").contains("journal")) return std::nullopt;
  const json& stamp = top.Raw("ulf").at("journal");
  const auto whole = [&](const char* key) {
    return stamp.is_object() && stamp.contains(key) && stamp[key].is_number_unsigned();
  };
  if (!whole("bytes") || !whole("crc32") || stamp["crc32"].get<std::uint64_t>() > 0xFFFFFFFFu)
    return std::nullopt;
  return JournalStamp{stamp["bytes"].get<std::uint64_t>(), stamp["crc32"].get<std::uint32_t>()};
}

void ReadOurKeys(const JsonPlace& ours, LightField& light_field) {
  const int version = ours.Integer("format_version", kFormatVersion);
  if (version > kFormatVersion)
    throw NewerFormatError("{}: format version {} is newer than this program's {}; use a newer ulf",
                           ours.where, version, kFormatVersion);
  if (ours.Has("subject")) {
    const JsonPlace subject = ours.Inside("subject");
    light_field.subject = Subject{Vector3FromJson(subject, "center"), subject.Positive("radius")};
  }
  if (ours.Has("up")) light_field.up_in_world = Vector3FromJson(ours, "up").normalized();
  if (ours.Has("goal")) light_field.goal = CoverageGoalFromJson(ours.Inside("goal"));
  if (ours.Has("readout")) light_field.readout = ReadoutFromJson(ours.Inside("readout"));
  if (ours.Has("turntable")) light_field.turntable = Turntable{ours.Inside("turntable").Text("board", "")};
  if (ours.Has("measured")) light_field.measured = MeasuredFromJson(ours.Inside("measured"));
  ReadCaptureJson(ours, light_field);
  light_field.capture_s = ours.Number("capture_s", 0);
  if (ours.Has("reasons")) light_field.reasons = ReasonsFromJson(ours.Inside("reasons"));
}

// Parses the set's values without its frames, then each frame, so that one of them is in memory at a time.
class Document {
 public:
  explicit Document(const fs::path& file) : file_(file) {
    const auto keep_name = [&](json&& frame, std::size_t) {
      if (frame.is_object() && frame.contains("file_path") && frame["file_path"].is_string())
        names_.push_back(frame["file_path"].get<std::string>());
    };
    try {
      top_ = Parse(keep_name);
    } catch (const Error&) {
      if (!ParseWithNotFinite()) throw;
      names_.clear();
      ForEachFrame(keep_name);
    }
    if (!top_.is_object()) throw Error("{}: expected an object with the key 'frames'", file.string());
    if (!top_.contains("frames"))
      throw Error("{}: the key 'frames' is missing; add it or export the set again", file.string());
    if (!top_["frames"].is_array()) throw Error("{}: 'frames' must be a list", file.string());
  }
  const json& top() const { return top_; }
  // Returns how the frames name their photographs.
  const std::vector<std::string>& names() const { return names_; }
  void ForEachFrame(const std::function<void(json&&, std::size_t)>& use) const {
    if (!frames_.is_array()) Parse(use);
    for (std::size_t i = 0; frames_.is_array() && i < frames_.size(); ++i) use(json(frames_[i]), i);
  }

 private:
  // Reads a file with NaN or Infinity, which Python writes. Returns false if that was not the fault.
  bool ParseWithNotFinite() {
    try {
      top_ = ParseJson(ReadWholeFile(file_), file_.string(), "");
    } catch (const Error&) {
      return false;
    }
    if (!top_.is_object() || !top_.contains("frames") || !top_["frames"].is_array()) return false;
    frames_ = std::exchange(top_["frames"], json::array());
    return true;
  }

  json Parse(const std::function<void(json&&, std::size_t)>& use) const {
    std::ifstream stream = OpenRegularFile(file_);
    std::size_t count = 0;
    bool in_frames = false;
    const auto keep = [&](int depth, json::parse_event_t event, json& parsed) {
      constexpr int kMostLevels = 100;  // the library copies and prints by recursion
      if (depth > kMostLevels) throw Error("{}: values are nested too deeply{}", file_.string(), WayOut());
      if (depth == 1 && event == json::parse_event_t::key) in_frames = parsed == "frames";
      if (!in_frames || depth != 2) return true;
      // A frame that is no object is passed on, too: its reader reports it.
      if (event != json::parse_event_t::object_end && event != json::parse_event_t::value) return true;
      use(std::move(parsed), count++);
      return false;
    };
    try {
      constexpr bool kThrow = true, kWithComments = true;  // as instant-ngp reads them
      return json::parse(stream, keep, kThrow, kWithComments);
    } catch (const json::exception& error) {
      if (Lowercase(file_.extension().string()) != ".json")
        throw Error(
            "{}: is no light field: give its folder, or a transforms.json; other programs' poses and "
            "photographs are read by 'ulf import'",
            file_.string());
      throw Error("{}, {}{}", file_.string(), FaultOf(error), WayOut());
    }
  }

  std::string FaultOf(const json::exception& error) const {
    const auto* fault = dynamic_cast<const json::parse_error*>(&error);
    return fault ? JsonFault(ReadWholeFile(file_), fault->byte)
                 : std::string("not valid JSON: a number is too large");
  }

  // Beside a journal, the light field's reader says that this file is derived.
  std::string WayOut() const {
    return fs::exists(file_.parent_path() / "journal.jsonl")
               ? ""
               : "; copy it again from where it came, or export the set again";
  }

  fs::path file_;
  json top_, frames_;  // frames of a file with NaN or Infinity; else null
  std::vector<std::string> names_;
};

// Returns the number in an image's name; none if there is none, or it is too large for an id.
std::optional<int> NumberOfName(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  if (stem.empty() || stem.size() > 9 || stem.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  const int number = std::stoi(stem);
  return number > 0 ? std::optional(number) : std::nullopt;
}

// Collects the cameras of a set, each once: many sets repeat the camera in every frame.
class Cameras {
 public:
  explicit Cameras(std::vector<CameraModel>& cameras) : cameras_(cameras) {}
  int IndexOf(const CameraModel& camera) {
    const auto [found, is_new] = indices_.try_emplace(camera, static_cast<int>(cameras_.size()));
    if (is_new) cameras_.push_back(camera);
    return found->second;
  }

 private:
  std::vector<CameraModel>& cameras_;
  std::map<CameraModel, int> indices_;
};

void AddOnce(const std::string& doubt, std::vector<std::string>& doubts) {
  if (std::ranges::find(doubts, doubt) == doubts.end()) doubts.push_back(doubt);
}

// Masters and exposures belong to the set's own photographs and to no others.
void ReadOurView(const FrameFiles& files, const JsonPlace& ours, View& view) {
  const std::string mask = view.mask_path;
  ReadViewJson(ours, view);
  if (files.images) {
    view.mask_path =
        mask.empty() && !view.mask_path.empty() ? MaskOfSet(files, view.mask_path, ours.where) : mask;
    view.master_path.clear();
    view.exposures.clear();
    view.merged.reset();
  } else {
    RequirePathsBelow(ours.where, view);
    if (!files.are_read) return;
    for (const std::string& path : FilesOf(view)) PathInside(files.root, path, ours.where);
    if (!view.mask_path.empty()) PathInside(files.root, view.mask_path, ours.where);
  }
}

// If files are read, frames must exist, and the images and masks that they name.
LightField ReadFrames(const Document& document, const fs::path& file, const FrameFiles& files) {
  LightField light_field;
  light_field.root = files.images ? files.images->folder() : files.root;
  const JsonPlace top{document.top(), file.string()};
  const json shared_keys = CameraKeysOf(document.top());
  Cameras cameras(light_field.cameras);
  std::optional<CameraModel> shared_camera;
  MissingPhotographs missing(file.string());
  PoseRotations rotations;
  FittedLenses fitted;
  std::size_t moving = 0;
  const ToldOnFailure told(light_field.doubts);
  std::map<std::string, std::size_t> unused;
  // A camera without size has that of the measured photograph.
  const auto camera_of = [&](const json& object, const JsonPlace& frame, const std::string& given,
                             const fs::path& image) {
    const json own_keys = CameraKeysOf(object);
    if (own_keys.empty() && shared_camera) return *shared_camera;
    const json keys = MergedCameraKeys(shared_keys, own_keys);
    const JsonPlace place{keys, frame.where};
    if (files.are_poses_wanted && !(HasIntrinsics(place) && HasSize(place))) return CameraModel{};
    if (!HasIntrinsics(place))
      throw Error(
          "{}: none of 'fl_x', 'camera_angle_x' and 'x_fov' is here or at the top; add the focal length in "
          "pixels as 'fl_x'",
          frame.where);
    const fs::path measured =
        files.images && !HasSize(place) ? MeasuredPhotograph(files, given, frame.where) : image;
    if (measured.empty() && place.Has("fl_x"))
      AddOnce(fmt::format(
                  "{}: 'fl_x' is in pixels of photographs whose size ('w' and 'h') it does not say: they are "
                  "taken to have been as large as those of {}",
                  file.string(), Parameter("images")),
              light_field.doubts);
    const CameraModel camera = ReadCamera(place, measured.empty() ? image : measured, &fitted);
    if (own_keys.empty()) shared_camera = camera;
    return camera;
  };
  const auto add = [&](json&& object, std::size_t i) {
    JsonPlace frame{object, fmt::format("{}, frame {}", file.string(), i)};
    View view;
    view.id = static_cast<int>(i) + 1;
    const std::string given = frame.Text("file_path");
    frame.where += " (" + given + ")";
    if (!files.are_read && !files.are_poses_wanted) view.id = NumberOfName(given).value_or(view.id);
    view.image_path = PathOfPhotograph(files, given, frame.where);
    if (view.image_path.empty() && files.are_read) return missing.Add(frame.where, given);
    view.mask_path = PathOfMask(files, frame, view.image_path);
    view.cam_from_world = CamFromWorld(frame, top, rotations);
    moving += IsOfTwoPoses(frame);
    const fs::path image = light_field.root / view.image_path;
    CameraModel camera = camera_of(object, frame, given, image);
    if (files.is_copied()) camera = AtSizeOf(image, camera, frame.where, light_field.doubts);
    view.camera = cameras.IndexOf(camera);
    if (frame.Has("ulf") && !files.are_poses_wanted) {
      const JsonPlace ours = frame.Inside("ulf");
      ReadOurView(files, ours, view);
      NoteCalibrationSource(ours, view.camera, light_field);
    }
    if (view.mask_path.empty() && files.are_read) {
      view.mask_path = DynamicMaskOf(light_field.root, view.image_path);
      view.mask_marks_unused = !view.mask_path.empty();
    }
    for (const auto& [key, value] : object.items())
      if (!Among(kFrameKeys, key) && !IsCameraKey(key)) ++unused[key];
    light_field.views.push_back(std::move(view));
  };
  document.ForEachFrame(add);
  missing.Tell(files, light_field.views.size(), StampFrom(top) && !files.is_copied(), light_field.doubts);
  rotations.Tell(file.string(), light_field.doubts);
  fitted.Note(light_field.doubts);
  if (moving > 0)
    light_field.doubts.push_back(
        fmt::format("{}: of {} that moved meanwhile, the pose in the middle of the picture is taken",
                    file.string(), Counted(moving, "frame")));
  if (files.are_read && light_field.views.empty() && missing.none() && !files.may_be_poses_alone)
    throw Error("{}: 'frames' is empty; there is nothing to render", file.string());
  std::ranges::stable_sort(light_field.views, [](const View& a, const View& b) { return a.id < b.id; });
  for (std::size_t i = 1; i < light_field.views.size(); ++i)
    if (light_field.views[i].id == light_field.views[i - 1].id)
      throw Error("{}: two frames have the id {} under 'ulf'; ids are given once", file.string(),
                  light_field.views[i].id);
  if (top.Has("ulf")) {
    const JsonPlace ours{top.Raw("ulf"), file.string() + ", ulf"};
    ReadOurKeys(ours, light_field);
    if (light_field.cameras.size() == 1) NoteCalibrationSource(ours, 0, light_field);
  }
  for (const auto& [key, value] : document.top().items())
    if (!Among(kTransformsKeys, key) && !IsCameraKey(key))
      light_field.doubts.push_back(fmt::format("{}: '{}' is not used", file.string(), key));
  for (const auto& [key, count] : unused)
    light_field.doubts.push_back(
        fmt::format("{}: '{}' of {} is not used", file.string(), key, Counted(count, "frame")));
  return light_field;
}

void ReadPointsOf(const JsonPlace& top, const FrameFiles& files, LightField& light_field) {
  const std::string given = top.Text("ply_file_path", "");
  const std::string path = given.empty() ? kPointsFile : FileOfSet(files, given, top.where);
  if (!ReadPointPositions(files.root / path, light_field) && !given.empty())
    light_field.doubts.push_back(
        fmt::format("{}: the points '{}' are missing: the set is read without points", top.where, given));
}

json OurKeys(const LightField& light_field) {
  json ours = CaptureToJson(light_field);
  ours["format_version"] = kFormatVersion;
  ours["capture_s"] = light_field.capture_s;
  ours["up"] = Vector3ToJson(light_field.UpInWorld());
  if (light_field.subject)
    ours["subject"] = {{"center", Vector3ToJson(light_field.subject->center_in_world)},
                       {"radius", light_field.subject->radius}};
  if (light_field.goal) ours["goal"] = CoverageGoalToJson(*light_field.goal);
  if (light_field.readout) ours["readout"] = ReadoutToJson(*light_field.readout);
  if (light_field.turntable) ours["turntable"] = {{"board", light_field.turntable->board}};
  if (!light_field.reasons.empty()) ours["reasons"] = light_field.reasons;
  if (light_field.measured) ours["measured"] = MeasuredToJson(*light_field.measured);
  return ours;
}

// `others` are files of the same set, whose photographs are not this one's.
LightField ReadDocument(const fs::path& file, FrameFiles files, std::span<const fs::path> others = {}) {
  const Document document(file);
  std::vector<std::string> names = document.names();
  for (const fs::path& other : others) {
    const Document of_others(other);
    names.insert(names.end(), of_others.names().begin(), of_others.names().end());
  }
  if (files.images) files.images->Reserve(names);
  for (SetImages& folder : files.around) folder.Reserve(names);
  LightField light_field = ReadFrames(document, file, files);
  const JsonPlace top{document.top(), file.string()};
  ReadPointsOf(top, files, light_field);
  if (StampFrom(top) && !fs::exists(files.root / kJournalFile))
    light_field.doubts.push_back(fmt::format(
        "{0}: the journal is missing; {1} alone is read; 'ulf repair {2}' shows how to restore it",
        files.root.string(), file.filename().string(), ShellWord(files.root.string())));
  return light_field;
}

}  // namespace

Rigid3 CamFromOpenGl(const Eigen::Matrix4d& world_from_cam, const std::string& where, const char* key,
                     PoseRotations& rotations) {
  const std::string what = fmt::format("'{}'", key);
  RequireLastRow(world_from_cam.row(3), where, what);
  Eigen::Matrix4d rigid = world_from_cam;
  const Eigen::Matrix3d given = world_from_cam.topLeftCorner<3, 3>();
  const Eigen::Matrix3d nearest =
      rotations.Read(given, where, "the upper left of " + what).toRotationMatrix();
  constexpr double kRounding = 1e-9;  // a rotation stays as it is, to the last digit
  if ((nearest - given).cwiseAbs().maxCoeff() > kRounding) rigid.topLeftCorner<3, 3>() = nearest;
  rigid.row(3) << 0, 0, 0, 1;
  return Rigid3::FromMatrix(rigid * OpenGlFromOurs()).Inverse();
}

LightField ReadTransformsJson(const fs::path& file) { return ReadDocument(file, {.root = FolderOf(file)}); }

LightField ReadTransformsSet(const fs::path& file, const fs::path& images, bool may_be_poses_alone,
                             std::span<const fs::path> others) {
  FrameFiles files{.may_be_poses_alone = may_be_poses_alone, .root = FolderOf(file)};
  files.around = {SetImages(files.root), SetImages(files.root / "..")};
  if (!images.empty()) files.images.emplace(files.root, images, std::vector<fs::path>());
  return ReadDocument(file, std::move(files), others);
}

LightField ReadTransformsPoses(const fs::path& file) {
  return ReadFrames(Document(file), file,
                    {.are_read = false, .are_poses_wanted = true, .root = FolderOf(file)});
}

TransformsText ReadTransformsText(const fs::path& file) {
  const Document document(file);
  return {ReadFrames(document, file, {.are_read = false, .root = FolderOf(file)}),
          StampFrom({document.top(), file.string()}), document.top().contains("ulf")};
}

json OpenGlRows(const Eigen::Matrix4d& ours) {
  const Eigen::Matrix4d world_from_cam = ours * OpenGlFromOurs();
  json rows = json::array();
  for (int r = 0; r < 4; ++r)
    rows.push_back({world_from_cam(r, 0), world_from_cam(r, 1), world_from_cam(r, 2), world_from_cam(r, 3)});
  return rows;
}

json TransformsDocument(const LightField& light_field, const std::optional<JournalStamp>& made_from) {
  json document;
  const bool one_camera = light_field.cameras.size() == 1;
  if (one_camera) WriteCamera(light_field.cameras.front(), document);
  document["aabb_scale"] = 16;  // instant-ngp: size of the rendered cube, in unit cubes
  if (!light_field.points.empty()) document["ply_file_path"] = kPointsFile;
  json& ours = document["ulf"] = OurKeys(light_field);
  if (made_from) ours["journal"] = {{"bytes", made_from->bytes}, {"crc32", made_from->crc32}};
  if (!one_camera) WriteCameraKind(light_field.cameras, document);
  const auto note_source = [&](int camera, json& object) {
    const std::string source = light_field.CalibrationSource(camera);
    if (!source.empty()) object["calibration_source"] = source;
  };
  if (one_camera) note_source(0, ours);
  // nerfstudio takes masks of all frames or of none.
  const bool all_masked =
      std::ranges::none_of(light_field.views, [](const View& view) { return view.mask_path.empty(); });
  json& frames = document["frames"] = json::array();
  for (const View& view : light_field.views) {
    json frame = {{"file_path", view.image_path},
                  {"transform_matrix", OpenGlRows(view.cam_from_world.Inverse().Matrix())},
                  {"ulf", ViewToJson(view)}};
    if (all_masked) frame["mask_path"] = view.mask_path;
    if (!one_camera) {
      WriteCamera(light_field.CameraOf(view), frame);
      note_source(view.camera, frame["ulf"]);
    }
    frames.push_back(std::move(frame));
  }
  return document;
}

std::string TransformsJsonText(const LightField& light_field, const std::optional<JournalStamp>& made_from) {
  return JsonText(TransformsDocument(light_field, made_from), 1) + "\n";
}

}  // namespace ulf
