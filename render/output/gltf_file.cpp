#include "render/output/gltf_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/small_matrices.h"

namespace ulf::render {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little,
              "glTF's numbers are little-endian, and written as they are");

// These are constants of the specification.
constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123;
constexpr int kVertices = 34962, kIndices = 34963;  // ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER
constexpr int kFilterLinear = 9729, kFilterMipmaps = 9987, kClampToEdge = 33071;

// The file's one buffer, in views that begin at multiples of four bytes.
class GltfBuffer {
 public:
  explicit GltfBuffer(ordered_json& document) : document_(document) {}
  std::size_t AddView(const void* data, std::size_t size, int target) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    ordered_json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    bytes_.append(static_cast<const char*>(data), size);
    document_["bufferViews"].push_back(std::move(view));
    return document_["bufferViews"].size() - 1;
  }
  template <typename Value>
  std::size_t AddAccessor(const std::vector<Value>& values, int component, const char* type,
                          std::size_t count, int target) {
    const std::size_t view = AddView(values.data(), values.size() * sizeof(Value), target);
    document_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return document_["accessors"].size() - 1;
  }
  std::string Take() {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    return std::move(bytes_);
  }

 private:
  ordered_json& document_;
  std::string bytes_;
};

std::vector<float> FlatNumbers(const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> numbers;
  numbers.reserve(3 * points.size());
  for (const Eigen::Vector3f& point : points)
    numbers.insert(numbers.end(), {point.x(), point.y(), point.z()});
  return numbers;
}

ordered_json PrimitiveOf(const GltfModel& model, ordered_json& document, GltfBuffer& buffer) {
  const TriangleMesh& mesh = model.mesh;
  const std::vector<float> positions = FlatNumbers(mesh.vertices);
  const std::size_t position = buffer.AddAccessor(positions, kFloat, "VEC3", mesh.vertices.size(), kVertices);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  document["accessors"][position]["min"] = {box.min().x(), box.min().y(), box.min().z()};
  document["accessors"][position]["max"] = {box.max().x(), box.max().y(), box.max().z()};
  ordered_json attributes = {{"POSITION", position}};
  if (!model.texture_png.empty()) {
    std::vector<float> places;
    for (const Eigen::Vector2f& texel : model.texel) {
      places.push_back(texel.x() / static_cast<float>(model.texture_size.width));
      places.push_back(texel.y() / static_cast<float>(model.texture_size.height));
    }
    attributes["TEXCOORD_0"] = buffer.AddAccessor(places, kFloat, "VEC2", model.texel.size(), kVertices);
  }
  if (!model.colors.empty()) {
    std::vector<std::uint16_t> colors;  // red, green, blue, opaque: a multiple of four bytes for each vertex
    constexpr float kOne = 65535;
    for (const cv::Vec3f& bgr : model.colors) {
      for (const int channel : {2, 1, 0})
        colors.push_back(
            static_cast<std::uint16_t>(std::lround(std::clamp(bgr[channel], 0.0f, 1.0f) * kOne)));
      colors.push_back(static_cast<std::uint16_t>(kOne));
    }
    const std::size_t color =
        buffer.AddAccessor(colors, kUnsignedShort, "VEC4", model.colors.size(), kVertices);
    document["accessors"][color]["normalized"] = true;
    attributes["COLOR_0"] = color;
  }
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  return {{"attributes", std::move(attributes)},
          {"indices", buffer.AddAccessor(corners, kUnsignedInt, "SCALAR", corners.size(), kIndices)},
          {"material", 0},
          {"mode", 4}};
}

ordered_json NodeOf(const GltfCamera& camera, std::size_t index) {
  const Rigid3 world_from_cam = camera.cam_from_world.Inverse();
  // The axes y up and z back are half a turn about x.
  const Eigen::Quaterniond turned = (world_from_cam.rotation * Eigen::Quaterniond(0, 1, 0, 0)).normalized();
  const Eigen::Vector3d& at = world_from_cam.translation;
  ordered_json node = {{"name", camera.name},
                       {"camera", index},
                       {"rotation", {turned.x(), turned.y(), turned.z(), turned.w()}},
                       {"translation", {at.x(), at.y(), at.z()}}};
  if (!camera.extras.is_null()) node["extras"] = camera.extras;
  return node;
}

