// docs/mistakes.jpg: the simulator's mistakes (docs/capture.md#mistakes), each as a frame whose left part is
// without it and whose right part is with it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"

namespace {

using ulf::acquisition::SimulatedCamera;
using ulf::acquisition::SimulationOptions;

constexpr int kColumns = 4, kGap = 6;
constexpr int kWidth = 352, kHeight = 264, kLabelHeight = 22;

struct Cell {
  std::string label, scene;
  std::vector<std::string> faults;  // one beside the other, in parts of the picture that are equally wide
  double readout_s = 0;
};

SimulationOptions OptionsFor(const Cell& cell) {
  SimulationOptions options;
  options.scene = cell.scene;
  options.width = 2 * kWidth;
  options.height = 2 * kHeight;
  return options;
}

// With the subject in the middle, the frame in which an automatic exposure is farthest from the one that was
// set, or, under a rolling shutter alone, in which the camera moves fastest; else one within the first row.
std::uint64_t FrameToShow(SimulationOptions options, const Cell& cell) {
  constexpr std::uint64_t kUsual = 72, kLast = 450;
  const bool adapts = options.faults.auto_exposure != ulf::acquisition::AutoExposure::kOff;
  if (!adapts && !cell.faults.empty()) return kUsual;
  constexpr int kSmaller = 16;
  options.width /= kSmaller, options.height /= kSmaller;
  const SimulatedCamera small(options);
  std::uint64_t best = kUsual;
  double most = 0;
  for (std::uint64_t i = 0; i < kLast; ++i) {
    const double open_s = static_cast<double>(i) / options.fps;
    const auto img = small.camera().ImgFromCam(small.hand().CamFromWorld(open_s) *
                                               small.scene().subject().center_in_world);
    constexpr double kMiddle = 0.1;  // of the width, to either side
    if (!img || std::abs(img->x() / small.camera().width - 0.5) > kMiddle) continue;
    const double much = adapts ? std::abs(std::log(small.Capture(i).exposure_s / options.exposure_s))
                               : small.BlurPx(open_s, cell.readout_s);
    if (much > most) best = i, most = much;
  }
  return best;
}

cv::Mat PictureOf(const Cell& cell) {
  const int parts = 1 + std::max(1, static_cast<int>(cell.faults.size()));
  cv::Mat picture(kHeight + kLabelHeight, kWidth, CV_8UC3, cv::Scalar::all(255));
  std::optional<std::uint64_t> frame;
  for (int part = parts - 1; part >= 0; --part) {  // the first decides nothing
    SimulationOptions options = OptionsFor(cell);
    if (part > 0) options.readout_s = cell.readout_s;
    if (part > 0 && !cell.faults.empty()) options.faults.Add(cell.faults[static_cast<std::size_t>(part - 1)]);
    if (!frame) frame = FrameToShow(options, cell);
    cv::Mat small;
    cv::resize(ulf::Srgb8(SimulatedCamera(options).Capture(*frame).image), small, {kWidth, kHeight}, 0, 0,
               cv::INTER_AREA);
    const int left = part * kWidth / parts, right = (part + 1) * kWidth / parts;
    const cv::Rect shown(left, 0, right - left, kHeight);
    small(shown).copyTo(picture(shown));
    if (part > 0) cv::line(picture, {left, 0}, {left, kHeight}, cv::Scalar::all(255), 1);
  }
  cv::putText(picture, cell.label, {2, kHeight + kLabelHeight - 6}, cv::FONT_HERSHEY_DUPLEX, 0.45,
              cv::Scalar::all(40), 1, cv::LINE_AA);
  return picture;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: mistake_pictures FOLDER\n");
    return 2;
  }
  const std::vector<Cell> cells{
      {"out of focus", "studio", {"defocus=8"}},
      {"auto exposure", "lightbox", {"auto_exposure=told"}},
      {"auto focus hunts", "easel", {"hunting=3:3.2", "hunting=8:3.2", "hunting=3:3.2"}},
      {"rolling shutter", "picture", {}, 0.06},
      {"flickering lamps, rolling shutter", "picture", {"flicker=100:0.4"}, 0.03},
      {"unsteady light", "plant", {"drift=-12"}},
      {"dust on the lens", "picture", {"dust=24"}},
      {"wrong lens", "picture", {"lens=0.85"}}};
  const int rows = (static_cast<int>(cells.size()) + kColumns - 1) / kColumns;
  const int step_x = kWidth + kGap, step_y = kHeight + kLabelHeight;
  cv::Mat sheet(rows * step_y, kColumns * step_x - kGap, CV_8UC3, cv::Scalar::all(255));
  for (int i = 0; i < static_cast<int>(cells.size()); ++i) {
    const cv::Mat picture = PictureOf(cells[static_cast<std::size_t>(i)]);
    picture.copyTo(sheet(cv::Rect({i % kColumns * step_x, i / kColumns * step_y}, picture.size())));
  }
  const std::string path = std::string(argv[1]) + "/mistakes.jpg";
  if (!cv::imwrite(path, sheet, {cv::IMWRITE_JPEG_QUALITY, 88})) {
    std::fprintf(stderr, "mistake_pictures: %s cannot be written\n", path.c_str());
    return 1;
  }
  std::printf("%s\n", path.c_str());
  return 0;
}
