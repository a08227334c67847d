// Tests: acquisition/aravis/aravis_features, acquisition/device/features, acquisition/device/feature_file,
// acquisition/opening/open_device, acquisition/simulator/gige/genicam_description,
// commands/camera/features_command.
//
// A camera's own settings by name: the tree, its errors, and files of settings that depend on each other.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "acquisition/device/feature_file.h"
#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::camera_features_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kUri = "aravis:127.0.0.1";

CameraFeature Number(double min, double max, double step, FeatureType type = FeatureType::kInteger) {
  CameraFeature feature;
  feature.name = "N";
  feature.type = type;
  feature.min = min;
  feature.max = max;
  feature.step = step;
  return feature;
}

TEST(FeatureValues, AreCheckedBeforeWriting) {
  const CameraFeature number = Number(16, 64, 4);
  EXPECT_EQ(CheckedValue("cam", number, "0x20"), "32");
  EXPECT_EQ(CheckedValue("cam", number, "20.0"), "20");
  for (const char* wrong : {"8", "68", "18", "twenty", "20px", ""})
    EXPECT_THROW(CheckedValue("cam", number, wrong), Refusal) << wrong;
  const CameraFeature real = Number(0.5, 2, 0, FeatureType::kFloat);
  EXPECT_EQ(CheckedValue("cam", real, "1e0"), "1");
  for (const char* wrong : {"0.4", "2.1", "nan", "inf", "x"})
    EXPECT_THROW(CheckedValue("cam", real, wrong), Refusal) << wrong;
  CameraFeature choice;
  choice.name = "C";
  choice.type = FeatureType::kEnumeration;
  choice.choices = {"Off", "On"};
  EXPECT_EQ(CheckedValue("cam", choice, "On"), "On");
  EXPECT_THAT(
      [&] { CheckedValue("cam", choice, "on"); },
      testing::ThrowsMessage<Refusal>(AllOf(HasSubstr("cam"), HasSubstr("C=on"), HasSubstr("Off, On"))));
}

TEST(FeatureValues, AreTheSameHoweverTheyAreWritten) {
  EXPECT_TRUE(SameValue(Number(0, 100, 1), "16", "0x10"));
  EXPECT_FALSE(SameValue(Number(0, 100, 1), "16", "17"));
  EXPECT_TRUE(SameValue(Number(0, 100, 0, FeatureType::kFloat), "33.333333", "33.33334"));
  EXPECT_FALSE(SameValue(Number(0, 100, 0, FeatureType::kFloat), "33.3", "33.4"));
  EXPECT_TRUE(SameValue(Number(0, 100, 0.5, FeatureType::kFloat), "33.3", "33.5")) << "half a step";
}

TEST(CameraFeatures, SuggestTheNearest) {
  const std::vector<std::string> names = {"Width",    "Height",       "ExposureTime", "ExposureAuto",
                                          "GainAuto", "ExposureMode", "Gain",         "OffsetX"};
  EXPECT_EQ(NearestNames("ExposureTim", names).front(), "ExposureTime");
  EXPECT_EQ(NearestNames("gain", names).front(), "Gain");
  EXPECT_EQ(NearestNames("Widht", names).front(), "Width");
  EXPECT_EQ(NearestNames("XOffset", names).front(), "OffsetX");
  EXPECT_THAT(NearestNames("exposure", names),
              ::testing::UnorderedElementsAre("ExposureTime", "ExposureAuto", "ExposureMode"));
}

class Features : public CameraInNamespace {};

