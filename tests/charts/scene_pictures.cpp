// docs/scenes.jpg: every scene of the simulator as its hand first sees it, nearer.
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"

namespace {

constexpr int kColumns = 5, kGap = 6;
constexpr int kWidth = 352, kHeight = 264, kLabelHeight = 22;
constexpr double kNearer = 0.62;  // of the distance at which a capture starts

cv::Mat PictureOf(const std::string& name) {
  ulf::acquisition::SimulationOptions options;
  options.scene = name;
  options.width = 2 * kWidth;
  options.height = 2 * kHeight;
  const ulf::acquisition::SimulatedCamera camera(options);
  const ulf::acquisition::Scene& scene = camera.scene();
  const Eigen::Vector3d center = scene.subject().center_in_world;
  const cv::Mat large = camera.CleanSrgb(ulf::LookAt(
      center + kNearer * scene.FirstDistance() * scene.FirstDirection(), center, scene.UpInWorld()));
  cv::Mat picture(kHeight + kLabelHeight, kWidth, CV_8UC3, cv::Scalar::all(255));
  cv::resize(large, picture.rowRange(0, kHeight), {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  cv::putText(picture, name, {2, kHeight + kLabelHeight - 6}, cv::FONT_HERSHEY_DUPLEX, 0.5,
              cv::Scalar::all(40), 1, cv::LINE_AA);
  return picture;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: scene_pictures FOLDER\n");
    return 2;
  }
  const std::vector<std::string> names = ulf::acquisition::Scene::Names();
  const int rows = (static_cast<int>(names.size()) + kColumns - 1) / kColumns;
  const int step_x = kWidth + kGap, step_y = kHeight + kLabelHeight;
  cv::Mat sheet(rows * step_y, kColumns * step_x - kGap, CV_8UC3, cv::Scalar::all(255));
  for (int i = 0; i < static_cast<int>(names.size()); ++i) {
    const cv::Mat picture = PictureOf(names[static_cast<std::size_t>(i)]);
    picture.copyTo(sheet(cv::Rect({i % kColumns * step_x, i / kColumns * step_y}, picture.size())));
  }
  const std::string path = std::string(argv[1]) + "/scenes.jpg";
  if (!cv::imwrite(path, sheet, {cv::IMWRITE_JPEG_QUALITY, 88})) {
    std::fprintf(stderr, "scene_pictures: %s cannot be written\n", path.c_str());
    return 1;
  }
  std::printf("%s\n", path.c_str());
  return 0;
}
