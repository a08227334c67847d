#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <sstream>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/geometry/angles.h"
#include "core/geometry/similarity3.h"
#include "core/light_field/exchange/readers/metashape_sensor.h"
#include "core/light_field/formats/fitted_lens.h"
#include "core/light_field/formats/xml_file.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr double kGeocentric = 1e5;

bool IsEnabled(const XmlElement& camera) {
  const std::string enabled = Lowercase(camera.Attribute("enabled").value_or("true"));
  return enabled != "0" && enabled != "false";
}

std::vector<XmlElement> CamerasOf(const XmlElement& chunk) {
  const auto cameras = chunk.Find("cameras");
  return cameras ? cameras->Descendants("camera") : std::vector<XmlElement>();
}

// Returns the cameras by their id.
std::map<std::string, XmlElement> CamerasById(const XmlElement& chunk) {
  std::map<std::string, XmlElement> cameras;
  for (const XmlElement& camera : CamerasOf(chunk))
    if (const auto id = camera.Attribute("id")) cameras.emplace(*id, camera);
  return cameras;
}

// Returns the camera whose transform gives a camera's pose: itself, or the master that it follows in a rig;
// none if neither was aligned.
std::optional<XmlElement> Aligned(const XmlElement& camera, const std::map<std::string, XmlElement>& by_id) {
  if (camera.Find("transform")) return camera;
  const auto master = by_id.find(camera.Attribute("master_id").value_or(""));
  return master != by_id.end() && master->second.Find("transform") ? std::optional(master->second)
                                                                   : std::nullopt;
}

// ---- Transforms ----

Eigen::Matrix3d RotationOf(const XmlElement& element) {
  const std::vector<double> rows = element.Numbers(9);
  return NearestRotation(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data()),
                         element.Where(), "the matrix")
      .toRotationMatrix();
}

// Returns the transform of a chunk or a component, if any.
std::optional<Similarity3> TransformOf(const XmlElement& owner, bool& has_scale) {
  const auto transform = owner.Find("transform");
  if (!transform) return std::nullopt;
  Similarity3 world_from_chunk;
  if (const auto rotation = transform->Find("rotation")) world_from_chunk.rotation = RotationOf(*rotation);
  if (const auto translation = transform->Find("translation")) {
    const std::vector<double> numbers = translation->Numbers(3);
    world_from_chunk.translation = {numbers[0], numbers[1], numbers[2]};
  }
  if (const auto scale = transform->Find("scale")) {
    has_scale = true;
    world_from_chunk.scale = scale->Number();
    if (!(world_from_chunk.scale > 0))
      throw Error("{}: is {}; it must be positive: export the cameras again", scale->Where(),
                  world_from_chunk.scale);
  }
  return world_from_chunk;
}

struct PosedComponent {
  std::string label;
  std::optional<Similarity3> world_from_chunk;
  std::size_t cameras = 0;  // with a pose
};

// Maps cameras to components, and components to the world. A chunk of old files is one component.
class ChunkComponents {
 public:
  explicit ChunkComponents(const XmlElement& chunk) {
    const auto of_chunk = TransformOf(chunk, has_scale_);
    std::string first;
    const auto list = chunk.Find("components");
    if (list) {
      first = list->Attribute("active_id").value_or("");
      for (const XmlElement& component : list->Children("component")) {
        const std::string id = component.Attribute("id").value_or("");
        if (components_.empty() && first.empty()) first = id;
        PosedComponent& made = components_[id];
        made.label = LabelOf(component);
        made.world_from_chunk = TransformOf(component, has_scale_);
        if (!made.world_from_chunk) made.world_from_chunk = of_chunk;
        for (const XmlElement& part : component.Descendants("camera_ids")) {
          std::istringstream ids(part.Text());
          for (std::string camera; ids >> camera;) of_camera_[camera] = id;
        }
      }
    }
    if (!components_.contains(first)) components_[first] = {LabelOf(chunk), of_chunk};
    first_ = first;
    const auto by_id = CamerasById(chunk);
    for (const XmlElement& camera : CamerasOf(chunk))
      if (const auto aligned = Aligned(camera, by_id); aligned && IsEnabled(camera))
        ++components_[IdOf(*aligned)].cameras;
    largest_ = std::ranges::max_element(components_, {}, [](const auto& entry) {
                 return entry.second.cameras;
               })->first;
    Share();
  }

  // Returns none if its component does not share the world of the largest.
  const PosedComponent* Of(const XmlElement& camera) const {
    const PosedComponent& component = components_.at(IdOf(camera));
    return one_world_ || &component == &components_.at(largest_) ? &component : nullptr;
  }
  bool has_scale() const { return has_scale_; }
  std::optional<Eigen::Vector3d> left_out() const { return left_out_; }
  // Returns that of the largest component.
  std::optional<Similarity3> world_from_chunk() const { return components_.at(largest_).world_from_chunk; }

