// Tests: core/geometry/angles, core/geometry/byte_stream, core/geometry/camera_json, core/geometry/digest,
// core/geometry/similarity3, core/geometry/triangulation.
#include "core/geometry/angles.h"

#include <gmock/gmock.h>

#include <numbers>

#include "core/base/error.h"
#include "core/geometry/byte_stream.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/digest.h"
#include "core/geometry/similarity3.h"
#include "core/geometry/triangulation.h"

namespace ulf::angles_test {
namespace {

using Eigen::Vector3d;

TEST(Angles, BetweenVectorsAreAccurateNearZeroAndPi) {
  EXPECT_DOUBLE_EQ(Radians(180), std::numbers::pi);
  EXPECT_DOUBLE_EQ(Degrees(Radians(37.5)), 37.5);
  EXPECT_DOUBLE_EQ(AngleBetween({2, 0, 0}, {0, 0, 5}), std::numbers::pi / 2);
  const double tiny = 1e-9;  // the arc cosine gives 0 here
  EXPECT_NEAR(AngleBetween({1, 0, 0}, {1, tiny, 0}), tiny, 1e-15);
  EXPECT_NEAR(AngleBetween({1, 0, 0}, {-1, tiny, 0}), std::numbers::pi - tiny, 1e-15);
  EXPECT_EQ(AngleBetween({0, 0, 0}, {1, 0, 0}), 0);
}

TEST(ByteStream, ReadsBackAndToldShort) {
  const Rigid3 pose{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3}};
  ByteWriter writer;
  writer.Count(2);
  writer.Put(pose);
  writer.Put(std::int32_t{-7});
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.Count(4), 2u);
  EXPECT_LT((reader.GetPose().Matrix() - pose.Matrix()).norm(), 1e-15);
  EXPECT_EQ(reader.Get<std::int32_t>(), -7);
  EXPECT_TRUE(reader.AtEnd());
  EXPECT_FALSE(reader.IsShort());
  EXPECT_EQ(reader.Get<std::int32_t>(), 0);
  EXPECT_TRUE(reader.IsShort());
  ByteWriter more;
  more.Count(1000);
  ByteReader cut(more.bytes());
  EXPECT_EQ(cut.Count(1), 0u) << "a count of more than the bytes hold";
  EXPECT_TRUE(cut.IsShort());
}

TEST(CameraJson, ReadsBackAndMovesIntegerPixelCentres) {
  CameraModel camera{
      640, 480, 500, 501, 320.5, 240.25, Distortion::kRadialTangential, {0.1, -0.2, 1e-3, 0, 0}};
  nlohmann::json json = CameraToJson(camera);
  EXPECT_EQ(CameraFromJson({json, "camera"}), camera);
  json["pixel_centers"] = "integer";
  camera.cx += 0.5;
  camera.cy += 0.5;
  EXPECT_EQ(CameraFromJson({json, "camera"}), camera);
  json.erase("fx");
  EXPECT_THROW(CameraFromJson({json, "camera"}), Error);
  const SensorWindow window{1280, 960, 8, 16, 640, 480, 2, 2};
  EXPECT_EQ(WindowFromJson({WindowToJson(window), "sensor"}), window);
}

TEST(DigestTest, IsFnv1aAndChangesWithTheValues) {
  // Test vectors of the FNV page (http://www.isthe.com/chongo/tech/comp/fnv/).
  EXPECT_EQ(ChecksumOf(""), 0xcbf29ce484222325u);
  EXPECT_EQ(ChecksumOf("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(ChecksumOf("foobar"), 0x85944171f73967e8u);
  Rigid3 pose;
  Digest first, second;
  first.Add(pose);
  pose.translation.x() = 1e-9;
  second.Add(pose);
  EXPECT_NE(first.Value(), second.Value());
}

TEST(Similarity, InverseCompositionAndAlignmentAgree) {
  const Similarity3 b_from_a{
      2.5, Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix(), {1, -2, 0.5}};
  const std::vector<Vector3d> in_a{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {1, 1, 3}};
  std::vector<Vector3d> in_b;
  for (const Vector3d& point : in_a) {
    in_b.push_back(b_from_a * point);
    EXPECT_LT((b_from_a.Inverse() * in_b.back() - point).norm(), 1e-12);
  }
  const auto aligned = AlignPoints(in_a, in_b);
  ASSERT_TRUE(aligned);
  EXPECT_NEAR(aligned->scale, 2.5, 1e-12);
  EXPECT_LT((aligned->translation - b_from_a.translation).norm(), 1e-12);
  const std::vector<Vector3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_FALSE(AlignPoints(line, line));
}

TEST(Triangulation, FindsThePointOfTwoRaysInFrontOfBoth) {
  const Vector3d point(0.2, -0.1, 4);
  const Rigid3 first;
  const Rigid3 second{Eigen::Quaterniond::Identity(), {-0.5, 0, 0}};
  const Vector3d in_first = (first * point).normalized(), in_second = (second * point).normalized();
  const auto found = TriangulatePoint(first, in_first, second, in_second);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - point).norm(), 1e-9);
  EXPECT_FALSE(TriangulatePoint(first, -in_first, second, -in_second)) << "behind the cameras";
  EXPECT_NEAR(ParallaxAngle(point, {0, 0, 0}, {0.5, 0, 0}), AngleBetween(point, point - Vector3d(0.5, 0, 0)),
              1e-12);
}

}  // namespace
}  // namespace ulf::angles_test
