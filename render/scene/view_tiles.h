// Finds, for each tile of a picture, the recorded views that may have what it shows in their images, so that
// its pixels need not try all others. A view is left out of a tile only if its frustum proves that it sees
// nothing of the tile.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "render/proxy/proxy.h"
#include "render/proxy/triangle_mesh.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ViewTiles {
  struct Tile {
    cv::Rect px;
    int first = 0, end = 0;  // range in `views`
  };
  std::vector<Tile> tiles;  // cover the picture without overlap
  std::vector<int> views;   // by tile, in the order in which pixels examine them
};

class ViewTiler {
 public:
  explicit ViewTiler(const std::vector<SceneView>& views);  // those that Tile() gets, too

  // What the picture shows: the plane, and points of triangles in front of it or behind it.
  struct Picture {
    CameraModel camera;  // without distortion
    Rigid3 cam_from_world;
    PlaneInCamera plane;
    std::shared_ptr<const TriangleMesh> triangles;
  };
  // `in_order` lists the views in the order in which pixels examine them. A pixel needs no further views once
  // `enough` of those for which `ends` is true have it in their images.
  ViewTiles Tile(const std::vector<SceneView>& views, std::span<const int> in_order, const Picture& picture,
                 const std::function<bool(int view)>& ends, int enough = 1);

 private:
  // The range of x/z and y/z over an image; none if the image reaches to the side of the camera.
  struct Slopes {
    Eigen::Vector2d low, high;
  };
  std::optional<Slopes> SlopesOf(const CameraModel& camera) const;
  void UpdateBox(const std::shared_ptr<const TriangleMesh>& triangles);
  std::vector<std::optional<Slopes>> slopes_;
  std::shared_ptr<const TriangleMesh> boxed_;  // held, so that another mesh cannot get its address
  Eigen::AlignedBox3f box_;                    // of the triangles
};

}  // namespace ulf::render