 private:
  std::string IdOf(const XmlElement& camera) const {
    std::string id = camera.Attribute("component_id").value_or("");
    if (const auto listed = of_camera_.find(camera.Attribute("id").value_or(""));
        id.empty() && listed != of_camera_.end())
      id = listed->second;
    if (id.empty()) return first_;
    if (!components_.contains(id))
      throw Error("{} {}: belongs to the component '{}', and there is none; export the cameras again",
                  camera.Where(), LabelOf(camera), id);
    return id;
  }

  // Several components share a world if each has a transform. The largest's origin replaces a geocentric one.
  void Share() {
    one_world_ = std::ranges::all_of(components_, [](const auto& entry) {
      return entry.second.cameras == 0 || entry.second.world_from_chunk;
    });
    const auto& largest = components_.at(largest_).world_from_chunk;
    if (!largest || largest->translation.norm() <= kGeocentric) return;
    left_out_ = largest->translation;
    for (auto& [id, component] : components_)
      if (component.world_from_chunk) component.world_from_chunk->translation -= *left_out_;
  }

  std::map<std::string, PosedComponent> components_;  // by id
  std::map<std::string, std::string> of_camera_;      // by the camera's id
  std::string first_, largest_;
  bool has_scale_ = false, one_world_ = true;
  std::optional<Eigen::Vector3d> left_out_;
};

Similarity3 ChunkFromCam(const XmlElement& camera, PoseRotations& rotations) {
  const XmlElement transform = camera.Child("transform");
  const std::vector<double> rows = transform.Numbers(16);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> chunk_from_cam(rows.data());
  RequireLastRow(chunk_from_cam.row(3), transform.Where(), "the matrix");
  return {1,
          rotations.Read(chunk_from_cam.topLeftCorner<3, 3>(), transform.Where(), "the matrix")
              .toRotationMatrix(),
          chunk_from_cam.topRightCorner<3, 1>()};
}

// Returns where a sensor stands in the rig of its master.
Similarity3 MasterFromSensor(const XmlElement& sensor) {
  Similarity3 place;
  if (const auto rotation = sensor.Find("rotation")) place.rotation = RotationOf(*rotation);
  if (const auto location = sensor.Find("location")) {
    const std::vector<double> numbers = location->Numbers(3);
    place.translation = {numbers[0], numbers[1], numbers[2]};
  }
  return place;
}

Rigid3 CamFromWorldIn(const std::optional<Similarity3>& world_from_chunk, const Similarity3& chunk_from_cam) {
  const Similarity3 world_from_cam = world_from_chunk.value_or(Similarity3()) * chunk_from_cam;
  return Rigid3{Eigen::Quaterniond(world_from_cam.rotation).normalized(), world_from_cam.translation}
      .Inverse();
}

// ---- Units ----

// Returns whether the local coordinate system's unit of length is the metre; so it is if none is said.
bool IsLocalInMetres(const std::string& system) {
  const std::size_t unit = system.rfind("UNIT[");
  if (unit == std::string::npos) return true;
  double metres = 0;
  return std::sscanf(system.c_str() + unit, "UNIT[\"%*[^\"]\",%lf", &metres) == 1 && metres == 1;
}

bool HasScaleBar(const XmlElement& chunk) {
  return std::ranges::any_of(chunk.Descendants("scalebar"), [](const XmlElement& bar) {
    const auto known = bar.Find("reference");
    return known && IsEnabled(*known) && known->Attribute("distance");
  });
}

// Returns whether enough cameras or markers have known places to tell the scale.
bool HasKnownPlaces(const XmlElement& chunk) {
  constexpr std::ptrdiff_t kLeast = 3;
  const auto is_known = [](const XmlElement& place) {
    const auto known = place.Find("reference");
    return known && IsEnabled(*known) && known->Attribute("x");
  };
  const auto markers = chunk.Find("markers");
  return std::ranges::count_if(CamerasOf(chunk), is_known) >= kLeast ||
         (markers && std::ranges::count_if(markers->Descendants("marker"), is_known) >= kLeast);
}

// Returns whether our own export says that units are metres.
bool IsSaidToBeInMetres(const XmlElement& chunk) {
  const auto meta = chunk.Find("meta");
  return meta && std::ranges::any_of(meta->Children("property"), [](const XmlElement& property) {
           return property.Attribute("name") == "ulf/units" && property.Attribute("value") == "metres";
         });
}

// A transform's scale alone does not tell, because every chunk has one.
bool IsInMetres(const XmlElement& chunk, const ChunkComponents& components) {
  if (IsSaidToBeInMetres(chunk)) return true;
  if (!components.has_scale() || components.left_out()) return components.has_scale();
  const auto system = chunk.Find("reference");
  const std::string words = system ? system->Text() : "";
  const bool is_local = words.empty() || words.starts_with("LOCAL_CS");
  return is_local && IsLocalInMetres(words) && (HasScaleBar(chunk) || HasKnownPlaces(chunk));
}

