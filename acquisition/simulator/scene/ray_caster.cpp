#include "acquisition/simulator/scene/ray_caster.h"

#include <array>
#include <cstring>
#include <vector>

#include "acquisition/simulator/scene/surface_light.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kTileWidth = 32, kTileHeight = 16;
constexpr float kPixelReach = 0.7f;  // from a pixel's centre to its corners, in pixels
constexpr float kNoHit = std::numeric_limits<float>::infinity();

F8 Load(const float* from) {
  F8 value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}
void Store(float* to, F8 value) { std::memcpy(to, &value, sizeof(value)); }

}  // namespace

// Directions in the camera frame, and how they change by one pixel to the right and downwards; rows are
// padded to whole groups of lanes.
struct RayCaster::Rays {
  int stride = 0;
  float pixel_angle = 0;
  std::vector<float> x, y, z, x_by_u, y_by_u, z_by_u, x_by_v, y_by_v, z_by_v;

  Vec3<F8> At(std::size_t i) const { return {Load(&x[i]), Load(&y[i]), Load(&z[i])}; }
  Vector3f One(std::size_t i, float du, float dv) const {
    return {x[i] + du * x_by_u[i] + dv * x_by_v[i], y[i] + du * y_by_u[i] + dv * y_by_v[i],
            z[i] + du * z_by_u[i] + dv * z_by_v[i]};
  }
};

struct RayCaster::Tile {
  int x0, y0, x1, y1;
  Vector3f axis_in_cam;
  float half_angle;
};

// The scene relative to one camera pose.
struct RayCaster::Pose {
  struct Part {
    const Primitive* primitive;
    Primitive wider;  // of what may be thinner than a pixel: what touches the pixels that it passes through
    Eigen::Matrix3f local_from_cam;
    Vector3f origin;        // the camera centre, local
    Vector3f bound_in_cam;  // direction to the bounding sphere
    float bound_angle;      // and its angular radius
    bool flat;              // box or room
    Vector3f inverse_half;  // of their sizes
  };
  struct Chart {
    const MipTexture* texture;
    float texels_per_m, inverse_width_m, inverse_height_m;
  };
  const Scene* scene = nullptr;
  std::vector<Part> parts;
  std::vector<Chart> charts;
  float pixel_angle = 0;
  double sway_angle = 0;
  bool some_need_closer_look = false;
  Eigen::Matrix3f world_from_cam;
  Vector3f center;

  Pose(const Scene& of_scene, const Rigid3& cam_from_world, float angle, double sway)
      : scene(&of_scene), pixel_angle(angle), sway_angle(sway) {
    const Rigid3 inverse = cam_from_world.Inverse();
    const Rigid3 moved_from_cam = scene->MovedFromRest(sway).Inverse() * inverse;
    world_from_cam = inverse.RotationMatrix().cast<float>();
    center = inverse.translation.cast<float>();
    for (const Primitive& primitive : scene->primitives()) {
      const Rigid3 local_from_cam =
          primitive.local_from_world * (primitive.moves && sway != 0 ? moved_from_cam : inverse);
      const Vec3<float> middle = primitive.BoundCenter();
      const Vector3d in_cam = local_from_cam.Inverse() * Vector3d(middle.x, middle.y, middle.z);
      const double distance = in_cam.norm();
      const Primitive wider = Widened(primitive, kPixelReach * angle * static_cast<float>(distance));
      const double radius = wider.BoundRadius();
      some_need_closer_look |= primitive.thin || primitive.finish >= Finish::kPolished;
      parts.push_back({&primitive, wider, local_from_cam.RotationMatrix().cast<float>(),
                       local_from_cam.translation.cast<float>(), in_cam.normalized().cast<float>(),
                       distance <= radius ? 4.0f : static_cast<float>(std::asin(radius / distance)),
                       primitive.shape == Shape::kBox || primitive.shape == Shape::kRoom,
                       Vector3f(1 / primitive.size[0], 1 / primitive.size[1], 1 / primitive.size[2])});
      for (int chart = 0; chart < primitive.ChartCount(); ++chart) {
        const ChartSize size = SizeOfChart(primitive, chart);
        const MipTexture& texture = scene->Chart(primitive.first_chart + chart);
        charts.push_back({&texture, static_cast<float>(texture.height()) / size.height_m, 1 / size.width_m,
                          1 / size.height_m});
      }
    }
  }

