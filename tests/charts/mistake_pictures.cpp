// docs/mistakes.jpg: the simulator's mistakes (docs/mistakes.md), each as the left half of a frame without it and the
// right half of the same frame with it.
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
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
  std::vector<std::string> faults;
  double readout_s = 0;
};

SimulationOptions OptionsFor(const Cell& cell) {
  SimulationOptions options;
  options.scene = cell.scene;
  options.width = 2 * kWidth;
  options.height = 2 * kHeight;
  return options;
}

// The frame in which an automatic exposure is farthest from the one that was set; under a rolling shutter alone the one in
// which the camera, with the subject in view, moves fastest; else one within the first row.
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
    if (!adapts && !(img && small.camera().Contains(*img))) continue;
    const double much = adapts ? std::abs(std::log(small.Capture(i).exposure_s / options.exposure_s))
                               : small.BlurPx(open_s, cell.readout_s);
    if (much > most) best = i, most = much;
  }
  return best;
}

cv::Mat PictureOf(const Cell& cell) {
  SimulationOptions options = OptionsFor(cell);
  const SimulatedCamera without(options);
  for (const std::string& fault : cell.faults) options.faults.Add(fault);
  options.readout_s = cell.readout_s;
  const SimulatedCamera with(options);
  const std::uint64_t frame = FrameToShow(options, cell);
  cv::Mat picture(kHeight + kLabelHeight, kWidth, CV_8UC3, cv::Scalar::all(255));
  for (const bool mistaken : {false, true}) {
    const cv::Mat large = ulf::Srgb8((mistaken ? with : without).Capture(frame).image);
    cv::Mat small;
    cv::resize(large, small, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
    const cv::Rect half(mistaken ? kWidth / 2 : 0, 0, kWidth / 2, kHeight);
    small(half).copyTo(picture(half));
  }
  cv::line(picture, {kWidth / 2, 0}, {kWidth / 2, kHeight}, cv::Scalar::all(255), 1);
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
  const std::vector<Cell> cells{{"out of focus", "studio", {"defocus=8"}},
                                {"auto exposure", "gloss", {"auto_exposure=told"}},
                                {"auto focus hunts", "studio", {"hunting=6:3.2"}},
                                {"rolling shutter", "room", {}, 0.06},
                                {"flickering lamps, rolling shutter", "picture", {"flicker=100:0.4"}, 0.03},
                                {"unsteady light", "studio", {"drift=-12"}},
                                {"dust on the lens", "picture", {"dust=24"}},
                                {"wrong lens", "studio", {"lens=0.85"}}};
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