void RequireGltfCamera(const GltfCamera& camera) {
  const CameraModel& lens = camera.camera;
  if (lens.distortion != Distortion::kNone || 2 * lens.cx != lens.width || 2 * lens.cy != lens.height)
    throw Error(
        "{}: glTF has cameras without distortion and with the principal point in the middle alone; "
        "undistort it",
        camera.name);
}

void AppendChunk(std::string& file, const char* type, const std::string& bytes) {
  const auto size = static_cast<std::uint32_t>(bytes.size());
  file.append(reinterpret_cast<const char*>(&size), sizeof(size));
  file.append(type, 4);
  file += bytes;
}

}  // namespace

std::string GlbBytes(const GltfModel& model) {
  ordered_json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "ulf"}};
  document["extensionsUsed"] = {"KHR_materials_unlit"};
  document["scene"] = 0;
  document["scenes"] = ordered_json::array({{{"name", model.name}, {"nodes", {0}}}});
  document["nodes"] = ordered_json::array();
  const Eigen::Quaterniond gltf_from_world = TurnBetween(model.up_in_world, Eigen::Vector3d::UnitY());
  ordered_json world = {
      {"name", "world"},
      {"rotation", {gltf_from_world.x(), gltf_from_world.y(), gltf_from_world.z(), gltf_from_world.w()}},
      {"children", {1}},
      {"extras", {{"units", model.units}}}};
  for (std::size_t i = 0; i < model.cameras.size(); ++i) world["children"].push_back(2 + i);
  document["nodes"].push_back(std::move(world));
  document["nodes"].push_back({{"name", model.name}, {"mesh", 0}});
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const GltfCamera& camera = model.cameras[i];
    RequireGltfCamera(camera);
    document["nodes"].push_back(NodeOf(camera, i));
    const double tan_x = 0.5 * camera.camera.width / camera.camera.fx;
    const double tan_y = 0.5 * camera.camera.height / camera.camera.fy;
    document["cameras"].push_back(
        {{"name", camera.name},
         {"type", "perspective"},
         {"perspective",
          {{"yfov", 2 * std::atan(tan_y)}, {"aspectRatio", tan_x / tan_y}, {"znear", model.near_distance}}}});
  }
  GltfBuffer buffer(document);
  const ordered_json primitive = PrimitiveOf(model, document, buffer);
  document["meshes"] =
      ordered_json::array({{{"name", model.name}, {"primitives", ordered_json::array({primitive})}}});
  ordered_json material = {{"name", "photographs"},
                           {"doubleSided", true},
                           {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                           {"extensions", {{"KHR_materials_unlit", ordered_json::object()}}}};
  if (!model.texture_png.empty()) {
    material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    const std::size_t view = buffer.AddView(model.texture_png.data(), model.texture_png.size(), 0);
    document["images"] = ordered_json::array({{{"bufferView", view}, {"mimeType", "image/png"}}});
    document["samplers"] = ordered_json::array({{{"magFilter", kFilterLinear},
                                                 {"minFilter", kFilterMipmaps},
                                                 {"wrapS", kClampToEdge},
                                                 {"wrapT", kClampToEdge}}});
    document["textures"] = ordered_json::array({{{"sampler", 0}, {"source", 0}}});
  }
  document["materials"] = ordered_json::array({std::move(material)});
  const std::string bytes = buffer.Take();
  document["buffers"] = ordered_json::array({{{"byteLength", bytes.size()}}});
  std::string text = JsonText(document);
  text.resize((text.size() + 3) / 4 * 4, ' ');

  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  const std::size_t size = kHeader + 2 * kChunkHeader + text.size() + bytes.size();
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Error("{}: {:.1f} GB; a .glb has at most 4: give fewer {} or a smaller {}", model.name,
                static_cast<double>(size) / 1e9, Parameter("triangles"), Parameter("texture"));
  std::string file("glTF");
  for (const std::uint32_t number : {std::uint32_t{2}, static_cast<std::uint32_t>(size)})
    file.append(reinterpret_cast<const char*>(&number), sizeof(number));
  AppendChunk(file, "JSON", text);
  AppendChunk(file, std::string("BIN\0", 4).c_str(), bytes);
  return file;
}

}  // namespace ulf::render