// ---- Chunks ----

std::size_t PosedCamerasOf(const XmlElement& chunk) {
  const auto by_id = CamerasById(chunk);
  return static_cast<std::size_t>(std::ranges::count_if(CamerasOf(chunk), [&](const XmlElement& camera) {
    return IsEnabled(camera) && Aligned(camera, by_id);
  }));
}

// Returns the one with the most cameras that have a pose, the first of equals.
XmlElement ChosenChunk(const XmlElement& document, const fs::path& xml, std::vector<std::string>& doubts) {
  const std::vector<XmlElement> chunks =
      document.Name() == "chunk" ? std::vector<XmlElement>{document} : document.Descendants("chunk");
  std::vector<std::size_t> cameras;
  for (const XmlElement& chunk : chunks) cameras.push_back(PosedCamerasOf(chunk));
  const auto most = std::ranges::max_element(cameras);
  if (most == cameras.end() || *most == 0)
    throw Error(
        "{}: holds no camera with a pose; align the photographs in Metashape, then File > Export > Export "
        "Cameras as Agisoft XML",
        xml.string());
  const auto largest = static_cast<std::size_t>(most - cameras.begin());
  std::vector<std::string> others;
  for (std::size_t i = 0; i < chunks.size(); ++i)
    if (i != largest) others.push_back(LabelOf(chunks[i]));
  if (!others.empty())
    doubts.push_back(
        fmt::format("chunk {} alone is read, the one with the most posed cameras ({}); left out: {}",
                    LabelOf(chunks[largest]), *most, fmt::join(others, ", ")));
  return chunks[largest];
}

// ---- Points ----

// Returns whether photographs show the point under angles by which it can have been measured.
bool IsMeasurable(const Eigen::Vector3d& point, const LightField& light_field) {
  constexpr double kLeastAngle = Radians(1);
  std::optional<Eigen::Vector3d> first;
  return std::ranges::any_of(light_field.views, [&](const View& view) {
    const CameraModel& camera = light_field.CameraOf(view);
    const auto img = camera.ImgFromCam(view.cam_from_world * point);
    if (!img || !camera.Contains(*img)) return false;
    const Eigen::Vector3d from_point = view.CenterInWorld() - point;
    if (first) return AngleBetween(*first, from_point) > kLeastAngle;
    first = from_point;
    return false;
  });
}

// Returns the share of the points, of many of a sample, that photographs can have measured.
double MeasurableShare(const std::vector<ScenePoint>& points, const Similarity3& world_from_points,
                       const LightField& light_field) {
  constexpr std::size_t kMostAsked = 1000;
  const std::size_t asked = std::min(kMostAsked, points.size());
  std::size_t measurable = 0;
  for (std::size_t i = 0; i < asked; ++i)
    measurable +=
        IsMeasurable(world_from_points * points[i * points.size() / asked].position_in_world, light_field);
  return asked == 0 ? 0 : static_cast<double>(measurable) / static_cast<double>(asked);
}

// Reads the points beside the cameras. The file does not say its frame: Metashape exports points in the
// world, in the chunk's own frame, or in a coordinate system of the earth. They are taken if photographs show
// them in one of the first two and few of them in the other.
void ReadPointsBeside(const fs::path& xml, const std::optional<Similarity3>& world_from_chunk,
                      LightField& light_field) {
  constexpr double kMost = 0.5, kFewOf = 0.4;  // share of the points, and of those of the other frame
  const fs::path ply = xml.parent_path() / "points.ply";
  if (!ReadPointPositions(ply, light_field) || light_field.points.empty()) return;
  std::vector<ScenePoint>& points = light_field.points;
  const Similarity3 from_chunk = world_from_chunk.value_or(Similarity3());
  const double in_world = MeasurableShare(points, {}, light_field),
               in_chunk = MeasurableShare(points, from_chunk, light_field);
  const bool is_one_frame = (from_chunk.rotation - Eigen::Matrix3d::Identity()).norm() < 1e-9 &&
                            std::abs(from_chunk.scale - 1) < 1e-9 && from_chunk.translation.norm() < 1e-9;
  if (in_world >= kMost && (is_one_frame || in_chunk < kFewOf * in_world)) return;
  if (in_chunk >= kMost && in_world < kFewOf * in_chunk) {
    for (ScenePoint& point : points) point.position_in_world = from_chunk * point.position_in_world;
    return;
  }
  light_field.doubts.push_back(fmt::format(
      "{}: not used, because its frame is not clear: photographs can have measured {:.0f} % of its points "
      "if they are in the world, {:.0f} % if they are in the chunk's frame; export it in local coordinates, "
      "of a chunk without a transform",
      ply.string(), 100 * in_world, 100 * in_chunk));
  points.clear();
}

}  // namespace

