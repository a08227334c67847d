// Collects views of a board from a device or from image files, and frames of a card for the flat field.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_guide.h"
#include "acquisition/device/device.h"

namespace ulf::acquisition {

// Describes why collecting views came to an end.
enum class ViewsEnd { kEnough, kStopped, kDeviceEnded, kNoPhotograph };

struct CollectedViews {
  int width = 0, height = 0;
  std::vector<BoardView> views =
      {};  // of a device: those taken; of files: one each, empty when no board was found
  std::vector<cv::Mat> pictures = {};  // of a device: the frames of the views
  std::vector<cv::Mat> unseen = {};    // of a device: some of the frames without the board
  std::size_t moving = 0;              // of a device: the live frames in which the board moved
  ViewsEnd end = ViewsEnd::kEnough;    // of files always this one
};

struct CaptureProgress {
  double share = 0;
  std::string text = {};
};

struct CalibrationCaptureOptions {
  std::string mode = "live";  // or "still": uses photographs, which it releases, instead of live frames
  int least_views = CalibrationGuide::kLeastViews;  // of a device
  std::function<void(const CaptureProgress&)> show = [](const CaptureProgress&) {};
  // Gets each frame or photograph that the guide has judged, to draw it (calibration_picture.h).
  std::function<void(const cv::Mat& gray, const CalibrationGuide&, ViewVerdict)> show_picture = {};
  // For mode "still": gets each line for the photographer; returns whether a photograph is wanted now.
  std::function<void(const std::string&)> say = [](const std::string&) {};
  std::function<bool()> release = [] { return false; };
  std::function<bool()> stop = [] { return false; };
};

// Collects views until they suffice, the device ends, or `stop`. Photographs are asked for where live frames
// show the board still and in a new place, and by `release`; those of the camera's own release count as well.
// Throws Error when the device is lost or shows another board (other_board.h), Refusal for mode "still" on a
// device that takes no photographs.
CollectedViews CollectViews(Device& device, const Board& board, const CalibrationCaptureOptions& options);

// Throws Error when there are no files or their sizes differ.
CollectedViews CollectViews(const std::vector<std::string>& files, const Board& board,
                            const CalibrationCaptureOptions& options);

// Returns the next `count` complete frames of the mode: live frames, or photographs, which it requests. Fewer
// when the device ends, or after `stop`. Throws Error when the device is lost or a photograph does not
// arrive, Refusal for mode "still" on a device that takes no photographs.
std::vector<Frame> CollectFrames(Device& device, int count, const CalibrationCaptureOptions& options);

// Returns the image files in a list of files and folders; those of a folder in natural order of their names.
std::vector<std::string> ImagesIn(const std::vector<std::string>& paths);

}  // namespace ulf::acquisition