TEST_F(Features, TheTreeTellsWhatTheCameraTells) {
  StartFullCamera();
  const auto access = OpenFeatures(kUri);
  EXPECT_EQ(access->Info().serial, "F1");
  const std::vector<CameraFeature> list = access->List();
  std::map<std::string, CameraFeature> tree;
  for (const CameraFeature& feature : list) tree[feature.name] = feature;
  ASSERT_EQ(tree.size(), list.size()) << "none twice";
  EXPECT_EQ(tree.size(), 36u);

  const CameraFeature& exposure = tree.at("ExposureTime");
  EXPECT_EQ(exposure.category, "AcquisitionControl");
  EXPECT_EQ(exposure.type, FeatureType::kFloat);
  EXPECT_EQ(exposure.min, 10);
  EXPECT_EQ(exposure.max, 1e6);
  EXPECT_EQ(exposure.unit, "us");
  EXPECT_EQ(exposure.description, "How long the sensor gathers light.") << "on one line";
  EXPECT_TRUE(exposure.readable && exposure.writable && exposure.streamable);
  EXPECT_EQ(RangeText(exposure), "10 to 1000000 us");
  EXPECT_EQ(tree.at("Width").step, 4);
  EXPECT_EQ(tree.at("SensorWidth").value, "2048");
  EXPECT_FALSE(tree.at("SensorWidth").writable);
  EXPECT_FALSE(tree.at("SensorWidth").streamable);
  EXPECT_FALSE(tree.at("AcquisitionMode").streamable) << "where a description marks some, the others are not";
  EXPECT_THAT(tree.at("PixelFormat").choices, ElementsAre("Mono8", "BayerRG8", "RGB8"));
  EXPECT_THAT(tree.at("TriggerSelector").selects, ElementsAre("TriggerMode", "TriggerSource"));
  EXPECT_EQ(tree.at("TriggerSoftware").type, FeatureType::kCommand);
  EXPECT_FALSE(tree.at("TriggerSoftware").readable);
  EXPECT_EQ(tree.at("ChunkModeActive").type, FeatureType::kBoolean);
  EXPECT_EQ(tree.at("BlackLevel").visibility, FeatureVisibility::kExpert);
  EXPECT_EQ(tree.at("ChunkModeActive").visibility, FeatureVisibility::kGuru);
  EXPECT_EQ(tree.at("UserSetLoaded").visibility, FeatureVisibility::kInvisible);
  EXPECT_EQ(tree.at("DeviceUserID").type, FeatureType::kString);
}

TEST_F(Features, RangesAndLocksFollowOtherSettings) {
  StartFullCamera();
  const auto access = OpenFeatures(kUri);
  access->Set("Width", "1024");
  EXPECT_EQ(access->Find("OffsetX")->max, 1024);
  access->Set("BinningHorizontal", "2");
  EXPECT_EQ(access->Find("OffsetX")->max, 0);
  access->Set("DeviceUserID", "left");
  EXPECT_EQ(access->Find("DeviceUserID")->value, "left");
  access->Set("ChunkModeActive", "on");
  EXPECT_EQ(access->Find("ChunkModeActive")->value, "true");
  access->Set("ExposureTime", "5000");
  EXPECT_EQ(access->Find("AcquisitionFrameRate")->max, 200);
  access->Set("ExposureAuto", "Continuous");
  EXPECT_FALSE(access->Find("ExposureTime")->writable);
  EXPECT_THROW(access->Set("ExposureTime", "4000"), Refusal);
  EXPECT_FALSE(access->Find("Exposure"));
}

