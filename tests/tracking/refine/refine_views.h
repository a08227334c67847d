// Views for refining: the textured room with poses that are a little off, and what became of them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/refine/refine.h"

namespace ulf::test {

inline Rigid3 Disturbed(const Rigid3& cam_from_world, double shift, double angle_deg, Draw& draw) {
  Rigid3 world_from_cam = cam_from_world.Inverse();
  world_from_cam.translation += shift * draw.Direction();
  world_from_cam.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle_deg * M_PI / 180, draw.Direction())) *
                            world_from_cam.rotation;
  return world_from_cam.Inverse();
}

struct RoomViews {
  RefineInput input;
  std::vector<Rigid3> truth;
  std::vector<Image> images;
};

// Views of a room from these poses, which are right.
inline std::unique_ptr<RoomViews> ViewsOf(const TexturedRoom& room, const CameraModel& lens,
                                          const std::vector<Rigid3>& poses) {
  auto views = std::make_unique<RoomViews>();
  views->input.lenses = {lens};
  views->truth = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    views->images.push_back(room.Take(poses[i], i, lens).image);
    views->input.views.push_back({"view " + std::to_string(i), 0, poses[i]});
  }
  views->input.read = [from = views.get()](int i) { return from->images[static_cast<std::size_t>(i)]; };
  return views;
}

enum class Way { kHand, kTurning, kSideways };

// Views of the room with poses off by `shift` metres and `angle_deg` degrees.
inline std::unique_ptr<RoomViews> MakeViews(int count, double shift, double angle_deg, unsigned seed,
                                            Way way = Way::kHand, bool panels = true) {
  const TexturedRoom room({.furniture = panels ? Furniture::kPanels : Furniture::kWall, .seed = seed});
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back(way == Way::kTurning ? TexturedRoom::TurningAt(3 * i)
                    : way == Way::kHand
                        ? TexturedRoom::HandAt(12 * i)
                        : LookAt({0.06 * i - 0.4, 0, 0}, {0.06 * i - 0.4, 0, 3}, -Eigen::Vector3d::UnitY()));
  auto views = ViewsOf(room, TexturedRoom::Camera(), poses);
  Draw draw(seed);
  for (auto& view : views->input.views)
    view.cam_from_world = Disturbed(view.cam_from_world, shift, angle_deg, draw);
  return views;
}

struct PoseErrors {
  double center = 0, rotation_deg = 0;  // root mean square after the similarity that fits best
};

template <typename PoseOf>
PoseErrors ErrorsOf(const std::vector<Rigid3>& truth, PoseOf pose_of) {
  std::vector<TimedPose> estimated, true_poses;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    estimated.push_back({static_cast<double>(i), pose_of(i)});
    true_poses.push_back({static_cast<double>(i), truth[i]});
  }
  const auto error = CompareTrajectories(estimated, true_poses, 0.1);
  return error ? PoseErrors{error->ate_rmse, error->rotation_rmse_deg} : PoseErrors{1e9, 1e9};
}

inline PoseErrors Before(const RoomViews& views) {
  return ErrorsOf(views.truth, [&](std::size_t i) { return views.input.views[i].cam_from_world; });
}

inline PoseErrors After(const RoomViews& views, const RefineResult& result) {
  return ErrorsOf(views.truth, [&](std::size_t i) { return result.views[i].cam_from_world; });
}

// Writes the views, with the poses that are a little off, as a light field.
inline void WriteRoom(const RoomViews& views, const std::filesystem::path& dir) {
  CaptureHeader header;
  header.camera = views.input.lenses[0];
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  for (std::size_t v = 0; v < views.images.size(); ++v) {
    Frame frame;
    frame.image = views.images[v];
    View view;
    view.cam_from_world = views.input.views[v].cam_from_world;
    writer.AddView(frame, view);
  }
  writer.Close(1);
}

// Fewer corners than by default: time.
inline RefineResult RefineRoom(const RoomViews& views, bool intrinsics = false) {
  RefineOptions options;
  options.features = 800;
  options.intrinsics = intrinsics;
  return Refine(views.input, options);
}

}  // namespace ulf::test
