// Tests: render/output/gltf_file, render/output/texture_atlas,
// render/output/surface_views.
//
// A textured mesh for other programs: the file by the rules of glTF 2.0, its cameras against the
// photographs', its texture drawn again against the photograph of a recorded camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/image/files/png_picture.h"
#include "render/output/gltf_file.h"
#include "render/output/texture_atlas.h"
#include "render/proxy/mesh_resolution.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::gltf_test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;
using nlohmann::json;
using testing::HasSubstr;
using testing::ThrowsMessage;

// ---- glTF 2.0, as its specification says. ----

struct GlbRead {
  json document;
  std::string buffer;

  // Numbers of an accessor, each component by itself.
  std::vector<double> Numbers(std::size_t index) const {
    const json& accessor = document.at("accessors").at(index);
    const json& view = document.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    const std::map<int, std::size_t> sizes{{5126, 4}, {5125, 4}, {5123, 2}};
    const std::map<std::string, std::size_t> components{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    const int type = accessor.at("componentType");
    const std::size_t size = sizes.at(type), count = accessor.at("count").get<std::size_t>() *
                                                     components.at(accessor.at("type").get<std::string>());
    const std::size_t offset = view.at("byteOffset"), length = view.at("byteLength");
    EXPECT_EQ(offset % 4, 0u);
    EXPECT_EQ(count * size, length);
    EXPECT_LE(offset + length, buffer.size());
    std::vector<double> numbers;
    for (std::size_t i = 0; i < count; ++i) {
      const char* at = buffer.data() + offset + i * size;
      float real;
      std::uint32_t whole;
      std::uint16_t half;
      if (type == 5126) {
        std::memcpy(&real, at, sizeof(real));
        numbers.push_back(static_cast<double>(real));
      } else if (type == 5125) {
        std::memcpy(&whole, at, sizeof(whole));
        numbers.push_back(whole);
      } else {
        std::memcpy(&half, at, sizeof(half));
        numbers.push_back(half / 65535.0);
      }
    }
    return numbers;
  }
};

std::uint32_t WordAt(const std::string& bytes, std::size_t at) {
  std::uint32_t word;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

GlbRead ReadGlb(const std::string& bytes) {
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(WordAt(bytes, 4), 2u);
  EXPECT_EQ(WordAt(bytes, 8), bytes.size());
  const std::uint32_t text = WordAt(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  EXPECT_EQ(text % 4, 0u);
  const std::uint32_t binary = WordAt(bytes, 20 + text);
  EXPECT_EQ(bytes.substr(24 + text, 4), std::string("BIN\0", 4));
  EXPECT_EQ(28 + text + binary, bytes.size());
  GlbRead read{JsonFromText(bytes.substr(20, text)), bytes.substr(28 + text)};
  EXPECT_EQ(read.document.at("asset").at("version"), "2.0");
  EXPECT_EQ(read.document.at("buffers").at(0).at("byteLength"), binary);
  return read;
}

Matrix4d LocalOf(const json& node) {
  Matrix4d matrix = Matrix4d::Identity();
  if (node.contains("rotation")) {
    const json& q = node.at("rotation");
    const Eigen::Quaterniond rotation(q[3].get<double>(), q[0].get<double>(), q[1].get<double>(),
                                      q[2].get<double>());
    EXPECT_NEAR(rotation.norm(), 1, 1e-6);
    matrix.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  }
  if (node.contains("translation"))
    for (int i = 0; i < 3; ++i)
      matrix(i, 3) = node.at("translation").at(static_cast<std::size_t>(i)).get<double>();
  return matrix;
}

// Pixels from the upper left corner, of a picture of that size.
Vector2d ProjectByGltf(const json& camera, const Matrix4d& gltf_from_cam, const Vector3d& point, double width,
                       double height) {
  const json& lens = camera.at("perspective");
  const double f = 1 / std::tan(0.5 * lens.at("yfov").get<double>());
  const Vector3d in_cam = (gltf_from_cam.inverse() * point.homogeneous()).head<3>();
  const Vector2d ndc(f / lens.at("aspectRatio").get<double>() * in_cam.x() / -in_cam.z(),
                     f * in_cam.y() / -in_cam.z());
  return {0.5 * width * (1 + ndc.x()), 0.5 * height * (1 - ndc.y())};
}

// ---- The scene: a plane with a square before it, both textured. ----

struct Baked {
  std::shared_ptr<const TriangleMesh> mesh;
  std::shared_ptr<const RenderScene> scene;
  std::vector<ViewShares> shares;
  TextureAtlas atlas;
  cv::Mat texture;
};

std::shared_ptr<RenderScene> PhotographedScene() {
  return test::MakeScene({.viewpoints = test::CapViewpoints(16, Radians(25), 1.4),
                          .width = 160,
                          .height = 120,
                          .focal_px = 130,
                          .with_square = true});
}

const Baked& BakedScene() {
  static const Baked baked = [] {
    Baked made;
    const auto plain = PhotographedScene();
    made.mesh =
        std::make_shared<TriangleMesh>(Split(*test::PlaneAndSquare(), plain->Centers(), 0.06, 100000));
    made.scene = WithProxy(*plain, std::make_shared<MeshProxy>(plain->subject, made.mesh));
    made.shares = SharesOfVertices(*made.scene, *made.mesh);
    made.atlas = MakeTextureAtlas(*made.scene, *made.mesh, 1024);
    made.texture = BakeTexture(*made.scene, made.atlas, made.shares);
    return made;
  }();
  return baked;
}

// Every texel whose middle is in a triangle, with the triangle's number.
template <typename Each>
void ForEachTexel(const TextureAtlas& atlas, const Each& each) {
  for (std::size_t i = 0; i < atlas.mesh.triangles.size(); ++i) {
    std::array<Vector2f, 3> p;
    for (std::size_t c = 0; c < 3; ++c) p[c] = atlas.texel[atlas.mesh.triangles[i][c]];
    const Vector2f low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    for (int y = static_cast<int>(low.y()); y <= static_cast<int>(high.y()); ++y)
      for (int x = static_cast<int>(low.x()); x <= static_cast<int>(high.x()); ++x) {
        const Vector2f at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        int sides = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const Vector2f edge = p[(c + 1) % 3] - p[c], arm = at - p[c];
          sides += edge.x() * arm.y() - edge.y() * arm.x() > 0 ? 1 : -1;
        }
        if (std::abs(sides) == 3) each(i, cv::Point(x, y));
      }
  }
}

// Drawn with bilinear lookups, nearest surface first, as any viewer does.
cv::Mat DrawTextured(const TriangleMesh& mesh, const std::vector<Vector2f>& texel, const cv::Mat& texture,
                     const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat picture(camera.height, camera.width, CV_8UC3, cv::Scalar::all(0));
  cv::Mat nearest(picture.size(), CV_64F, cv::Scalar(0));  // inverse depth
  for (const auto& triangle : mesh.triangles) {
    std::array<Vector2d, 3> p;
    std::array<double, 3> inverse{};
    bool all = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector3d in_cam = cam_from_world * mesh.vertices[triangle[c]].cast<double>();
      all = all && in_cam.z() > 1e-3;
      if (!all) break;
      p[c] = *camera.ImgFromCam(in_cam);
      inverse[c] = 1 / in_cam.z();
    }
    if (!all) continue;
    const auto cross = [](const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    const Vector2d low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    for (int y = std::max(0, static_cast<int>(low.y())); y <= std::min<double>(camera.height - 1, high.y());
         ++y)
      for (int x = std::max(0, static_cast<int>(low.x())); x <= std::min<double>(camera.width - 1, high.x());
           ++x) {
        const Vector2d at(x + 0.5, y + 0.5);
        const Vector3d corner =
            Vector3d(cross(p[1] - at, p[2] - at), cross(p[2] - at, p[0] - at), cross(p[0] - at, p[1] - at)) /
            area;
        if (!(corner.minCoeff() >= 0)) continue;
        const double depth = corner[0] * inverse[0] + corner[1] * inverse[1] + corner[2] * inverse[2];
        if (depth <= nearest.at<double>(y, x)) continue;
        nearest.at<double>(y, x) = depth;
        Vector2d place = Vector2d::Zero();
        for (int c = 0; c < 3; ++c)
          place += corner[c] * inverse[static_cast<std::size_t>(c)] / depth *
                   texel[triangle[static_cast<std::size_t>(c)]].cast<double>();
        cv::Mat one;
        cv::getRectSubPix(
            texture, {1, 1},
            cv::Point2f(static_cast<float>(place.x() - 0.5), static_cast<float>(place.y() - 0.5)), one);
        picture.at<cv::Vec3b>(y, x) = one.at<cv::Vec3b>(0, 0);
      }
  }
  return picture;
}

TEST(TextureAtlas, ChartsKeepTheirDistance) {
  const TextureAtlas& atlas = BakedScene().atlas;
  EXPECT_EQ(atlas.width & (atlas.width - 1), 0);
  EXPECT_EQ(atlas.height & (atlas.height - 1), 0);
  EXPECT_LE(std::max(atlas.width, atlas.height), 1024);
  EXPECT_GT(atlas.unseen, 0u);  // the plane goes on beyond the pictures
  EXPECT_GE(atlas.Charts(), 2u);
  cv::Mat owner(atlas.height, atlas.width, CV_32S, cv::Scalar(-1));
  const auto chart_of = [&](std::size_t triangle) {
    return static_cast<int>(std::ranges::upper_bound(atlas.chart_begins, triangle) -
                            atlas.chart_begins.begin());
  };
  std::size_t overlaps = 0, texels = 0;
  ForEachTexel(atlas, [&](std::size_t triangle, const cv::Point& at) {
    int& before = owner.at<int>(at);
    overlaps += before >= 0 && before != chart_of(triangle);
    before = chart_of(triangle);
    ++texels;
  });
  EXPECT_EQ(overlaps, 0u);
  EXPECT_GT(texels, 5000u);
  // A bilinear lookup, and that of a mip level, stays with its chart.
  std::size_t close = 0;
  for (int y = 0; y < owner.rows; ++y)
    for (int x = 0; x < owner.cols; ++x)
      for (int dy = -kChartPadding; dy <= kChartPadding; ++dy)
        for (int dx = -kChartPadding; dx <= kChartPadding; ++dx) {
          const cv::Point other(x + dx, y + dy);
          if (owner.at<int>(y, x) < 0 || !cv::Rect(0, 0, owner.cols, owner.rows).contains(other)) continue;
          close += owner.at<int>(other) >= 0 && owner.at<int>(other) != owner.at<int>(y, x);
        }
  EXPECT_EQ(close, 0u);
  for (const Vector2f& texel : atlas.texel) {
    EXPECT_GE(texel.minCoeff(), kChartPadding);
    EXPECT_LE(texel.x(), atlas.width - kChartPadding);
    EXPECT_LE(texel.y(), atlas.height - kChartPadding);
  }
}

TEST(TextureAtlas, ASmallPageTakesAllAtLessDetail) {
  const Baked& baked = BakedScene();
  const TextureAtlas small = MakeTextureAtlas(*baked.scene, *baked.mesh, 128);
  EXPECT_EQ(small.width, 128);
  EXPECT_LT(small.scale, 0.95);
  EXPECT_EQ(baked.atlas.scale, 1);
  EXPECT_EQ(small.mesh.triangles.size(), baked.atlas.mesh.triangles.size());
  EXPECT_THAT([&] { MakeTextureAtlas(*baked.scene, *baked.mesh, 4); },
              ThrowsMessage<Error>(HasSubstr("texture")));
  TriangleMesh behind = *baked.mesh;
  for (Vector3f& vertex : behind.vertices) vertex.z() += 50;
  EXPECT_THAT([&] { MakeTextureAtlas(*baked.scene, behind, 1024); },
              ThrowsMessage<Error>(HasSubstr("no view sees")));
}

// Compared over what the mesh shows: unseen triangles are left out.
double PsnrOfDrawn(const cv::Mat& drawn, const cv::Mat& photograph, double* share) {
  cv::Mat gray, shown;
  cv::cvtColor(drawn, gray, cv::COLOR_BGR2GRAY);
  shown = gray > 0;
  cv::erode(shown, shown, cv::Mat());
  *share = static_cast<double>(cv::countNonZero(shown)) / static_cast<double>(shown.total());
  cv::Mat a = photograph.clone(), b = drawn.clone();
  a.setTo(0, shown == 0);
  b.setTo(0, shown == 0);
  const double squared = cv::norm(a, b, cv::NORM_L2SQR) / (3.0 * cv::countNonZero(shown));
  return 10 * std::log10(255 * 255 / squared);
}

TEST(TextureBaking, ReproducesThePhotographAtItsCamera) {
  const Baked& baked = BakedScene();
  for (const std::size_t index : {0u, 7u, 15u}) {
    const SceneView& view = baked.scene->views[index];
    double share = 0;
    const cv::Mat drawn =
        DrawTextured(baked.atlas.mesh, baked.atlas.texel, baked.texture, view.camera, view.cam_from_world);
    EXPECT_GT(PsnrOfDrawn(drawn, view.Srgb8(), &share), 27) << index;
    EXPECT_GT(share, 0.85);
  }
  // And from where no photograph was taken.
  const CameraModel camera = baked.scene->views.front().camera;
  const Rigid3 between = LookAt({0.2, -0.15, 1.3}, {0, 0, 0}, Vector3d::UnitY());
  double share = 0;
  EXPECT_GT(PsnrOfDrawn(DrawTextured(baked.atlas.mesh, baked.atlas.texel, baked.texture, camera, between),
                        test::PhotographOfPlane(camera, between, true), &share),
            25);
  EXPECT_GT(share, 0.85);
}

TEST(SurfaceViews, SharesSumToOneAndLeaveOutWhatIsHidden) {
  const Baked& baked = BakedScene();
  std::size_t seen = 0;
  for (std::size_t i = 0; i < baked.shares.size(); ++i) {
    if (baked.shares[i].empty()) continue;
    ++seen;
    float sum = 0;
    for (const auto& [view, weight] : baked.shares[i]) {
      sum += weight;
      const Vector3d point = baked.mesh->vertices[i].cast<double>();
      EXPECT_TRUE(baked.scene->views[static_cast<std::size_t>(view)].ProjectVisible(point)) << i;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
    EXPECT_LE(baked.shares[i].size(), 4u);
  }
  EXPECT_GT(seen, 100u);
  const std::vector<cv::Vec3f> colors = ColorsOfVertices(*baked.scene, *baked.mesh, baked.shares);
  // A vertex has the mean colour of what its triangles cover.
  std::vector<double> edges;
  for (const auto& triangle : baked.mesh->triangles)
    edges.push_back(
        static_cast<double>((baked.mesh->vertices[triangle[0]] - baked.mesh->vertices[triangle[1]]).norm()));
  const double edge = Median(edges);
  double off = 0, off_elsewhere = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const Vector3d at = baked.mesh->vertices[i].cast<double>();
    if (baked.shares[i].empty() || at.z() != 0) continue;
    const auto mean_at = [&](double x, double y) {
      cv::Vec3f mean(0, 0, 0);
      constexpr int kSide = 9;
      for (int k = 0; k < kSide * kSide; ++k)
        mean += test::PlaneTexture(x + edge * (k % kSide - 4) / kSide, y + edge * (k / kSide - 4) / kSide) /
                static_cast<float>(kSide * kSide);
      return mean;
    };
    off += cv::norm(colors[i] - mean_at(at.x(), at.y()));
    off_elsewhere += cv::norm(colors[i] - mean_at(-at.x(), at.y() + 0.3));
    ++count;
  }
  EXPECT_LT(off, 0.5 * off_elsewhere) << off / static_cast<double>(count);
  for (const cv::Vec3f& color : colors)
    EXPECT_GT(color[0] + color[1] + color[2], 0);  // unseen ones have a neighbour's
}

TEST(GltfFile, HoldsTheMeshItsTextureAndTheCameras) {
  const Baked& baked = BakedScene();
  GltfModel model;
  model.near_distance = 0.25;
  model.name = "plane";
  model.mesh = baked.atlas.mesh;
  model.texel = baked.atlas.texel;
  model.texture_png = PngBytes(baked.texture);
  model.texture_size = baked.texture.size();
  model.units = "metres";
  model.up_in_world = Vector3d(0.3, -0.2, 0.9).normalized();
  for (const SceneView& view : baked.scene->views) {
    CameraModel oblong = view.camera;
    oblong.fy *= 1.1;
    model.cameras.push_back(
        {fmt::format("{:06}", view.id), oblong, view.cam_from_world, {{"image", "a.png"}}});
  }
  const GlbRead read = ReadGlb(GlbBytes(model));
  const json& document = read.document;
  EXPECT_EQ(document.at("extensionsUsed"), json::array({"KHR_materials_unlit"}));
  const json& world =
      document.at("nodes").at(document.at("scenes").at(0).at("nodes").at(0).get<std::size_t>());
  const Matrix4d gltf_from_world = LocalOf(world);
  EXPECT_LT((gltf_from_world.topLeftCorner<3, 3>() * model.up_in_world - Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_EQ(world.at("children").size(), 1 + model.cameras.size());
  std::size_t cameras = 0;
  for (const json& child : world.at("children")) {
    const json& node = document.at("nodes").at(child.get<std::size_t>());
    if (!node.contains("camera")) continue;
    const GltfCamera& camera = model.cameras[cameras++];
    EXPECT_EQ(node.at("name"), camera.name);
    const json& lens = document.at("cameras").at(node.at("camera").get<std::size_t>());
    EXPECT_EQ(lens.at("perspective").at("znear"), 0.25);
    const Matrix4d gltf_from_cam = gltf_from_world * LocalOf(node);
    const Matrix4d world_from_cam = gltf_from_world.inverse() * gltf_from_cam;
    const Matrix4d ours = Eigen::Vector4d(1, -1, -1, 1).asDiagonal() * world_from_cam.inverse();
    EXPECT_LT((ours - camera.cam_from_world.Matrix()).norm(), 1e-9);
    for (const Vector3f& vertex : baked.mesh->vertices) {
      const Vector3d point = vertex.cast<double>();
      const auto expected = camera.camera.ImgFromCam(camera.cam_from_world * point);
      if (!expected || !camera.camera.Contains(*expected)) continue;
      const Vector3d in_gltf = (gltf_from_world * point.homogeneous()).head<3>();
      EXPECT_LT(
          (ProjectByGltf(lens, gltf_from_cam, in_gltf, camera.camera.width, camera.camera.height) - *expected)
              .norm(),
          1e-3);
    }
  }
  EXPECT_EQ(cameras, model.cameras.size());

  const json& primitive = document.at("meshes").at(0).at("primitives").at(0);
  const std::vector<double> positions = read.Numbers(primitive.at("attributes").at("POSITION"));
  const json& accessor =
      document.at("accessors").at(primitive.at("attributes").at("POSITION").get<std::size_t>());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = 1e300, high = -1e300;
    for (std::size_t i = axis; i < positions.size(); i += 3) {
      low = std::min(low, positions[i]);
      high = std::max(high, positions[i]);
      EXPECT_EQ(positions[i], static_cast<double>(model.mesh.vertices[i / 3][static_cast<int>(axis)]));
    }
    EXPECT_EQ(accessor.at("min").at(axis), low);
    EXPECT_EQ(accessor.at("max").at(axis), high);
  }
  const std::vector<double> indices = read.Numbers(primitive.at("indices"));
  ASSERT_EQ(indices.size(), 3 * model.mesh.triangles.size());
  for (const double index : indices) EXPECT_LT(index, static_cast<double>(model.mesh.vertices.size()));
  const std::vector<double> places = read.Numbers(primitive.at("attributes").at("TEXCOORD_0"));
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_NEAR(places[i] * (i % 2 == 0 ? baked.texture.cols : baked.texture.rows),
                static_cast<double>(model.texel[i / 2][i % 2]), 1e-3);
  const json& view =
      document.at("bufferViews").at(document.at("images").at(0).at("bufferView").get<std::size_t>());
  const std::string png = read.buffer.substr(view.at("byteOffset"), view.at("byteLength"));
  const cv::Mat texture = cv::imdecode(std::vector<char>(png.begin(), png.end()), cv::IMREAD_COLOR);
  EXPECT_EQ(cv::norm(texture, baked.texture, cv::NORM_INF), 0);

  // Colours in place of the texture: red first, linear.
  model.texture_png.clear();
  model.colors.assign(model.mesh.vertices.size(), cv::Vec3f(0.25f, 0.5f, 2));
  const GlbRead colored = ReadGlb(GlbBytes(model));
  const json& attributes = colored.document.at("meshes").at(0).at("primitives").at(0).at("attributes");
  EXPECT_FALSE(attributes.contains("TEXCOORD_0"));
  EXPECT_TRUE(
      colored.document.at("accessors").at(attributes.at("COLOR_0").get<std::size_t>()).at("normalized"));
  const std::vector<double> colors = colored.Numbers(attributes.at("COLOR_0"));
  EXPECT_NEAR(colors[0], 1, 1e-4);
  EXPECT_NEAR(colors[1], 0.5, 1e-4);
  EXPECT_NEAR(colors[2], 0.25, 1e-4);
  EXPECT_EQ(colors[3], 1);

  model.cameras.front().camera.cx += 1;
  EXPECT_THAT([&] { GlbBytes(model); }, ThrowsMessage<Error>(HasSubstr("undistort")));
}

}  // namespace
}  // namespace ulf::gltf_test