TEST_F(Features, TheCommandSetsShowsAndRefuses) {
  StartFullCamera();
  const std::string command = std::string("features ") + kUri;
  EXPECT_THAT(RunUlf(command).output, AllOf(HasSubstr("AcquisitionControl"), HasSubstr("ExposureTime")));
  const auto set = RunUlf(command + " ExposureTime=2500 Gain=6");
  EXPECT_EQ(set.exit_code, 0);
  EXPECT_THAT(set.output, AllOf(HasSubstr("ExposureTime = 2500"), HasSubstr("Gain = 6")));
  const auto shown = RunUlf(command + " ExposureTime");
  EXPECT_THAT(shown.output, AllOf(HasSubstr("2500 us"), HasSubstr("gathers light")));
  EXPECT_THAT(RunUlf(command + " --filter balance").output,
              AllOf(HasSubstr("BalanceRatio"), Not(HasSubstr("ExposureTime"))));
  EXPECT_THAT(RunUlf(command + " --visibility beginner").output,
              AllOf(HasSubstr("ExposureTime"), Not(HasSubstr("BlackLevel"))));

  const auto unknown = RunUlf(command + " Gain=3 ExposureTme=3");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, AllOf(HasSubstr("'ExposureTme'"), HasSubstr("ExposureTime")));
  EXPECT_THAT(RunUlf(command + " Gain").output, HasSubstr("6 dB"))
      << "nothing was set beside an unknown name";
  // What cannot be set is no help to who wants to set; to who wants to see it is.
  EXPECT_THAT(RunUlf(command + " SensorWidt=3").errors, Not(HasSubstr("SensorWidth")));
  EXPECT_THAT(RunUlf(command + " SensorWidt").errors, HasSubstr("SensorWidth"));
  EXPECT_THAT(RunUlf(command).output, AllOf(HasSubstr("BayerRG8"), HasSubstr("up to 2048x2048")));
  const auto read_only = RunUlf(command + " SensorWidth=3");
  EXPECT_EQ(read_only.exit_code, 2);
  EXPECT_THAT(read_only.errors, AllOf(HasSubstr("read-only"), HasSubstr("Width")));
  // Neither is what stands before it set, but what one before it frees can be.
  EXPECT_EQ(RunUlf(command + " Gain=3 SensorWidth=3").exit_code, 2);
  EXPECT_THAT(RunUlf(command + " Gain").output, HasSubstr("6 dB"));
  EXPECT_EQ(RunUlf(command + " ExposureAuto=Continuous").exit_code, 0);
  const auto locked = RunUlf(command + " Gain=3 ExposureTime=2000");
  EXPECT_EQ(locked.exit_code, 2);
  EXPECT_THAT(locked.errors, AllOf(HasSubstr("locked"), HasSubstr("already set: Gain=3")));
  EXPECT_EQ(RunUlf(command + " ExposureAuto=Off ExposureTime=2000 Gain=6").exit_code, 0);
  const auto range = RunUlf(command + " Gain=99");
  EXPECT_EQ(range.exit_code, 2);
  EXPECT_THAT(range.errors, HasSubstr("0 to 24 dB"));
  EXPECT_EQ(RunUlf("features sim:studio").exit_code, 2);

  const auto json = JsonFromText(RunUlf(command + " ExposureTime Width=640 --json").output);
  EXPECT_EQ(json.at("features").size(), 1u);
  EXPECT_EQ(json.at("features").at(0).at("unit"), "us");
  EXPECT_EQ(json.at("set").at(0).at("value"), "640");
  EXPECT_EQ(json.at("device").at("serial"), "F1");
}

// Two states of the camera between which no single order of writing leads.
void SetAll(FeatureAccess& access, const std::vector<std::pair<std::string, std::string>>& values) {
  for (const auto& [name, value] : values) access.Set(name, value);
}

