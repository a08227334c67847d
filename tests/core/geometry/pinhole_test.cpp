// Tests: core/geometry/pinhole, core/geometry/digest.
#include "core/geometry/pinhole.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "core/geometry/digest.h"

namespace ulf::pinhole_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Pinhole, RaysAndPointsAreInverse) {
  CameraModel camera = CameraModel::Pinhole(640, 480, 500);
  camera.fy = 480;
  camera.cx = 300.25;
  const Vector3d point(0.3, -0.2, 1.7);
  const Vector2d img = PinholeImg(camera, point);
  EXPECT_LT((img - *camera.ImgFromCam(point)).norm(), 1e-12);
  EXPECT_LT((PinholeRay(camera, img) - point / point.z()).norm(), 1e-12);
  EXPECT_LT((PinholeMatrix(camera) * (point / point.z()) - img.homogeneous()).norm(), 1e-12);
  EXPECT_EQ(PinholeRay(camera, 10, 20), PinholeRay(camera, Vector2d(10.5, 20.5))) << "a pixel's centre";
}

TEST(Digest, EveryChangeIsAnotherChecksum) {
  std::string bytes(1000, '\7');
  std::set<std::uint64_t> checksums{FastChecksumOf(bytes), FastChecksumOf(bytes, 1),
                                    FastChecksumOf(bytes + '\0')};
  EXPECT_EQ(checksums.size(), 3u);
  for (const std::size_t at : {0u, 31u, 500u, 992u, 999u}) {
    std::string changed = bytes;
    changed[at] ^= 1;
    EXPECT_TRUE(checksums.insert(FastChecksumOf(changed)).second) << at;
  }
  EXPECT_EQ(FastChecksumOf(bytes), FastChecksumOf(std::string(1000, '\7')));
  EXPECT_EQ(FastChecksumOf("light field"), 0x62d6d02a6e16edfbu) << "the value in files that exist";
}

}  // namespace
}  // namespace ulf::pinhole_test
