#include "tests/charts/measured/cover_runs.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/mesh_file.h"
#include "render/quality/evaluate.h"
#include "tests/render/scenes/held_photograph.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

constexpr char kCap[] = "60x40";
constexpr int kPlaces = 40;

std::string Read(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

SimulatedCamera CameraOf(const CoverCase& which, std::shared_ptr<const HandMotion> hand = nullptr) {
  SimulationOptions options;
  options.scene = which.scene;
  options.seed = which.seed;
  options.looks_away = false;
  return SimulatedCamera(options, std::move(hand));
}

}  // namespace

CoverRun RunCover(const std::string& program, const CoverCase& which, const fs::path& folder) {
  fs::remove_all(folder);
  const SimulatedCamera camera = CameraOf(which);
  const Subject& subject = camera.scene().subject();
  const Eigen::Vector3d& center = subject.center_in_world;
  const fs::path report = folder.string() + ".json", errors = folder.string() + ".log";
  std::string command = fmt::format(
      "{} capture 'sim:{}?seed={}&look_away=0' -o {} --headless --deterministic --poses known "
      "--until-covered {} "
      "--max-seconds {:g} --json --subject={},{},{},{}",
      ShellWord(program), which.scene, which.seed, ShellWord(folder.string()), kCap, which.most_seconds,
      center.x(), center.y(), center.z(), subject.radius);
  for (const std::string& word : which.cover) command += " " + ShellWord(word);
  if (!which.person.empty()) command += " --operator " + ShellWord(which.person);
  if (std::system(
          fmt::format("{} > {} 2> {}", command, ShellWord(report.string()), ShellWord(errors.string()))
              .c_str()) != 0)
    throw Error("{}: {}", command, Read(errors));
  const nlohmann::json json = JsonFromText(Read(report));
  CoverRun run;
  run.views = json.at("recorded");
  if (const auto covered = json.find("covered"); covered != json.end() && covered->is_number())
    run.covered = *covered;

  const auto scene = LoadScene(ReadLightField(folder), {});
  const auto mesh = std::make_shared<const TriangleMesh>(ReadMeshFile(folder / kMeshProxyFile).mesh);
  GlRenderer renderer(WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, mesh)),
                      {.field = {.kind = FieldKind::kSubdivision, .level = 1}});
  HandOptions options = dynamic_cast<const Hand&>(camera.hand()).options();
  options.seed += 1000;
  options.cap_azimuth *= 0.85;
  options.cap_elevation *= 0.85;
  options.margin = 0;
  options.looks_away = false;
  const Hand hand(options);
  const CameraModel pinhole = camera.camera().WithoutDistortion();
  std::vector<double> disc_db, frame_db;
  for (int i = 0; i < kPlaces; ++i) {
    const Rigid3 pose = hand.CamFromWorld(hand.FirstPassEndS() * (0.05 + 0.95 * (i + 0.5) / kPlaces));
    SceneView truth;
    truth.camera = camera.camera();
    truth.cam_from_world = pose;
    truth.photograph = HoldPhotograph(MakePyramid(camera.CleanSrgb(pose)));
    const UndistortedPhotograph photograph = Undistort(truth);
    const cv::Mat picture = Srgb8FromLinear(renderer.Render(pinhole, pose).linear);
    const cv::Mat disc = SubjectDisc(pinhole, pose, subject) & photograph.valid;
    disc_db.push_back(CompareImages(picture, photograph.srgb8, disc).psnr_db);
    frame_db.push_back(CompareImages(picture, photograph.srgb8, photograph.valid).psnr_db);
  }
  constexpr double kWorstTenth = 0.1;
  run.median_db = Median(disc_db);
  run.worst_db = Quantile(disc_db, kWorstTenth);
  run.frame_db = Median(frame_db);
  fs::remove_all(folder);
  return run;
}

}  // namespace ulf::test
