// Tests: acquisition/opening/open_device, acquisition/device/device, core/base/device_uri.
#include <gmock/gmock.h>

#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/support/floors.h"

namespace ulf::open_device_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string RefusalOf(const std::string& uri) {
  try {
    OpenDevice(uri);
  } catch (const Refusal& error) {
    return error.what();
  }
  ADD_FAILURE() << uri << ": no Refusal";
  return "";
}

TEST(OpenDevice, UnknownSchemesSayWhatThereIs) {
  for (const char* uri : {"usb:0", "http://camera", "SIM:studio"})
    EXPECT_THAT(RefusalOf(uri), AllOf(HasSubstr("replay:PATH"), HasSubstr("aravis:ID"))) << uri;
}

TEST(OpenDevice, UnknownSceneListsTheScenes) {
  EXPECT_THAT(RefusalOf("sim:nonsense"), AllOf(HasSubstr("'nonsense'"), HasSubstr("studio"),
                                               HasSubstr("wall"), HasSubstr("board"), HasSubstr("card")));
}

TEST(OpenDevice, ChecksTetheredOptionsBeforeSearching) {
  EXPECT_THAT(RefusalOf("gphoto2:usb:001,004?zoom=2"), HasSubstr("shutter"));
  EXPECT_THAT(RefusalOf("gphoto2:usb:001,004?target=disk"), HasSubstr("card or ram"));
  EXPECT_THAT(RefusalOf("gphoto2:usb:001,004?liveview_fps=0"), HasSubstr("liveview_fps"));
}

TEST(OpenDevice, InvalidUriShowsTheSyntax) {
  for (const char* uri : {"studio", ":studio", "replay:a?fps"}) RefusalOf(uri);
}

TEST(OpenDevice, ChecksAravisOptionsBeforeSearching) {
  EXPECT_THAT(RefusalOf("aravis:192.0.2.1?format=YUV9"), AllOf(HasSubstr("YUV9"), HasSubstr("BayerRG8")));
  EXPECT_THAT(RefusalOf("aravis:192.0.2.1?exposure=5"), HasSubstr("exposure_us"));
  EXPECT_THAT(RefusalOf("aravis:192.0.2.1?exposure_us=short"), HasSubstr("exposure_us"));
  EXPECT_THAT(RefusalOf("aravis:192.0.2.1?roi=640x480"), HasSubstr("WIDTHxHEIGHT+X+Y"));
  EXPECT_THAT(RefusalOf("aravis:192.0.2.1?packet_size=1.5"), HasSubstr("packet_size"));
  EXPECT_THAT(RefusalOf("aravis:192.0.2.1?queue=0"), HasSubstr("queue"));
}

TEST(OpenDevice, ChecksV4l2OptionsBeforeSearching) {
  EXPECT_THAT(RefusalOf("v4l2:/dev/video99?format=ABCD"), AllOf(HasSubstr("ABCD"), HasSubstr("MJPEG")));
  EXPECT_THAT(RefusalOf("v4l2:/dev/video99?size=640"), HasSubstr("WIDTHxHEIGHT"));
  EXPECT_THAT(RefusalOf("v4l2:/dev/video99?fps=0"), HasSubstr("fps"));
  EXPECT_THAT(RefusalOf("v4l2:/dev/video99?settle=never"), HasSubstr("settle"));
  EXPECT_THAT(RefusalOf("v4l2:/dev/video99?io=dma"), HasSubstr("userptr"));
  EXPECT_THAT(RefusalOf("v4l2:/dev/video99?queue=1.5"), HasSubstr("queue"));
}

TEST(DeviceUri, NumbersAreReadWhole) {
  const DeviceUri uri = DeviceUri::Parse("sim:studio?a=2.5&b=1e3&c=12px&d=&e=inf");
  EXPECT_EQ(uri.Number("a"), 2.5);
  EXPECT_EQ(uri.Number("b"), 1000);
  EXPECT_EQ(uri.Number("missing"), std::nullopt);
  for (const char* key : {"c", "d", "e"}) EXPECT_THROW(uri.Number(key), Refusal) << key;
}

}  // namespace
}  // namespace ulf::open_device_test
