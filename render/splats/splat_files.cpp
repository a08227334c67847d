#include "render/splats/splat_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/small_matrices.h"
#include "core/image/image.h"
#include "render/output/glb.h"

namespace ulf::render {
namespace {

using Eigen::Vector3f;
using nlohmann::ordered_json;

constexpr float kLeastScale = 1e-12f;  // of which a logarithm is written

Vector3f LogScale(const Gaussian& gaussian) { return gaussian.scale.cwiseMax(kLeastScale).array().log(); }

// The inverse of the logistic function.
float Logit(float opacity) {
  constexpr float kEnd = 1e-6f;
  const float inside = std::clamp(opacity, kEnd, 1 - kEnd);
  return std::log(inside / (1 - inside));
}

// The surface's normal: the axis of the smallest scale.
Vector3f ThinAxisOf(const Gaussian& gaussian) {
  int axis = 0;
  gaussian.scale.minCoeff(&axis);
  return gaussian.world_from_axes.toRotationMatrix().col(axis);
}

void AppendFloats(std::string& bytes, std::initializer_list<float> numbers) {
  bytes.append(reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(float));
}

// The attribute of a prefix of the draft.
std::string Attribute(const std::string& name) { return "KHR_gaussian_splatting:" + name; }

std::vector<float> FlatVectors(const Gaussians& gaussians, const auto& vector_of) {
  std::vector<float> numbers;
  numbers.reserve(3 * gaussians.size());
  for (const Gaussian& gaussian : gaussians) {
    const Vector3f vector = vector_of(gaussian);
    numbers.insert(numbers.end(), {vector.x(), vector.y(), vector.z()});
  }
  return numbers;
}

// The colours of the constant harmonic, linear, with the opacity, for programs that show points.
std::vector<std::uint16_t> PointColors(const Gaussians& gaussians) {
  constexpr float kOne = 65535;
  std::vector<std::uint16_t> colors;
  colors.reserve(4 * gaussians.size());
  for (const Gaussian& gaussian : gaussians) {
    const Vector3f color = ColorOf(gaussian, {kConstantHarmonic, 0, 0, 0});
    for (int c = 0; c < 3; ++c)
      colors.push_back(static_cast<std::uint16_t>(
          std::lround(kOne * std::clamp(LinearFromSrgb(std::min(1.0f, color[c])), 0.0f, 1.0f))));
    colors.push_back(static_cast<std::uint16_t>(std::lround(kOne * gaussian.opacity)));
  }
  return colors;
}

ordered_json AttributesOf(const Gaussians& gaussians, ordered_json& document, GlbBuffer& buffer) {
  const std::size_t count = gaussians.size();
  const auto add = [&](const std::vector<float>& numbers, const char* type) {
    return buffer.AddAccessor(numbers, kGltfFloat, type, count, kGltfVertices);
  };
  ordered_json attributes;
  attributes["POSITION"] =
      add(FlatVectors(gaussians, [](const Gaussian& g) { return g.position_in_world; }), "VEC3");
  Eigen::AlignedBox3f box;
  for (const Gaussian& gaussian : gaussians) box.extend(gaussian.position_in_world);
  ordered_json& position = document["accessors"].back();
  position["min"] = {box.min().x(), box.min().y(), box.min().z()};
  position["max"] = {box.max().x(), box.max().y(), box.max().z()};
  attributes["COLOR_0"] =
      buffer.AddAccessor(PointColors(gaussians), kGltfUnsignedShort, "VEC4", count, kGltfVertices);
  document["accessors"].back()["normalized"] = true;
  attributes[Attribute("SCALE")] =
      add(FlatVectors(gaussians, [](const Gaussian& g) { return g.scale; }), "VEC3");
  std::vector<float> rotations, opacities;
  for (const Gaussian& gaussian : gaussians) {
    const auto& q = gaussian.world_from_axes;
    rotations.insert(rotations.end(), {q.x(), q.y(), q.z(), q.w()});
    opacities.push_back(gaussian.opacity);
  }
  attributes[Attribute("ROTATION")] = add(rotations, "VEC4");
  attributes[Attribute("OPACITY")] = add(opacities, "SCALAR");
  constexpr std::array<const char*, 4> kNames{"SH_DEGREE_0_COEF_0", "SH_DEGREE_1_COEF_0",
                                              "SH_DEGREE_1_COEF_1", "SH_DEGREE_1_COEF_2"};
  for (std::size_t h = 0; h < kNames.size(); ++h)
    attributes[Attribute(kNames[h])] =
        add(FlatVectors(gaussians, [h](const Gaussian& g) { return g.harmonics[h]; }), "VEC3");
  return attributes;
}

}  // namespace

Gaussians Turned(const Gaussians& gaussians, const Eigen::Quaternionf& turned_from_world) {
  const Eigen::Matrix3f turn = turned_from_world.toRotationMatrix();
  Gaussians turned = gaussians;
  for (Gaussian& gaussian : turned) {
    gaussian.position_in_world = turn * gaussian.position_in_world;
    gaussian.world_from_axes = turned_from_world * gaussian.world_from_axes;
    if (gaussian.world_from_axes.w() < 0) gaussian.world_from_axes.coeffs() *= -1;
    auto& [constant, y, z, x] = gaussian.harmonics;  // of -y, z and -x
    for (int c = 0; c < 3; ++c) {
      const Vector3f gradient = turn * Vector3f(-x[c], -y[c], z[c]);
      x[c] = -gradient.x();
      y[c] = -gradient.y();
      z[c] = gradient.z();
    }
  }
  return turned;
}

std::string SplatPlyBytes(const Gaussians& gaussians) {
  std::string names = "x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 ";
  for (int i = 0; i < 9; ++i) names += fmt::format("f_rest_{} ", i);
  names += "opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 ";
  std::string bytes =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", gaussians.size());
  for (std::size_t from = 0; from < names.size();) {
    const std::size_t to = names.find(' ', from);
    bytes += "property float " + names.substr(from, to - from) + "\n";
    from = to + 1;
  }
  bytes += "end_header\n";
  constexpr std::size_t kFloats = 26;
  bytes.reserve(bytes.size() + kFloats * sizeof(float) * gaussians.size());
  for (const Gaussian& gaussian : gaussians) {
    const Vector3f &at = gaussian.position_in_world, normal = ThinAxisOf(gaussian),
                   scale = LogScale(gaussian);
    const auto& h = gaussian.harmonics;
    const auto& q = gaussian.world_from_axes;
    AppendFloats(bytes, {at.x(), at.y(), at.z(), normal.x(), normal.y(), normal.z()});
    AppendFloats(bytes, {h[0][0], h[0][1], h[0][2]});
    for (int c = 0; c < 3; ++c) AppendFloats(bytes, {h[1][c], h[2][c], h[3][c]});
    AppendFloats(bytes, {Logit(gaussian.opacity), scale.x(), scale.y(), scale.z()});
    AppendFloats(bytes, {q.w(), q.x(), q.y(), q.z()});
  }
  return bytes;
}

std::string SplatGlbBytes(const Gaussians& gaussians, const Eigen::Vector3d& up_in_world,
                          const std::string& name, const std::string& units) {
  const Eigen::Quaterniond turn = TurnBetween(up_in_world, Eigen::Vector3d::UnitY());
  ordered_json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "ulf"}};
  document["extensionsUsed"] = {"KHR_gaussian_splatting"};
  document["scene"] = 0;
  document["scenes"] = ordered_json::array({{{"name", name}, {"nodes", {0}}}});
  document["nodes"] = ordered_json::array(
      {{{"name", name},
        {"mesh", 0},
        {"extras", {{"units", units}, {"gltf_from_world", {turn.x(), turn.y(), turn.z(), turn.w()}}}}}});
  GlbBuffer buffer(document);
  ordered_json attributes = AttributesOf(Turned(gaussians, turn.cast<float>()), document, buffer);
  const ordered_json splatting = {{"kernel", "ellipse"},
                                  {"colorSpace", "srgb_rec709_display"},
                                  {"sortingMethod", "cameraDistance"},
                                  {"projection", "perspective"}};
  const ordered_json primitive = {{"attributes", std::move(attributes)},
                                  {"mode", 0},
                                  {"extensions", {{"KHR_gaussian_splatting", splatting}}}};
  document["meshes"] =
      ordered_json::array({{{"name", name}, {"primitives", ordered_json::array({primitive})}}});
  return GlbOf(document, buffer, name, fmt::format("fewer {}", Parameter("most")));
}

}  // namespace ulf::render
