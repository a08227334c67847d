// A tethered camera on loopback and the device that the stock driver makes of it.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <libexif/exif-data.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/gphoto2/gphoto_device.h"
#include "tests/support/floors.h"
#include "tests/support/ptpip_camera.h"
#include "tests/support/test_paths.h"

namespace ulf::test {

using std::chrono::milliseconds;

// A picture that says its number: its mean is the number.
inline std::string NumberedJpeg(int number, int width, int height) {
  cv::Mat picture(height, width, CV_8UC3, cv::Scalar::all(number % 200));
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes);
  return {bytes.begin(), bytes.end()};
}

// Exif as a camera writes it, before the rest of a JPEG.
inline std::string WithExif(const std::string& jpeg, std::uint32_t of_second = 60) {
  ExifData* data = exif_data_new();
  exif_data_set_option(data, EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_set_data_type(data, EXIF_DATA_TYPE_COMPRESSED);
  exif_data_set_byte_order(data, EXIF_BYTE_ORDER_INTEL);
  const auto put = [&](ExifTag tag, ExifFormat format, std::uint32_t a, std::uint32_t b) {
    ExifEntry* entry = exif_entry_new();
    exif_content_add_entry(data->ifd[EXIF_IFD_EXIF], entry);
    entry->tag = tag;
    entry->format = format;
    entry->components = 1;
    entry->size = format == EXIF_FORMAT_SHORT ? 2 : 8;
    entry->data = static_cast<unsigned char*>(calloc(1, 8));
    if (format == EXIF_FORMAT_SHORT)
      exif_set_short(entry->data, EXIF_BYTE_ORDER_INTEL, static_cast<ExifShort>(a));
    else
      exif_set_rational(entry->data, EXIF_BYTE_ORDER_INTEL, {a, b});
    exif_entry_unref(entry);
  };
  put(EXIF_TAG_EXPOSURE_TIME, EXIF_FORMAT_RATIONAL, 1, of_second);
  put(EXIF_TAG_FNUMBER, EXIF_FORMAT_RATIONAL, 71, 10);
  put(EXIF_TAG_ISO_SPEED_RATINGS, EXIF_FORMAT_SHORT, 640, 1);
  const std::string lens = "Acme 50mm f/1.8";
  ExifEntry* text = exif_entry_new();
  exif_content_add_entry(data->ifd[EXIF_IFD_EXIF], text);
  text->tag = EXIF_TAG_LENS_MODEL;
  text->format = EXIF_FORMAT_ASCII;
  text->components = text->size = static_cast<unsigned>(lens.size() + 1);
  text->data = static_cast<unsigned char*>(calloc(1, lens.size() + 1));
  std::ranges::copy(lens, text->data);
  exif_entry_unref(text);
  unsigned char* bytes = nullptr;
  unsigned size = 0;
  exif_data_save_data(data, &bytes, &size);
  std::string with = jpeg.substr(0, 2) + "\xFF\xE1";
  with += static_cast<char>((size + 2) >> 8);
  with += static_cast<char>((size + 2) & 0xFF);
  with.append(reinterpret_cast<const char*>(bytes), size);
  free(bytes);
  exif_data_unref(data);
  return with + jpeg.substr(2);
}

inline std::string FileName(int number, const char* ending = "JPG") {
  return fmt::format("DSC_{:04}.{}", number, ending);
}

inline std::vector<PtpipFile> NumberedPhotograph(int number) {
  return {{FileName(number), NumberedJpeg(number, 960, 640)}};
}

class GphotoTest : public ::testing::Test {
 protected:
  // The library keeps settings of its own in the home folder.
  void SetUp() override { setenv("HOME", home_.path().c_str(), 1); }

  void Begin(PtpipCamera::Photograph photograph = NumberedPhotograph,
             const PtpipCameraOptions& options = {}) {
    camera_ = std::make_unique<PtpipCamera>([this] { return NumberedJpeg(++live_, 320, 240); },
                                            std::move(photograph), options);
  }
  std::unique_ptr<Device> Open(const std::string& options = "") {
    return OpenGphotoDevice(DeviceUri::Parse(camera_->Uri() + options));
  }

  // The first frame that fits; none after ten seconds.
  static std::optional<Frame> Await(Device& device, const std::function<bool(const Frame&)>& fits) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      auto frame = device.Next(milliseconds(100));
      if (frame && fits(*frame)) return frame;
      if (!frame && device.State() != DeviceState::kStreaming) break;
    }
    return std::nullopt;
  }
  static std::optional<Frame> AwaitStill(Device& device) {
    return Await(device, [](const Frame& frame) { return frame.kind == FrameKind::kStill; });
  }
  static std::optional<Frame> AwaitLive(Device& device) {
    return Await(device, [](const Frame& frame) { return frame.kind == FrameKind::kLive; });
  }
  // Reads frames away until the condition holds; false after ten seconds.
  static bool Until(Device& device, const std::function<bool()>& holds) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      if (holds()) return true;
      device.Next(milliseconds(20));
    }
    return false;
  }
  // All that the device has said so far.
  const std::string& Said(Device& device) {
    for (const DeviceEvent& event : device.TakeEvents()) said_ += event.text + "\n";
    return said_;
  }

  ScratchFolder home_;
  std::atomic<int> live_{0};
  std::string said_;
  std::unique_ptr<PtpipCamera> camera_;
};

}  // namespace ulf::test
