// Collects views of a board from a device or from image files, and frames of a card for the flat field.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_guide.h"
#include "acquisition/device/device.h"

namespace ulf::acquisition {

// Why collecting views came to an end. kNoPhotograph: a requested photograph did not arrive in time.
enum class ViewsEnd { kEnough, kStopped, kDeviceEnded, kNoPhotograph };

struct CollectedViews {
  int width = 0, height = 0;  // of the pictures
  // The live frames that the guide took, the photographs that show the board, or one for each file, empty if
  // it shows no board.
  std::vector<BoardView> views = {};
  std::vector<cv::Mat> pictures = {};  // of a device: the pictures of the views, CV_8UC1
  std::vector<cv::Mat> unseen = {};    // of a device: some of the pictures without the board
  std::size_t moving = 0;              // of a device: number of live frames in which the board moved
  ViewsEnd end = ViewsEnd::kEnough;    // of files always this one
};

struct CaptureProgress {
  double share = 0;  // of what is needed, 0 to 1
  std::string text = {};
};

struct CalibrationCaptureOptions {
  std::string mode = "live";  // or "still": uses photographs, which it releases, instead of live frames
  int least_views = CalibrationGuide::kLeastViews;  // of a device
  std::function<void(const CaptureProgress&)> show = [](const CaptureProgress&) {};
  // Gets each frame or photograph that the guide has judged, to draw it (calibration_picture.h).
  std::function<void(const cv::Mat& gray, const CalibrationGuide&, ViewVerdict)> show_picture = {};
  // For mode "still": `say` gets lines for the photographer, `release` returns whether to take a photograph.
  std::function<void(const std::string&)> say = [](const std::string&) {};
  std::function<bool()> release = [] { return false; };
  std::function<bool()> stop = [] { return false; };  // true ends the collecting
};

// Starts the device, collects views until they suffice, the device ends, or `stop` says so, and stops the
// device. It requests photographs when live frames show the board still and in a new place, and when
// `release` says so; those of the camera's own release count as well. Throws Error when the device is lost or
// shows another board (other_board.h), Refusal for mode "still" on a device that takes no photographs.
CollectedViews CollectViews(Device& device, const Board& board, const CalibrationCaptureOptions& options);

// Collects one view of each file. Throws Error if there is none, one cannot be read, or their sizes differ.
CollectedViews CollectViews(const std::vector<std::string>& files, const Board& board,
                            const CalibrationCaptureOptions& options);

// Returns the next `count` complete frames of the mode: live frames, or photographs, which it requests.
// Returns fewer when the device ends, or `stop` says so. Throws Error when the device is lost or a photograph
// does not arrive, Refusal for mode "still" on a device that takes no photographs.
std::vector<Frame> CollectFrames(Device& device, int count, const CalibrationCaptureOptions& options);

// Returns the image files in a list of files and folders, those of a folder in natural order of their names.
// Throws Error for a path that does not exist or a folder without images.
std::vector<std::string> ImagesIn(const std::vector<std::string>& paths);

}  // namespace ulf::acquisition
