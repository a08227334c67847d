// Tests: acquisition/device/device_files, commands/camera/devices_command.
//
// The rules in udev/: what they do to cameras that are not there (replayed through umockdev into `udevadm
// test`, with a view of the file system of the test's own), and whether missing ones are noticed.
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "acquisition/device/device_files.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::udev_rules_test {
namespace {

namespace fs = std::filesystem;
using test::ScratchFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

void Write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

std::string Read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::string Hex(const std::vector<unsigned>& bytes) {
  std::string text;
  for (const unsigned byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

// One configuration with the interfaces' class, subclass and protocol, each with one bulk endpoint.
std::string UsbDevice(const std::string& name, const std::vector<std::array<unsigned, 3>>& interfaces) {
  std::vector<unsigned> device{18, 1, 0, 3, 0xEF, 2, 1, 9, 0x6B, 0x1D, 4, 1, 0, 1, 1, 2, 3, 1};
  const unsigned total = 9 + static_cast<unsigned>(interfaces.size()) * (9 + 7);
  std::vector<unsigned> bytes = device;
  bytes.insert(bytes.end(), {9, 2, total, 0, static_cast<unsigned>(interfaces.size()), 1, 0, 0x80, 50});
  unsigned number = 0;
  for (const auto& [kind, subclass, protocol] : interfaces) {
    bytes.insert(bytes.end(), {9, 4, number, 0, 1, kind, subclass, protocol, 0});
    bytes.insert(bytes.end(), {7, 5, 0x81 + number, 2, 0, 4, 0});
    ++number;
  }
  return fmt::format(
      "P: /devices/pci0000:00/0000:00:14.0/usb2/2-1\nN: bus/usb/002/003\nE: BUSNUM=002\nE: DEVNUM=003\n"
      "E: DEVNAME=/dev/bus/usb/002/003\nE: DEVTYPE=usb_device\nE: MAJOR=189\nE: MINOR=130\nE: SUBSYSTEM=usb\n"
      "A: bDeviceClass=ef\\n\nA: bDeviceSubClass=02\\n\nA: bDeviceProtocol=01\\n\nA: idVendor=1d6b\\n\n"
      "A: idProduct=0104\\n\nA: bcdDevice=0100\\n\nA: busnum=2\\n\nA: devnum=3\\n\nA: manufacturer=Test\\n\n"
      "A: product={}\\n\nA: serial=42\\n\nH: descriptors={}\n\n"
      "P: /devices/pci0000:00/0000:00:14.0/usb2\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n",
      name, Hex(bytes));
}

constexpr const char* kUsbPath = "/devices/pci0000:00/0000:00:14.0/usb2/2-1";
constexpr const char* kVideoPath = "/devices/platform/webcam/video4linux/video0";
constexpr const char* kVideoDevice =
    "P: /devices/platform/webcam/video4linux/video0\nN: video0=00\nE: DEVNAME=/dev/video0\nE: MAJOR=81\n"
    "E: MINOR=0\nE: SUBSYSTEM=video4linux\nA: name=Webcam\\n\nA: index=0\\n\n\n"
    "P: /devices/platform/webcam\nE: SUBSYSTEM=platform\n";

// What udev would do when the device appears, with our rules alone. None: the tools are not there or not
// allowed here; `why` says what is missing.
std::optional<std::string> Replay(const std::string& device, const std::string& path, std::string* why) {
  ScratchFolder scratch;
  Write(scratch / "rules.d/70-ulf-cameras.rules", Read(fs::path(CHECKOUT) / "udev/70-ulf-cameras.rules"));
  Write(scratch / "device.umockdev", device);
  fs::create_directories(scratch / "empty");
  fs::create_directories(scratch / "own");
  const auto quoted = [&](const char* name) { return "'" + (scratch / name).string() + "'"; };
  // /run and /dev of its own: nothing is written to this computer's database or device files.
  const std::string inside = fmt::format(
      "set -e; mkdir {2}/dev; for i in null zero urandom; do touch {2}/dev/$i; "
      "mount --bind /dev/$i {2}/dev/$i; done; mount --rbind {2}/dev /dev; mount -t tmpfs own /run; "
      "mount --bind {0} /etc/udev/rules.d; mount --bind {1} /usr/lib/udev/rules.d; "
      "touch {2}/mounted; SYSTEMD_DEVICE_VERIFY_SYSFS=0 "
      "umockdev-run -d {3} -- udevadm test --action=add {4}",
      quoted("rules.d"), quoted("empty"), quoted("own"), quoted("device.umockdev"), path);
  Write(scratch / "inside.sh", inside);
  for (const char* tool : {"unshare", "umockdev-run", "udevadm"})
    if (std::system(fmt::format("command -v {} >/dev/null 2>&1", tool).c_str()) != 0) {
      *why = std::string(tool) + " is not installed";
      return std::nullopt;
    }
  if (std::system("unshare -rm true >/dev/null 2>&1") != 0) {
    *why = "a view of the file system of its own is not allowed here (unshare -rm)";
    return std::nullopt;
  }
  const std::string output = (scratch / "output").string();
  const int status =
      std::system(fmt::format("unshare -rm bash {} > '{}' 2>&1", quoted("inside.sh"), output).c_str());
  const std::string text = Read(output);
  if (!fs::exists(scratch / "own/mounted")) {
    *why = "mounting is not allowed here: " + text;
    return std::nullopt;
  }
  EXPECT_EQ(status, 0) << text;
  return text;
}

#define ULF_REPLAY(variable, device, path)                            \
  std::string variable##_why;                                         \
  const auto variable##_text = Replay(device, path, &variable##_why); \
  if (!variable##_text) GTEST_SKIP() << variable##_why;               \
  const std::string& variable = *variable##_text

TEST(UdevRules, GiveAnyUsb3VisionCameraToUserAndGroup) {
  ULF_REPLAY(text, UsbDevice("Vision", {{0xEF, 5, 0}, {0xEF, 5, 1}, {0xEF, 5, 2}}), kUsbPath);
  EXPECT_THAT(text, HasSubstr("ID_ULF_CAMERA=usb3vision"));
  EXPECT_THAT(text, HasSubstr("TAGS=:uaccess:"));
  EXPECT_THAT(text, HasSubstr("GROUP 46"));  // plugdev in Debian
  EXPECT_THAT(text, HasSubstr("MODE 0660"));
  EXPECT_THAT(text, Not(HasSubstr("Unknown")));
}

TEST(UdevRules, GiveStillCamerasToUserAndGroup) {
  ULF_REPLAY(text, UsbDevice("Reflex", {{6, 1, 1}}), kUsbPath);
  EXPECT_THAT(text,
              AllOf(HasSubstr("ID_ULF_CAMERA=ptp"), HasSubstr("ID_GPHOTO2=1"), HasSubstr("TAGS=:uaccess:")));
  EXPECT_THAT(text, Not(HasSubstr("usb3vision")));
}

TEST(UdevRules, GiveWebcamsToTheUser) {
  ULF_REPLAY(text, kVideoDevice, kVideoPath);
  EXPECT_THAT(text, AllOf(HasSubstr("TAGS=:uaccess:"), HasSubstr("GROUP 44")));  // video in Debian
}

// A USB webcam's own device file, a keyboard, a disk: none of ours.
TEST(UdevRules, LeaveEverythingElseAlone) {
  const std::vector<std::vector<std::array<unsigned, 3>>> others{
      {{0x0E, 1, 0}, {0x0E, 2, 0}}, {{3, 1, 1}}, {{8, 6, 0x50}}, {{0xEF, 4, 0}}, {{0xFE, 5, 0}}};
  for (const auto& interfaces : others) {
    ULF_REPLAY(text, UsbDevice("Other", interfaces), kUsbPath);
    EXPECT_THAT(text, HasSubstr("ID_USB_INTERFACES=")) << "the device was looked at";
    EXPECT_THAT(text, Not(HasSubstr("ID_ULF_CAMERA"))) << Hex({interfaces[0][0]});
    EXPECT_THAT(text, Not(HasSubstr("uaccess"))) << Hex({interfaces[0][0]});
    EXPECT_THAT(text, Not(HasSubstr("plugdev"))) << Hex({interfaces[0][0]});
  }
}

TEST(UdevRules, MissingOnesAreNoticed) {
  using enum UdevCameraKind;
  ScratchFolder scratch;
  const fs::path etc = scratch / "etc", lib = scratch / "lib";
  const std::vector<fs::path> folders{etc, scratch / "absent", lib};
  for (const auto kind : {kUsb3Vision, kVideo, kStill}) EXPECT_FALSE(InstalledUdevRules(kind, folders));
  ASSERT_TRUE(MissingUdevRulesHint(folders));
  EXPECT_THAT(*MissingUdevRulesHint(folders),
              AllOf(HasSubstr("70-ulf-cameras.rules"), HasSubstr("/etc/udev/rules.d"),
                    HasSubstr("USB3 Vision cameras, webcams, DSLRs")));
  EXPECT_FALSE(MissingUdevRulesHint(folders, /*is_root=*/true));

  Write(lib / "60-other.rules",
        "# :ef0500: in a comment grants nothing, GROUP=\"x\"\nSUBSYSTEM==\"usb\", TAG+=\"uaccess\"\n");
  EXPECT_FALSE(InstalledUdevRules(kUsb3Vision, folders));
  Write(lib / "65-names.rules", "ENV{ID_USB_INTERFACES}==\"*:ef0500:*\", SYMLINK+=\"camera\"\n");
  EXPECT_FALSE(InstalledUdevRules(kUsb3Vision, folders)) << "a name is not a permission";

  // What a system has of its own is not asked for again, and what is missing is named.
  Write(lib / "50-udev-default.rules", "SUBSYSTEM==\"video4linux\", GROUP=\"video\"\n");
  EXPECT_THAT(*MissingUdevRulesHint(folders),
              AllOf(HasSubstr("USB3 Vision cameras, DSLRs"), Not(HasSubstr("webcams"))));
  Write(lib / "70-uaccess.rules", "ENV{ID_GPHOTO2}==\"?*\", TAG+=\"uaccess\"\n");
  EXPECT_FALSE(InstalledUdevRules(kStill, folders)) << "somebody must say which they are";
  Write(lib / "60-libgphoto2.rules",
        "ENV{ID_USB_INTERFACES}==\"*:060101:*\", ENV{ID_GPHOTO2}=\"1\", MODE=\"0664\", GROUP=\"plugdev\"\n");
  EXPECT_THAT(*MissingUdevRulesHint(folders), AllOf(HasSubstr("open USB3 Vision cameras"),
                                                    Not(HasSubstr("DSLR")), Not(HasSubstr("webcams"))));

  Write(lib / "70-ulf-cameras.rules", Read(fs::path(CHECKOUT) / "udev/70-ulf-cameras.rules"));
  EXPECT_EQ(InstalledUdevRules(kUsb3Vision, folders), lib / "70-ulf-cameras.rules");
  EXPECT_FALSE(MissingUdevRulesHint(folders));
  for (const auto kind : {kUsb3Vision, kVideo, kStill}) {
    ScratchFolder ours;
    fs::copy_file(lib / "70-ulf-cameras.rules", ours / "70-ulf-cameras.rules");
    EXPECT_TRUE(InstalledUdevRules(kind, {ours.path()})) << static_cast<int>(kind);
  }

  fs::create_directories(etc);
  fs::create_symlink("/dev/null", etc / "70-ulf-cameras.rules");
  EXPECT_FALSE(InstalledUdevRules(kUsb3Vision, folders)) << "masked by an empty file of the same name";
}

// Rules of others for the same cameras are as good: by the list of interfaces or by one interface's
// attributes.
TEST(UdevRules, EquivalentOnesCount) {
  for (const char* rule : {"SUBSYSTEM==\"usb\", ENV{ID_USB_INTERFACES}==\"*:ef0500:*\", TAG+=\"uaccess\"\n",
                           "SUBSYSTEM==\"usb\", ATTRS{bInterfaceClass}==\"ef\", \\\n  "
                           "ATTRS{bInterfaceSubClass}==\"05\", MODE:=\"0666\"\n"}) {
    ScratchFolder scratch;
    Write(scratch / "lib/80-aravis.rules", rule);
    EXPECT_TRUE(InstalledUdevRules(UdevCameraKind::kUsb3Vision, {scratch / "lib"})) << rule;
  }
}

// Nothing is found and no rule is there: an ordinary user is told, root needs none.
TEST(UdevRules, MissingOnesAreSpokenOfByUlfDevices) {
  if (geteuid() != 0) GTEST_SKIP() << "becoming another user, with folders of its own, takes root";
  const ScratchFolder scratch;
  fs::create_directories(scratch / "empty");
  fs::copy_file(std::getenv("ULF_BINARY"), scratch / "ulf");
  for (const fs::path& open : {scratch.path(), scratch / "ulf", scratch / "empty"})
    fs::permissions(open, fs::perms(0755));
  const auto devices = [&](const std::string& as, const std::string& arguments) {
    std::string script;
    for (const fs::path& folder : UdevRuleFolders())
      script += fmt::format("[ ! -d {0} ] || mount --bind '{1}' {0} || exit 77\n", folder.string(),
                            (scratch / "empty").string());
    Write(scratch / "script", fmt::format("{}HOME=/nonexistent exec {} '{}' devices {} > '{}'\n", script, as,
                                          (scratch / "ulf").string(), arguments, (scratch / "out").string()));
    const int status = std::system(fmt::format("unshare -nm sh '{}'", (scratch / "script").string()).c_str());
    return WEXITSTATUS(status) == 0 ? Read(scratch / "out") : fmt::format("status {}", status);
  };
  if (std::system("unshare -nm setpriv --reuid=65534 --regid=65534 --clear-groups true >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "becoming another user is not allowed here";
  const std::string other = "setpriv --reuid=65534 --regid=65534 --clear-groups";
  const auto told = AllOf(HasSubstr("No udev rule lets you open USB3 Vision cameras, webcams, DSLRs"),
                          HasSubstr("udev/70-ulf-cameras.rules"));
  EXPECT_THAT(devices(other, ""), told);
  EXPECT_THAT(devices(other, "--json"), AllOf(HasSubstr("\"hint\""), told));
  EXPECT_THAT(devices("", ""), AllOf(HasSubstr("sim:"), Not(HasSubstr("udev rule"))));
}

}  // namespace
}  // namespace ulf::udev_rules_test
