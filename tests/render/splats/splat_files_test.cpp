// Tests: render/splats/splat_files, render/splats/spz_file, render/output/glb.
//
// The three files, read back byte by byte as their descriptions say.
#include "render/splats/splat_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "render/splats/spz_file.h"
#include "tests/support/floors.h"

namespace ulf::splat_files_test {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;
using nlohmann::json;
using testing::HasSubstr;
using testing::ThrowsMessage;

// Gaussians whose every number differs. Those of `upright` rotations have a large w, as the product's have.
Gaussians Drawn(int count, float reach, bool upright = true) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1, 1);
  Gaussians gaussians;
  for (int i = 0; i < count; ++i) {
    Gaussian& g = gaussians.emplace_back();
    g.position_in_world = reach * Vector3f(unit(random), unit(random), unit(random));
    const float half = upright ? 0.5f : 1;
    g.world_from_axes =
        Gaussian::Rotation(1, half * unit(random), half * unit(random), half * unit(random)).normalized();
    for (int c = 0; c < 3; ++c) g.scale[c] = std::exp(3 * unit(random) - 4);
    g.opacity = 0.5f + 0.45f * unit(random);
    for (auto& harmonic : g.harmonics) harmonic = 0.8f * Vector3f(unit(random), unit(random), unit(random));
  }
  return gaussians;
}

template <typename Value>
Value ValueAt(const std::string& bytes, std::size_t at) {
  Value value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Matrix3f Covariance(const Vector3f& scale, const Gaussian::Rotation& rotation) {
  const Matrix3f axes = rotation.toRotationMatrix();
  return axes * scale.array().square().matrix().asDiagonal() * axes.transpose();
}

TEST(SplatPly, HoldsTheTrainersLayout) {
  const Gaussians gaussians = Drawn(7, 3, false);
  const std::string bytes = SplatPlyBytes(gaussians);
  const std::size_t end = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, end));
  std::string line;
  std::vector<std::string> lines, names;
  while (std::getline(header, line))
    line.starts_with("property float ") ? names.push_back(line.substr(15)) : lines.push_back(line);
  EXPECT_THAT(lines, testing::ElementsAre("ply", "format binary_little_endian 1.0", "element vertex 7",
                                          "end_header"));
  EXPECT_THAT(
      names, testing::ElementsAre("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0",
                                  "f_rest_1", "f_rest_2", "f_rest_3", "f_rest_4", "f_rest_5", "f_rest_6",
                                  "f_rest_7", "f_rest_8", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
                                  "rot_1", "rot_2", "rot_3"));
  ASSERT_EQ(bytes.size(), end + 7 * 26 * 4);
  for (std::size_t i = 0; i < 7; ++i) {
    const auto at = [&](std::size_t n) { return ValueAt<float>(bytes, end + (26 * i + n) * 4); };
    const Gaussian& g = gaussians[i];
    for (int c = 0; c < 3; ++c) {
      const auto n = static_cast<std::size_t>(c);
      EXPECT_EQ(at(n), g.position_in_world[c]);
      EXPECT_EQ(at(6 + n), g.harmonics[0][c]);
      for (std::size_t h = 0; h < 3; ++h)
        EXPECT_EQ(at(9 + 3 * n + h), g.harmonics[h + 1][c]);  // channel by channel
      EXPECT_NEAR(std::exp(at(19 + n)), g.scale[c], 1e-6 * static_cast<double>(g.scale[c]));
    }
    EXPECT_NEAR(1 / (1 + std::exp(-at(18))), g.opacity, 1e-6);
    EXPECT_EQ(at(22), g.world_from_axes.w());
    EXPECT_EQ(at(23), g.world_from_axes.x());
    EXPECT_EQ(at(24), g.world_from_axes.y());
    EXPECT_EQ(at(25), g.world_from_axes.z());
    EXPECT_NEAR(Vector3f(at(3), at(4), at(5)).norm(), 1, 1e-6);
  }
}

