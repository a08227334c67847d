#include "tests/charts/left_out_sets.h"

#include "acquisition/simulator/simulated_camera.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/pose_readers.h"
#include "tests/support/test_paths.h"

namespace ulf::test {

namespace fs = std::filesystem;

LightField SimulatedScan(const ScanOptions& options, const fs::path& dir) {
  const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse(options.uri)));
  CaptureHeader header;
  header.camera = camera.camera();
  auto writer = LightFieldWriter::Create(dir, header);
  for (int i = 0; i < options.views; ++i) {
    const Frame frame = camera.Capture(static_cast<std::uint64_t>(i * options.frames_between));
    View view;
    view.cam_from_world = frame.known_cam_from_world.value();
    writer.AddView(frame, view);
  }
  writer.SetSubject(camera.scene().subject());
  writer.SetUp(Eigen::Vector3d::UnitZ());
  writer.Close(1);
  return ReadLightField(dir);
}

std::optional<LeftOutSet> FoundSet(const std::string& name, const fs::path& work) {
  if (const auto strecha = TestData("strecha"); strecha && fs::exists(*strecha / name / "images"))
    return LeftOutSet{name, LightFieldOf(*strecha / name, ReadStrecha(*strecha / name))};
  const auto dir = TestData(name);
  if (!dir) return std::nullopt;
  if (name == "temple_ring") return LeftOutSet{name, MiddleburyLightField(*dir, "templeR_par.txt")};
  if (name == "llff_fern") return LeftOutSet{name, Import(*dir, work / name, {}).light_field};
  LeftOutSet set{name, ReadLightField(*dir)};
  if (name == "shop_grid_even") set.options = {.subject = Subject{{0, 0, -8.12}, 1.5}, .size_limit_px = 640};
  return set;
}

std::vector<int> EveryView(const LightField& light_field, int every, int first) {
  std::vector<int> indices;
  for (int i = first; i < static_cast<int>(light_field.views.size()); i += every) indices.push_back(i);
  return indices;
}

}  // namespace ulf::test
