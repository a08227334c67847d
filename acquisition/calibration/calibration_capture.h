// Views of a board from a device or from image files, and frames of a card.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_guide.h"
#include "acquisition/device/device.h"

namespace ulf::acquisition {

struct CollectedViews {
  int width = 0, height = 0;
  std::vector<BoardView> views =
      {};  // by a device: those taken; of files: one each, empty where it was not found
  std::vector<cv::Mat> pictures = {};  // of a device: the taken frames, for the report
  std::string ended = {};              // why it ended, for people; empty when there was enough
};

struct CaptureProgress {
  double share = 0;
  std::string text = {};
};

struct CalibrationCaptureOptions {
  std::string mode = "live";  // or "still": photographs are released and used instead of the live frames
  GuideOptions guide;
  std::function<void(const CaptureProgress&)> show = [](const CaptureProgress&) {};
  std::function<bool()> stop = [] { return false; };
  double still_timeout_s = 30;  // from asking for a photograph to having it
};

// Until there is enough, the device ends, or `stop`. Throws Error when the device is lost, UsageError for
// stills of a device that takes none.
CollectedViews CollectViews(Device& device, const Board& board, const CalibrationCaptureOptions& options);

// Throws Error where the files have different sizes, or there are none.
CollectedViews CollectViews(const std::vector<std::string>& files, const Board& board,
                            const CalibrationCaptureOptions& options);

// The next `count` complete frames of the mode: live ones, or photographs, each asked for. Fewer when the
// device ends or `stop`. Throws Error when the device is lost or a photograph does not come, UsageError for
// stills of a device that takes none.
std::vector<Frame> CollectFrames(Device& device, int count, const CalibrationCaptureOptions& options);

// The images among files and folders, each folder in the order of names as people count.
std::vector<std::string> ImagesIn(const std::vector<std::string>& paths);

}  // namespace ulf::acquisition