  // Returns a solid that is larger by `by_m` on every side.
  static Primitive Widened(const Primitive& thin, float by_m) {
    Primitive wider = thin;
    if (!thin.thin) return wider;
    switch (thin.shape) {
      case Shape::kTorus:
        wider.size[1] += by_m;
        break;
      case Shape::kFrustum:
        wider.size[0] += by_m;
        wider.size[1] += by_m;
        break;
      default:
        for (float& side : wider.size) side += by_m;
    }
    return wider;
  }

  // Returns the parts that rays of the tile can meet, except the room, which is tried last.
  std::vector<int> Candidates(const Tile& tile) const {
    std::vector<int> list;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].primitive->shape == Shape::kRoom) continue;
      const float cosine = std::clamp(parts[i].bound_in_cam.dot(tile.axis_in_cam), -1.0f, 1.0f);
      if (parts[i].bound_angle > 1.5f || std::acos(cosine) < parts[i].bound_angle + tile.half_angle)
        list.push_back(static_cast<int>(i));
    }
    return list;
  }

  F8 Distance(int index, const Vec3<F8>& d) const {
    const Part& part = parts[static_cast<std::size_t>(index)];
    return Distance(part, *part.primitive, d);
  }

  F8 Distance(const Part& part, const Primitive& solid, const Vec3<F8>& d) const {
    const auto& r = part.local_from_cam;
    const Vec3<F8> local{r(0, 0) * d.x + r(0, 1) * d.y + r(0, 2) * d.z,
                         r(1, 0) * d.x + r(1, 1) * d.y + r(1, 2) * d.z,
                         r(2, 0) * d.x + r(2, 1) * d.y + r(2, 2) * d.z};
    const Vec3<F8> origin{F8{} + part.origin.x(), F8{} + part.origin.y(), F8{} + part.origin.z()};
    return Intersect<F8>(solid, origin, local);
  }

  // Returns which rays pass so close to something thin, nearer than what they meet, that their pixels see it,
  // or meet a surface that is not matte: one ray says too little of such a pixel.
  I8 NeedCloserLook(const std::vector<int>& candidates, const Vec3<F8>& d, F8 t, I8 which) const {
    I8 need{};
    for (const int index : candidates) {
      const Part& part = parts[static_cast<std::size_t>(index)];
      if (part.primitive->thin) need |= Distance(part, part.wider, d) < t + 1e-4f;
      if (part.primitive->finish >= Finish::kPolished) need |= which == index;
    }
    return need;
  }

  void Nearest(const std::vector<int>& candidates, const Vec3<F8>& d, F8& t, I8& which) const {
    t = F8{} + kNoHit;
    which = I8{} - 1;
    const auto offer = [&](int index) {
      const F8 distance = Distance(index, d);
      const I8 nearer = distance < t;
      t = Select(nearer, distance, t);
      which = Select(nearer, I8{} + index, which);
    };
    for (const int index : candidates) offer(index);
    if (!Any(which < 0)) return;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i].primitive->shape == Shape::kRoom) offer(static_cast<int>(i));
  }

  // Returns the radiance where a ray meets a part; `key` identifies the chart.
  F4 Radiance(int index, float t, const Vector3f& direction_in_cam, int& key) const {
    const Part& part = parts[static_cast<std::size_t>(index)];
    const Vector3f d = part.local_from_cam * direction_in_cam;
    const Vector3f p = part.origin + t * d;
    return part.primitive->glow *
           (part.flat ? OnFlat(part, t, p, d, key) : OnCurved(index, t, p, d, direction_in_cam, key));
  }

  // Surfaces that are seen at a slant get up to four samples along the pixel's elongated footprint.
  F4 OnFlat(const Part& part, float t, const Vector3f& p, const Vector3f& d, int& key) const {
    const Vector3f share = p.cwiseProduct(part.inverse_half), away = share.cwiseAbs();
    const int axis = away.x() >= away.y() ? (away.x() >= away.z() ? 0 : 2) : (away.y() >= away.z() ? 1 : 2);
    const int axis_u = axis == 2 ? 0 : axis + 1, axis_v = axis == 0 ? 2 : axis - 1;
    key = part.primitive->first_chart + 2 * axis + (p[axis] < 0 ? 1 : 0);
    const Chart& chart = charts[static_cast<std::size_t>(key)];
    const float u = 0.5f + 0.5f * share[axis_u], v = 0.5f + 0.5f * share[axis_v];
    const float facing = std::max(0.04f, std::abs(d[axis]));
    const float width_m = t * pixel_angle, width = width_m * chart.texels_per_m;
    const int samples = std::min(4, static_cast<int>(1 / facing + 0.4f));
    if (samples <= 1) return chart.texture->Sample(u, v, width / std::sqrt(facing));
    const float each = 1.0f / static_cast<float>(samples);
    const float step = each * width_m / (facing * std::sqrt(std::max(1e-6f, 1 - d[axis] * d[axis])));
    const float du = d[axis_u] * step * chart.inverse_width_m, dv = d[axis_v] * step * chart.inverse_height_m;
    const float footprint = width * std::max(1.0f, each / facing);
    F4 color{};
    for (int i = 0; i < samples; ++i) {
      const float place = static_cast<float>(i) - 0.5f * static_cast<float>(samples - 1);
      color += chart.texture->Sample(u + place * du, v + place * dv, footprint);
    }
    return each * color;
  }

  F4 OnCurved(int index, float t, const Vector3f& p, const Vector3f& d, const Vector3f& direction_in_cam,
              int& key) const {
    const Part& part = parts[static_cast<std::size_t>(index)];
    const SurfacePoint at = SurfaceAt(*part.primitive, {p.x(), p.y(), p.z()});
    key = part.primitive->first_chart + at.chart;
    const Chart& chart = charts[static_cast<std::size_t>(key)];
    const Vector3f normal(at.normal.x, at.normal.y, at.normal.z);
    const float facing = std::max(0.04f, std::abs(normal.dot(d)));
    const F4 color =
        chart.texture->Sample(at.u, at.v, t * pixel_angle * chart.texels_per_m / std::sqrt(facing));
    if (part.primitive->finish == Finish::kMatte) return color;
    const Vector3f in_world = world_from_cam * (part.local_from_cam.transpose() * normal);
    const Vector3f ray_in_world = world_from_cam * direction_in_cam;
    return SurfaceLight(*scene, index, color,
                        {center + t * ray_in_world, in_world, ray_in_world, t, pixel_angle, sway_angle});
  }
};