TEST_F(Features, FileRestoresDependentSettings) {
  StartFullCamera();
  const ScratchFolder scratch;
  const auto access = OpenFeatures(kUri);
  SetAll(*access, {{"OffsetX", "0"},
                   {"Width", "1000"},
                   {"OffsetX", "1048"},
                   {"ExposureTime", "500000"},
                   {"AcquisitionFrameRate", "1.5"},
                   {"Gain", "3.5"},
                   {"TriggerSelector", "FrameStart"},
                   {"TriggerMode", "On"},
                   {"TriggerSource", "Software"},
                   {"TriggerSelector", "AcquisitionStart"},
                   {"TriggerMode", "Off"},
                   {"TriggerSource", "Line0"},
                   {"BalanceRatioSelector", "Red"},
                   {"BalanceRatio", "1.5"},
                   {"BalanceRatioSelector", "Green"},
                   {"BalanceRatio", "1"},
                   {"BalanceRatioSelector", "Blue"},
                   {"BalanceRatio", "2.5"}});
  const FeatureFile slow = CollectFeatures(*access);
  EXPECT_EQ(access->Find("BalanceRatioSelector")->value, "Blue") << "collecting puts selectors back";
  WriteFeatureFile(scratch / "slow.json", slow);
  std::vector<std::string> names;
  for (const SavedFeature& saved : slow.features) names.push_back(saved.Text());
  EXPECT_THAT(names, AllOf(Contains("TriggerMode[TriggerSelector=FrameStart]"),
                           Contains("TriggerMode[TriggerSelector=AcquisitionStart]"),
                           Contains("BalanceRatio[BalanceRatioSelector=Green]"), Contains("ExposureTime")));
  EXPECT_THAT(names, AllOf(Not(Contains("SensorWidth")), Not(Contains("TriggerSoftware")),
                           Not(Contains("AcquisitionMode"))))
      << "read-only, a command, not for keeping";

  SetAll(*access, {{"OffsetX", "0"},
                   {"Width", "2048"},
                   {"ExposureTime", "1000"},
                   {"AcquisitionFrameRate", "900"},
                   {"Gain", "0"},
                   {"TriggerMode", "On"},
                   {"TriggerSelector", "FrameStart"},
                   {"TriggerMode", "Off"},
                   {"BalanceRatio", "1"},
                   {"BalanceRatioSelector", "Red"},
                   {"BalanceRatio", "3"}});
  const FeatureFile fast = CollectFeatures(*access);

  const FeatureLoadSummary to_slow = ApplyFeatures(ReadFeatureFile(scratch / "slow.json"), *access);
  EXPECT_THAT(to_slow.refused, IsEmpty());
  EXPECT_EQ(to_slow.taken, slow.features.size());
  EXPECT_EQ(access->Find("Width")->value, "1000");
  EXPECT_EQ(access->Find("OffsetX")->value, "1048");
  EXPECT_EQ(access->Find("ExposureTime")->value, "500000");
  EXPECT_EQ(access->Find("BalanceRatioSelector")->value, "Blue") << "as it was when it was saved";
  EXPECT_EQ(access->Find("BalanceRatio")->value, "2.5");
  EXPECT_EQ(access->Find("TriggerSelector")->value, "AcquisitionStart");
  EXPECT_EQ(access->Find("TriggerMode")->value, "Off");
  access->Set("TriggerSelector", "FrameStart");
  EXPECT_EQ(access->Find("TriggerMode")->value, "On");

  // The width waits for the offset, the rate for the exposure, and both stand before them in the file.
  const FeatureLoadSummary to_fast = ApplyFeatures(fast, *access);
  EXPECT_THAT(to_fast.refused, IsEmpty());
  EXPECT_GE(to_fast.rounds, 3);
  EXPECT_EQ(access->Find("Width")->value, "2048");
  EXPECT_NEAR(std::stod(access->Find("AcquisitionFrameRate")->value), 900, 1);
  EXPECT_EQ(ApplyFeatures(fast, *access).changed, 0u) << "already so";
}