PosedSet ReadMetashapeSet(const fs::path& xml, const fs::path& images) {
  const XmlElement document = ReadXmlFile(xml);
  PosedSet set;
  set.format = "Metashape";
  LightField& light_field = set.light_field;
  const XmlElement chunk = ChosenChunk(document, xml, light_field.doubts);
  const ChunkComponents components(chunk);
  SetImages photographs(fs::absolute(xml).lexically_normal().parent_path(), images,
                        {"images", "photos", ".", ".."});
  std::vector<std::string> labels;
  for (const XmlElement& camera : CamerasOf(chunk)) labels.push_back(camera.Attribute("label").value_or(""));
  photographs.Reserve(labels);
  light_field.root = photographs.folder();

  std::map<std::string, XmlElement> sensors;
  for (const XmlElement& sensor : chunk.Child("sensors").Children("sensor"))
    sensors.emplace(sensor.Attribute("id").value_or(""), sensor);
  std::map<std::string, CameraModel> models;  // by the sensor's id
  std::map<std::string, std::string> taken;   // the camera, by its photograph
  const auto by_id = CamerasById(chunk);
  PoseRotations rotations;
  FittedLenses fitted;
  const ToldOnFailure told(light_field.doubts);
  std::size_t unaligned = 0, disabled = 0, elsewhere = 0, missing = 0, following = 0;
  std::string first_missing;
  for (const XmlElement& camera : CamerasOf(chunk)) {
    const std::string where = camera.Where() + " " + LabelOf(camera);
    const auto aligned = Aligned(camera, by_id);
    if (!aligned || !IsEnabled(camera)) {
      ++(IsEnabled(camera) ? unaligned : disabled);
      continue;
    }
    const PosedComponent* component = components.Of(*aligned);
    if (component == nullptr) {
      ++elsewhere;
      continue;
    }
    const std::string label = camera.Attribute("label").value_or("");
    if (label.empty())
      throw Error("{}: has no label to find its photograph by; export the cameras again", where);
    const std::string path = photographs.Find(label);
    if (path.empty()) {
      if (missing++ == 0) first_missing = label;
      continue;
    }
    const auto [other, is_new] = taken.try_emplace(path, where);
    if (!is_new)
      throw Error("{}: its photograph {} is also that of {}; give the cameras labels of their own", where,
                  path, other->second);
    const std::string sensor_id = camera.Attribute("sensor_id").value_or("");
    const auto sensor = sensors.find(sensor_id);
    if (sensor == sensors.end())
      throw Error("{}: belongs to the sensor '{}', and there is none; export the cameras again", where,
                  sensor_id);
    if (!models.contains(sensor_id)) models.emplace(sensor_id, ModelOfSensor(sensor->second, fitted));
    Similarity3 chunk_from_cam = ChunkFromCam(*aligned, rotations);
    if (!camera.Find("transform")) {
      chunk_from_cam = chunk_from_cam * MasterFromSensor(sensor->second);
      ++following;
    }
    const Rigid3 cam_from_world = CamFromWorldIn(component->world_from_chunk, chunk_from_cam);
    const CameraModel model =
        AtSizeOf(light_field.root / path, models.at(sensor_id), where, light_field.doubts);
    AddView(path, model, cam_from_world, photographs, light_field);
  }
  if (light_field.views.empty())
    throw Error("{}: '{}' and the other photographs of its cameras are not in {}; {}", xml.string(),
                first_missing, light_field.root.string(), ImagesRemedy());
  if (IsInMetres(chunk, components)) light_field.units = "metres";
  ReadPointsBeside(xml, components.world_from_chunk(), light_field);
  rotations.Tell(xml.string(), light_field.doubts);
  fitted.Note(light_field.doubts);
  if (following > 0)
    light_field.doubts.push_back(
        fmt::format("{} of a rig: posed by the master that each follows and the place of its sensor",
                    Counted(following, "camera")));
  NoteUnposed(unaligned, "camera", "not aligned", set);
  NoteUnposed(disabled, "camera", "disabled", set);
  NoteUnposed(elsewhere, "camera", "of components without a transform, beside the largest", set);
  if (missing > 0)
    light_field.doubts.push_back(fmt::format("{} left out: no photograph in {}: {}{}",
                                             Counted(missing, "camera"), light_field.root.string(),
                                             first_missing, missing > 1 ? ", ..." : ""));
  if (const auto left_out = components.left_out())
    light_field.doubts.push_back(
        fmt::format("the geocentric translation ({:.3f}, {:.3f}, {:.3f}) is left out: the world's origin "
                    "is the chunk's",
                    left_out->x(), left_out->y(), left_out->z()));
  return set;
}

}  // namespace ulf
