// Tests: render/proxy/mesh_file, render/proxy/ply_polygons, render/proxy/obj_polygons,
// render/proxy/polygon_soup, render/proxy/triangle_mesh.
#include "render/proxy/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::mesh_file_test {
namespace {

using Eigen::Vector3f;
using testing::ElementsAre;
using testing::HasSubstr;

MeshReading Read(const std::string& name, const std::string& bytes) {
  const test::ScratchFolder scratch;
  std::ofstream(scratch / name, std::ios::binary) << bytes;
  return ReadMeshFile(scratch / name);
}

std::string WhatIsWrong(const std::string& name, const std::string& bytes) {
  try {
    Read(name, bytes);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles)
    area +=
        0.5 *
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm();
  return area;
}

// A unit square in z = 1 and a triangle beside it, in whatever format.
const std::string kHead =
    "comment by hand\nelement vertex 5\nproperty double x\nproperty float y\nproperty uchar red\nproperty "
    "short z\n"
    "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
    "element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n";

template <typename T>
void Append(std::string& bytes, T value, bool big) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string BinaryPly(bool big) {
  std::string bytes =
      std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") + " 1.0\n" + kHead;
  for (const auto& [x, y] : {std::pair{0., 0.}, {1., 0.}, {1., 1.}, {0., 1.}, {2., 0.}}) {
    Append<double>(bytes, x, big);
    Append<float>(bytes, static_cast<float>(y), big);
    Append<std::uint8_t>(bytes, 200, big);
    Append<std::int16_t>(bytes, 1, big);
  }
  for (int i : {3, 4}) Append<std::int32_t>(bytes, i, big);
  for (const std::vector<int>& face : {std::vector<int>{0, 1, 2, 3}, {1, 4, 2}}) {
    Append<std::uint8_t>(bytes, 9, big);
    Append<std::uint8_t>(bytes, static_cast<std::uint8_t>(face.size()), big);
    for (int corner : face) Append<std::int32_t>(bytes, corner, big);
  }
  return bytes;
}

TEST(MeshFile, ReadsPlyOfEveryFormat) {
  const std::string ascii =
      "ply\r\nformat ascii 1.0\r\n" + kHead +
      "0 0 200 1\n1 0 200 1\n1 1.0 200 1\n0 +1e0 200 1\n2 0 200 1\n3 4\n9 4 0 1 2 3\n9 3 1 4 2";
  for (const std::string& bytes : {ascii, BinaryPly(false), BinaryPly(true)}) {
    const MeshReading reading = Read("mesh.ply", bytes);
    ASSERT_EQ(reading.mesh.vertices.size(), 5u);
    EXPECT_EQ(reading.mesh.vertices[2], Vector3f(1, 1, 1));
    EXPECT_EQ(reading.mesh.vertices[4], Vector3f(2, 0, 1));
    ASSERT_EQ(reading.mesh.triangles.size(), 3u);
    EXPECT_NEAR(Area(reading.mesh), 1.5, 1e-6);
    for (const Vector3f& normal : VertexNormals(reading.mesh)) EXPECT_EQ(normal, Vector3f(0, 0, 1));
    EXPECT_EQ(reading.Dropped(), "");
  }
}

TEST(MeshFile, ReadsObjAndIgnoresOtherAttributes) {
  const MeshReading reading =
      Read("mesh.OBJ",
           "# by hand\nmtllib a.mtl\nv 0 0 1 0.5 0.5 0.5\nv 1 0 1\r\nvt 0 0\nvn 0 0 1\nv 1 1 1\nv 0 1 1\n"
           "f 1/1/1 2//1 3/1 \\\n 4\nv 2 0 1\nf -4 -1 -3\ng end\nl 1 2\n");
  ASSERT_EQ(reading.mesh.vertices.size(), 5u);
  EXPECT_EQ(reading.mesh.triangles.size(), 3u);
  EXPECT_NEAR(Area(reading.mesh), 1.5, 1e-6);
  for (const Vector3f& normal : VertexNormals(reading.mesh)) EXPECT_EQ(normal, Vector3f(0, 0, 1));
}

// A fan from the first corner would cover what lies outside.
TEST(MeshFile, CutsPolygonsThatAreNotConvex) {
  for (int first = 0; first < 8; ++first) {
    const std::vector<Vector3f> star{{0, 4, 0},  {-1, 1, 0}, {-4, 0, 0}, {-1, -1, 0},
                                     {0, -4, 0}, {1, -1, 0}, {4, 0, 0},  {1, 1, 0}};
    std::string obj, face = "f";
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisf(static_cast<float>(0.3 + first), Vector3f(1, 2, 3).normalized()).toRotationMatrix();
    for (const Vector3f& corner : star) {
      const Vector3f p = turn * corner;
      obj += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
    }
    for (int i = 0; i < 8; ++i) face += fmt::format(" {}", (first + i) % 8 + 1);
    const MeshReading reading = Read("star.obj", obj + face);
    EXPECT_EQ(reading.mesh.triangles.size(), 6u);
    EXPECT_NEAR(Area(reading.mesh), 16, 1e-4) << "from corner " << first;
    const Vector3f front = turn * Vector3f(0, 0, 1);
    for (const Vector3f& normal : VertexNormals(reading.mesh)) EXPECT_LT((normal - front).norm(), 1e-4);
  }
}

TEST(MeshFile, DropsWhatIsNotFiniteAndSaysSo) {
  const MeshReading reading = Read(
      "nan.obj",
      "v 0 0 0\nv nan 0 0\nv 1 0 0\nv 0 1 0\nv inf 1 1\nv 1e300 0 0\nf 1 3 4\nf 1 2 3\nf 1 3 5 4\nf 1 1 3\n");
  EXPECT_EQ(reading.mesh.vertices.size(), 3u);
  ASSERT_EQ(reading.mesh.triangles.size(), 1u);
  EXPECT_THAT(reading.mesh.triangles[0], ElementsAre(0, 1, 2));
  EXPECT_EQ(reading.Dropped(),
            "dropped 3 vertices that are not finite and 2 faces at them, and 1 face with fewer than three "
            "different corners");
}

TEST(MeshFile, SaysWhatIsWrongWithAFile) {
  const std::string good = BinaryPly(false);
  const std::string three =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  struct Case {
    std::string name, bytes, says;
  };
  for (const Case& c : {
           Case{"empty.ply", "", "empty"},
           Case{"a.stl", "solid thing\n", "neither a PLY file nor an OBJ file"},
           Case{"head.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "header has no end"},
           Case{"format.ply", "ply\nelement vertex 0\nend_header\n", "no known format"},
           Case{"type.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n",
                "'property half x' is unknown"},
           Case{"short.ply", good.substr(0, good.size() - 3), "truncated"},
           Case{"half.ply", good.substr(0, good.size() / 2 + 60), "truncated"},
           Case{"huge.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 3999999999\nproperty float "
                "x\nend_header\n",
                "truncated"},
           Case{"word.ply", three + "0 0 0\n1 0 0\n0 one 0\n3 0 1 2\n", "'one' is not a number"},
           Case{"far.ply", three + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a vertex that does not exist"},
           Case{"back.ply", three + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "a vertex that does not exist"},
           Case{"half_corner.ply", three + "0 0 0\n1 0 0\n0 1 0\n2.5 0 1 2\n", "2.5 corners"},
           Case{"cloud.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                "no triangles in it (0 faces)"},
           Case{"nan.ply", three + "0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", "dropped 1 vertex"},
           Case{"two.obj", "v 0 0\n", "line 1: a vertex needs three numbers"},
           Case{"far.obj", "v 0 0 0\nf 1 2 3\n", "line 2: a face names vertex 2, there are 1"},
           Case{"zero.obj", "v 0 0 0\nf 0 1 1\n", "line 2"},
           Case{"word.obj", "v 0 0 0\nf 1 x 1\n", "'x' is not a corner"},
           Case{"nothing.obj", "# nothing\n", "no triangles"},
       }) {
    const std::string says = WhatIsWrong(c.name, c.bytes);
    EXPECT_THAT(says, HasSubstr(c.says)) << c.name;
    EXPECT_THAT(says, HasSubstr(c.name));
  }
  EXPECT_THROW(ReadMeshFile("/nowhere/mesh.ply"), Error);
}

TEST(TriangleMesh, NormalsAreMeansByArea) {
  // Two triangles at a right angle along an edge, one of twice the size, and a vertex without a triangle.
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 1}, {9, 9, 9}}, {{0, 1, 2}, {0, 3, 1}}};
  const auto normals = VertexNormals(mesh);
  EXPECT_LT((normals[0] - Vector3f(0, 1, 2).normalized()).norm(), 1e-6);
  EXPECT_LT((normals[2] - Vector3f(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((normals[3] - Vector3f(0, 1, 0)).norm(), 1e-6);
  EXPECT_EQ(normals[4], Vector3f(0, 0, 0));
}

TEST(MeshFile, AMillionTrianglesComeBackAsTheyWere) {
  TriangleMesh mesh;
  constexpr std::uint32_t kSide = 708;
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      mesh.vertices.emplace_back(x, y, std::sin(0.1f * static_cast<float>(x)));
      if (x + 1 == kSide || y + 1 == kSide) continue;
      const std::uint32_t at = y * kSide + x;
      mesh.triangles.push_back({at, at + 1, at + kSide});
      mesh.triangles.push_back({at + 1, at + kSide + 1, at + kSide});
    }
  ASSERT_GE(mesh.triangles.size(), 999'000u);
  const test::ScratchFolder scratch;
  WriteMeshPly(scratch / "mesh.ply", mesh);
  const MeshReading reading = ReadMeshFile(scratch / "mesh.ply");
  EXPECT_EQ(reading.mesh.vertices, mesh.vertices);
  EXPECT_EQ(reading.mesh.triangles, mesh.triangles);
}

}  // namespace
}  // namespace ulf::mesh_file_test