TEST_F(Features, ReportsWhatAFileCouldNotSet) {
  StartFullCamera();
  const ScratchFolder scratch;
  WriteFileAtomically(scratch / "other.json", R"({"format": "ulf-features", "version": 1,
    "device": {"maker": "Other", "model": "Else", "serial": "9", "bus": "USB3Vision"}, "features": [
      {"name": "ExposureTime", "value": "2000"}, {"name": "SharpnessRaw", "value": "3"},
      {"name": "Gain", "value": "80"}, {"name": "SensorWidth", "value": "1"}]})");
  const auto result =
      RunUlf(std::string("features ") + kUri + " --json --load '" + (scratch / "other.json").string() + "'");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("Other Else")) << "another model is told";
  const auto load = JsonFromText(result.output).at("load");
  EXPECT_EQ(load.at("taken"), 1);
  ASSERT_EQ(load.at("refused").size(), 3u);
  EXPECT_EQ(load.at("refused").at(0).at("name"), "SharpnessRaw");
  EXPECT_THAT(load.at("refused").at(1).at("reason").get<std::string>(), HasSubstr("0 to 24"));
  EXPECT_EQ(load.at("refused").at(2).at("reads"), "2048");
  EXPECT_EQ(OpenFeatures(kUri)->Find("ExposureTime")->value, "2000");

  for (const char* bad : {"{", "[]", R"({"format": "ulf-features"})",
                          R"({"format": "ulf-features", "version": 1, "features": [{"name": "Gain"}]})"}) {
    WriteFileAtomically(scratch / "bad.json", bad);
    const auto refused =
        RunUlf(std::string("features ") + kUri + " --load '" + (scratch / "bad.json").string() + "'");
    EXPECT_EQ(refused.exit_code, 1) << bad;
    EXPECT_THAT(refused.errors, HasSubstr("bad.json")) << bad;
  }
}

TEST_F(Features, ACameraAtWorkCanBeReadNotSet) {
  StartFullCamera();
  const auto device = OpenDevice("aravis:127.0.0.1?gain_db=4&roi=64x64+0+0&fps=20");
  device->Start();
  Take(*device, 3);
  const auto access = OpenFeatures(kUri);
  EXPECT_EQ(access->Find("Gain")->value, "4");
  EXPECT_THAT([&] { access->Set("Gain", "5"); },
              testing::ThrowsMessage<Error>(AllOf(HasSubstr("another program"), HasSubstr("45678"))));
  EXPECT_EQ(access->Find("Gain")->value, "4");
  EXPECT_EQ(Take(*device, 3).size(), 3u) << "undisturbed";
}

// Every category's features that are values or commands must be listed, and nothing that the file does not
// name.
void ExpectWholeTree(const std::filesystem::path& description) {
  const std::string xml = ReadWholeFile(description);
  const auto all = [&](const std::regex& pattern) {
    std::set<std::string> found;
    for (auto i = std::sregex_iterator(xml.begin(), xml.end(), pattern); i != std::sregex_iterator(); ++i)
      found.insert((*i)[1]);
    return found;
  };
  const std::set<std::string> named = all(std::regex("Name=\"([A-Za-z0-9_]+)\""));
  const std::set<std::string> categories = all(std::regex("<Category[^>]*Name=\"([A-Za-z0-9_]+)\""));
  const std::set<std::string> in_categories = all(std::regex("<pFeature>([A-Za-z0-9_]+)</pFeature>"));
  const auto access = OpenFeatures(kUri);
  std::set<std::string> listed;
  for (const CameraFeature& feature : access->List()) {
    EXPECT_TRUE(named.count(feature.name)) << feature.name;
    EXPECT_TRUE(listed.insert(feature.name).second) << feature.name << " twice";
    EXPECT_EQ(feature.type == FeatureType::kEnumeration && feature.readable && feature.choices.empty(), false)
        << feature.name;
  }
  for (const std::string& name : in_categories)
    if (named.count(name) && !categories.count(name)) {
      EXPECT_TRUE(listed.count(name)) << name;
    }
}

TEST_F(Features, DescriptionsByOthersAreReadWhole) {
  ULF_NEED_TEST_DATA(folder, "genicam_xml");
  for (const char* name : {"src/arv-fake-camera.xml", "src/arv-v4l2.xml", "src/arv-gev-bootstrap.xml",
                           "tests/data/genicam.xml"}) {
    SCOPED_TRACE(name);
    StartCamera("X1", "0", "127.0.0.1", folder / name);
    ExpectWholeTree(folder / name);
  }
}

TEST_F(Features, OurOwnDescriptionIsReadWhole) {
  StartFullCamera();
  ExpectWholeTree(FULL_CAMERA);
}

}  // namespace
}  // namespace ulf::test::camera_features_test