std::string Gunzipped(const std::string& bytes) {
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 16 + MAX_WBITS), Z_OK);  // gzip alone
  std::string text(1 << 20, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(text.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  text.resize(stream.total_out);
  inflateEnd(&stream);
  return text;
}

struct SpzRead {
  int fractional_bits = 0;
  Gaussians gaussians;
};

// As the format's description says, its axes turned back to y down and z forward.
SpzRead ReadSpz(const std::string& file) {
  const std::string bytes = Gunzipped(file);
  EXPECT_EQ(bytes.substr(0, 4), "NGSP");
  EXPECT_EQ(ValueAt<std::uint32_t>(bytes, 4), 2u);
  const std::size_t count = ValueAt<std::uint32_t>(bytes, 8);
  EXPECT_EQ(bytes[12], 1);  // degree
  EXPECT_EQ(bytes[14], 0);
  EXPECT_EQ(bytes[15], 0);
  SpzRead read{bytes[13], Gaussians(count)};
  EXPECT_EQ(bytes.size(), 16 + count * (9 + 1 + 3 + 3 + 3 + 9));
  std::size_t next = 16;
  const auto byte = [&] { return static_cast<float>(static_cast<std::uint8_t>(bytes[next++])); };
  const Vector3f turned(1, -1, -1);
  for (Gaussian& g : read.gaussians)
    for (int c = 0; c < 3; ++c, next += 3) {
      std::int32_t fixed = 0;
      std::memcpy(&fixed, bytes.data() + next, 3);
      fixed = (fixed << 8) >> 8;  // the sign
      g.position_in_world[c] = turned[c] * static_cast<float>(std::ldexp(fixed, -read.fractional_bits));
    }
  for (Gaussian& g : read.gaussians) g.opacity = byte() / 255;
  for (Gaussian& g : read.gaussians)
    for (int c = 0; c < 3; ++c) g.harmonics[0][c] = (byte() / 255 - 0.5f) / 0.15f;
  for (Gaussian& g : read.gaussians)
    for (int c = 0; c < 3; ++c) g.scale[c] = std::exp(byte() / 16 - 10);
  for (Gaussian& g : read.gaussians) {
    Vector3f xyz;
    for (int c = 0; c < 3; ++c) xyz[c] = turned[c] * (byte() / 127.5f - 1);
    g.world_from_axes = {std::sqrt(std::max(0.0f, 1 - xyz.squaredNorm())), xyz.x(), xyz.y(), xyz.z()};
  }
  for (Gaussian& g : read.gaussians)
    for (std::size_t h = 1; h < 4; ++h)
      for (int c = 0; c < 3; ++c) g.harmonics[h][c] = (h == 3 ? 1.0f : -1.0f) * (byte() - 128) / 128;
  return read;
}

TEST(Spz, HoldsTheGaussiansToItsBits) {
  for (const float reach : {0.5f, 3.0f, 100.0f, 2040.0f}) {
    const Gaussians gaussians = Drawn(50, reach);
    const SpzRead read = ReadSpz(SpzBytes(gaussians));
    EXPECT_GE(read.fractional_bits, 12) << reach;
    ASSERT_EQ(read.gaussians.size(), gaussians.size());
    for (std::size_t i = 0; i < gaussians.size(); ++i) {
      const Gaussian &g = gaussians[i], &r = read.gaussians[i];
      EXPECT_LT((g.position_in_world - r.position_in_world).norm(), 1e-6f * reach + 2e-4f) << reach;
      EXPECT_NEAR(g.opacity, r.opacity, 0.5 / 255 + 1e-6);
      for (std::size_t h = 0; h < 4; ++h)
        EXPECT_LT((g.harmonics[h] - r.harmonics[h]).cwiseAbs().maxCoeff(), h == 0 ? 0.0132 : 0.0040) << h;
      EXPECT_LT((g.scale.array() / r.scale.array()).log().abs().maxCoeff(), 0.0313);
      EXPECT_LT(g.world_from_axes.angularDistance(r.world_from_axes), 0.02);
    }
  }
}

// Of the scene's seven metres a thousandth of a millimetre, not a quarter.
TEST(Spz, UsesTheBitsThatASmallSceneLeaves) {
  EXPECT_EQ(ReadSpz(SpzBytes(Drawn(9, 2000))).fractional_bits, 12);
  EXPECT_EQ(ReadSpz(SpzBytes(Drawn(9, 6))).fractional_bits, 20);
}

TEST(Spz, RefusesWhatItsRangeDoesNotHold) {
  Gaussians gaussians = Drawn(9, 100);
  gaussians[3].position_in_world.x() = 2047.9999f;  // would round up to the end of the range
  EXPECT_NEAR(ReadSpz(SpzBytes(gaussians)).gaussians[3].position_in_world.x(), 2048, 1e-3);
  gaussians[3].position_in_world.y() = -2048.5f;
  EXPECT_THAT([&] { SpzBytes(gaussians); }, ThrowsMessage<Error>(HasSubstr("up to 2048 units")));
  gaussians = Drawn(9, 0.001f);
  for (Gaussian& g : gaussians) g.scale *= 1e-5f;
  EXPECT_THAT([&] { SpzBytes(gaussians); }, ThrowsMessage<Error>(HasSubstr("sizes from 4.5e-05")));
}

TEST(SplatGlb, FollowsTheDraft) {
  const Gaussians gaussians = Drawn(6, 3, false);
  const std::string file =
      SplatGlbBytes(gaussians, Eigen::Vector3d(0.2, -1, 0.1).normalized(), "vase", "metres");
  ASSERT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(ValueAt<std::uint32_t>(file, 8), file.size());
  const std::size_t text = ValueAt<std::uint32_t>(file, 12);
  const json document = JsonFromText(file.substr(20, text));
  const std::string buffer = file.substr(28 + text);
  EXPECT_EQ(document["extensionsUsed"], json({"KHR_gaussian_splatting"}));
  const json& primitive = document["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["mode"], 0);
  EXPECT_EQ(primitive["extensions"]["KHR_gaussian_splatting"], json({{"kernel", "ellipse"},
                                                                     {"colorSpace", "srgb_rec709_display"},
                                                                     {"sortingMethod", "cameraDistance"},
                                                                     {"projection", "perspective"}}));
  const auto floats = [&](const std::string& name, int width) {
    const json& accessor = document["accessors"][primitive["attributes"][name].get<std::size_t>()];
    EXPECT_EQ(accessor["componentType"], 5126) << name;
    EXPECT_EQ(accessor["type"], width == 1 ? "SCALAR" : width == 3 ? "VEC3" : "VEC4") << name;
    EXPECT_EQ(accessor["count"], 6) << name;
    const json& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    std::vector<float> numbers(static_cast<std::size_t>(6 * width));
    std::memcpy(numbers.data(), buffer.data() + view["byteOffset"].get<std::size_t>(), 4 * numbers.size());
    return numbers;
  };
  const std::string prefix = "KHR_gaussian_splatting:";
  const auto at = floats("POSITION", 3), rotations = floats(prefix + "ROTATION", 4),
             scales = floats(prefix + "SCALE", 3), opacities = floats(prefix + "OPACITY", 1);
  std::array<std::vector<float>, 4> harmonics{
      floats(prefix + "SH_DEGREE_0_COEF_0", 3), floats(prefix + "SH_DEGREE_1_COEF_0", 3),
      floats(prefix + "SH_DEGREE_1_COEF_1", 3), floats(prefix + "SH_DEGREE_1_COEF_2", 3)};
  // y is up: the turn that the file tells takes the world's up there.
  const json& q = document["nodes"][0]["extras"]["gltf_from_world"];
  const Matrix3f turn = Eigen::Quaternionf(q[3], q[0], q[1], q[2]).toRotationMatrix();
  EXPECT_LT((turn * Vector3f(0.2f, -1, 0.1f).normalized() - Vector3f::UnitY()).norm(), 1e-5);
  for (std::size_t i = 0; i < 6; ++i) {
    const Gaussian& g = gaussians[i];
    const auto vector = [&](const std::vector<float>& of) {
      return Vector3f(of[3 * i], of[3 * i + 1], of[3 * i + 2]);
    };
    EXPECT_LT((vector(at) - turn * g.position_in_world).norm(), 1e-5);
    EXPECT_NEAR(opacities[i], g.opacity, 1e-6);
    const Vector3f scale = vector(scales);
    const Gaussian::Rotation rotation(rotations[4 * i + 3], rotations[4 * i], rotations[4 * i + 1],
                                      rotations[4 * i + 2]);
    const Matrix3f expected = turn * Covariance(g.scale, g.world_from_axes) * turn.transpose();
    EXPECT_LT((Covariance(scale, rotation) - expected).norm(), 1e-4f * expected.norm());
    // The colour that a direction shows stays with the direction.
    for (const Vector3f& direction : {Vector3f(0.6f, 0, 0.8f), Vector3f(0, -0.6f, 0.8f), Vector3f(1, 0, 0)}) {
      const Vector3f there = turn * direction;
      const Vector3f shown =
          0.2820948f * vector(harmonics[0]) +
          0.4886025f * (-there.y() * vector(harmonics[1]) + there.z() * vector(harmonics[2]) -
                        there.x() * vector(harmonics[3])) +
          Vector3f::Constant(0.5f);
      EXPECT_LT((shown.cwiseMax(0) - ColorOf(g, HarmonicsAt(direction))).norm(), 1e-5);
    }
  }
}

}  // namespace
}  // namespace ulf::splat_files_test
