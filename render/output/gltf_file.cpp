#include "render/output/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/error.h"
#include "core/geometry/small_matrices.h"
#include "render/output/glb.h"

namespace ulf::render {
namespace {

using nlohmann::ordered_json;

constexpr int kFilterLinear = 9729, kFilterMipmaps = 9987, kClampToEdge = 33071;  // of the specification

std::vector<float> FlatNumbers(const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> numbers;
  numbers.reserve(3 * points.size());
  for (const Eigen::Vector3f& point : points)
    numbers.insert(numbers.end(), {point.x(), point.y(), point.z()});
  return numbers;
}

ordered_json PrimitiveOf(const GltfModel& model, ordered_json& document, GlbBuffer& buffer) {
  const TriangleMesh& mesh = model.mesh;
  const std::vector<float> positions = FlatNumbers(mesh.vertices);
  const std::size_t position =
      buffer.AddAccessor(positions, kGltfFloat, "VEC3", mesh.vertices.size(), kGltfVertices);
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
    attributes["TEXCOORD_0"] =
        buffer.AddAccessor(places, kGltfFloat, "VEC2", model.texel.size(), kGltfVertices);
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
        buffer.AddAccessor(colors, kGltfUnsignedShort, "VEC4", model.colors.size(), kGltfVertices);
    document["accessors"][color]["normalized"] = true;
    attributes["COLOR_0"] = color;
  }
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  return {{"attributes", std::move(attributes)},
          {"indices", buffer.AddAccessor(corners, kGltfUnsignedInt, "SCALAR", corners.size(), kGltfIndices)},
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
  GlbBuffer buffer(document);
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
  return GlbOf(document, buffer, model.name,
               fmt::format("fewer {} or a smaller {}", Parameter("triangles"), Parameter("texture")));
}

}  // namespace ulf::render