struct RayCaster::Hits {
  int first, end;  // rows
  cv::Mat t;       // CV_32FC1, padded to the rays' stride
  cv::Mat which;   // CV_32SC1
  cv::Mat key;     // CV_16UC1
  cv::Mat close;   // CV_32SC1, as `which`; not 0: needs a closer look. Empty: none does
};

RayCaster::RayCaster(std::shared_ptr<const Scene> scene, const CameraModel& camera)
    : scene_(std::move(scene)), camera_(camera), rays_(std::make_unique<Rays>()) {
  camera_.Validate("the simulated camera");
  const int width = camera_.width, height = camera_.height;
  const int grid_width = width + 2;
  std::vector<Vector3f> grid;
  grid.reserve(static_cast<std::size_t>(grid_width) * (height + 2));
  for (int y = -1; y <= height; ++y)
    for (int x = -1; x <= width; ++x) {
      const auto ray = camera_.RayFromImg({x + 0.5, y + 0.5});
      if (!ray)
        throw Error("the simulated camera's distortion cannot be inverted at pixel {},{}; reduce it", x, y);
      grid.push_back(ray->cast<float>());
    }
  Rays& rays = *rays_;
  rays.stride = (width + kLanes - 1) / kLanes * kLanes;
  rays.pixel_angle = static_cast<float>(1 / camera_.MeanFocalPx());
  const std::size_t count = static_cast<std::size_t>(rays.stride) * height;
  for (auto* list : {&rays.x, &rays.y, &rays.z, &rays.x_by_u, &rays.y_by_u, &rays.z_by_u, &rays.x_by_v,
                     &rays.y_by_v, &rays.z_by_v})
    list->assign(count, 0.0f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < rays.stride; ++x) {
      const int column = std::min(x, width - 1);
      const std::size_t at = static_cast<std::size_t>(y + 1) * grid_width + column + 1;
      const std::size_t i = static_cast<std::size_t>(y) * rays.stride + x;
      const Vector3f by_u = 0.5f * (grid[at + 1] - grid[at - 1]);
      const Vector3f by_v = 0.5f * (grid[at + static_cast<std::size_t>(grid_width)] -
                                    grid[at - static_cast<std::size_t>(grid_width)]);
      rays.x[i] = grid[at].x();
      rays.y[i] = grid[at].y();
      rays.z[i] = grid[at].z();
      rays.x_by_u[i] = by_u.x();
      rays.y_by_u[i] = by_u.y();
      rays.z_by_u[i] = by_u.z();
      rays.x_by_v[i] = by_v.x();
      rays.y_by_v[i] = by_v.y();
      rays.z_by_v[i] = by_v.z();
    }
  for (int y = 0; y < height; y += kTileHeight)
    for (int x = 0; x < width; x += kTileWidth) {
      Tile tile{x, y, std::min(x + kTileWidth, width), std::min(y + kTileHeight, height), {}, 0};
      const auto corner = [&](int cx, int cy) -> const Vector3f& {  // one pixel outside on every side
        return grid[static_cast<std::size_t>(cy + 1) * grid_width + cx + 1];
      };
      const Vector3f corners[] = {corner(x - 1, y - 1), corner(tile.x1, y - 1), corner(x - 1, tile.y1),
                                  corner(tile.x1, tile.y1)};
      tile.axis_in_cam = (corners[0] + corners[1] + corners[2] + corners[3]).normalized();
      for (const Vector3f& c : corners)
        tile.half_angle =
            std::max(tile.half_angle, std::acos(std::min(1.0f, c.normalized().dot(tile.axis_in_cam))));
      tiles_.push_back(tile);
    }
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;

void RayCaster::Trace(const Pose& pose, Hits& hits) const {
  hits.t.create(camera_.height, rays_->stride, CV_32FC1);
  hits.which.create(camera_.height, rays_->stride, CV_32SC1);
  if (pose.some_need_closer_look) hits.close = cv::Mat::zeros(camera_.height, rays_->stride, CV_32SC1);
  for (const Tile& tile : tiles_) {
    if (tile.y1 <= hits.first || tile.y0 >= hits.end) continue;
    const std::vector<int> candidates = pose.Candidates(tile);
    for (int y = std::max(tile.y0, hits.first); y < std::min(tile.y1, hits.end); ++y)
      for (int x = tile.x0; x < tile.x1; x += kLanes) {
        const std::size_t i = static_cast<std::size_t>(y) * rays_->stride + x;
        F8 t;
        I8 which;
        pose.Nearest(candidates, rays_->At(i), t, which);
        Store(hits.t.ptr<float>(y) + x, t);
        std::memcpy(hits.which.ptr<int>(y) + x, &which, sizeof(which));
        if (pose.some_need_closer_look) {
          const I8 need = pose.NeedCloserLook(candidates, rays_->At(i), t, which);
          std::memcpy(hits.close.ptr<int>(y) + x, &need, sizeof(need));
        }
      }
  }
}

void RayCaster::Shade(const Pose& pose, float weight, Hits& hits, cv::Mat& sum) const {
  hits.key.create(camera_.height, camera_.width, CV_16UC1);
  for (int y = hits.first; y < hits.end; ++y) {
    const float* t = hits.t.ptr<float>(y);
    const int* which = hits.which.ptr<int>(y);
    auto* key = hits.key.ptr<std::uint16_t>(y);
    auto* out = sum.ptr<F4>(y);
    for (int x = 0; x < camera_.width; ++x) {
      if (which[x] < 0) continue;
      const std::size_t i = static_cast<std::size_t>(y) * rays_->stride + x;
      int chart = 0;
      out[x] += weight * pose.Radiance(which[x], t[x], rays_->One(i, 0, 0), chart);
      key[x] = static_cast<std::uint16_t>(chart);
    }
  }
}

// Replaces the single sample of a pixel on a silhouette by the mean of four on a rotated grid.
void RayCaster::SmoothEdges(const Pose& pose, float weight, const Hits& hits, cv::Mat& sum) const {
  constexpr float kPlaces[4][2] = {
      {-0.125f, -0.375f}, {0.375f, -0.125f}, {0.125f, 0.375f}, {-0.375f, 0.125f}};
  const auto differs = [&](int x, int y) {
    const std::uint16_t own = hits.key.at<std::uint16_t>(y, x);
    return (!hits.close.empty() && hits.close.at<int>(y, x) != 0) ||
           (x > 0 && hits.key.at<std::uint16_t>(y, x - 1) != own) ||
           (x + 1 < camera_.width && hits.key.at<std::uint16_t>(y, x + 1) != own) ||
           (y > hits.first && hits.key.at<std::uint16_t>(y - 1, x) != own) ||
           (y + 1 < hits.end && hits.key.at<std::uint16_t>(y + 1, x) != own);
  };
  for (const Tile& tile : tiles_) {
    std::vector<cv::Point> pixels;
    for (int y = std::max(tile.y0, hits.first); y < std::min(tile.y1, hits.end); ++y)
      for (int x = tile.x0; x < tile.x1; ++x)
        if (differs(x, y)) pixels.emplace_back(x, y);
    if (pixels.empty()) continue;
    const std::vector<int> candidates = pose.Candidates(tile);
    for (std::size_t first = 0; first < pixels.size(); first += 2) {
      std::array<Vector3f, kLanes> directions;
      Vec3<F8> d{};
      for (int lane = 0; lane < kLanes; ++lane) {
        const cv::Point pixel =
            pixels[std::min(first + static_cast<std::size_t>(lane / 4), pixels.size() - 1)];
        const std::size_t i = static_cast<std::size_t>(pixel.y) * rays_->stride + pixel.x;
        auto& direction = directions[static_cast<std::size_t>(lane)];
        direction = rays_->One(i, kPlaces[lane % 4][0], kPlaces[lane % 4][1]);
        d.x[lane] = direction.x();
        d.y[lane] = direction.y();
        d.z[lane] = direction.z();
      }
      F8 t;
      I8 which;
      pose.Nearest(candidates, d, t, which);
      for (int half = 0; half < 2 && first + half < pixels.size(); ++half) {
        const cv::Point pixel = pixels[first + half];
        int key = 0;
        F4 mean{};
        for (int lane = 4 * half; lane < 4 * half + 4; ++lane)
          if (which[lane] >= 0)
            mean +=
                0.25f * pose.Radiance(which[lane], t[lane], directions[static_cast<std::size_t>(lane)], key);
        const std::size_t i = static_cast<std::size_t>(pixel.y) * rays_->stride + pixel.x;
        const F4 single =
            pose.Radiance(hits.which.at<int>(pixel), hits.t.at<float>(pixel), rays_->One(i, 0, 0), key);
        sum.ptr<F4>(pixel.y)[pixel.x] += weight * (mean - single);
      }
    }
  }
}

void RayCaster::Accumulate(const Rigid3& cam_from_world, float weight, cv::Mat& sum,
                           double sway_angle) const {
  AccumulateRows(cam_from_world, weight, 0, camera_.height, sum, sway_angle);
}

void RayCaster::AccumulateRows(const Rigid3& cam_from_world, float weight, int first, int end, cv::Mat& sum,
                               double sway_angle) const {
  CV_Assert(sum.type() == CV_32FC4 && sum.cols == camera_.width && sum.rows == camera_.height);
  const Pose pose(*scene_, cam_from_world, rays_->pixel_angle, sway_angle);
  Hits hits{first, end, {}, {}, {}, {}};
  Trace(pose, hits);
  Shade(pose, weight, hits, sum);
  SmoothEdges(pose, weight, hits, sum);
}

cv::Mat RayCaster::Radiance(const Rigid3& cam_from_world, double sway_angle) const {
  cv::Mat sum = cv::Mat::zeros(camera_.height, camera_.width, CV_32FC4);
  Accumulate(cam_from_world, 1, sum, sway_angle);
  cv::Mat bgr(sum.size(), CV_32FC3);
  const int from_to[] = {0, 0, 1, 1, 2, 2};
  cv::mixChannels(&sum, 1, &bgr, 1, from_to, 3);
  return bgr;
}

cv::Mat RayCaster::RayLength(const Rigid3& cam_from_world, double sway_angle) const {
  const Pose pose(*scene_, cam_from_world, rays_->pixel_angle, sway_angle);
  Hits hits{0, camera_.height, {}, {}, {}, {}};
  Trace(pose, hits);
  return hits.t.colRange(0, camera_.width).clone();
}

cv::Mat RayCaster::MovingPixels(const Rigid3& cam_from_world, double sway_angle) const {
  const Pose pose(*scene_, cam_from_world, rays_->pixel_angle, sway_angle);
  Hits hits{0, camera_.height, {}, {}, {}, {}};
  Trace(pose, hits);
  cv::Mat moving = cv::Mat::zeros(camera_.height, camera_.width, CV_8UC1);
  for (int y = 0; y < camera_.height; ++y)
    for (int x = 0; x < camera_.width; ++x) {
      const int part = hits.which.at<int>(y, x);
      if (part >= 0 && scene_->primitives()[static_cast<std::size_t>(part)].moves)
        moving.at<std::uint8_t>(y, x) = 255;
    }
  return moving;
}

}  // namespace ulf::acquisition
