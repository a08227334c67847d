// The floors of docs/architecture.md: an include may go down, never up. Read from the sources' #include
// lines.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// What each folder may include of ours.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"acquisition", {"acquisition"}},
    {"tracking", {"acquisition", "tracking"}},
    {"render", {"acquisition", "render"}},
    {"coverage", {"acquisition", "tracking", "render", "coverage"}},
};

// Files that can be read and tested without the folders that their own may include: by stem.
const std::map<std::string, std::set<std::string>> kStricter = {
    {"coverage/criterion", {"acquisition", "coverage/criterion"}},
    {"coverage/coverage_map", {"acquisition", "coverage/criterion", "coverage/coverage_map"}},
};

// An outside library has few includers: header prefix, and the stems that may include it.
const std::map<std::string, std::set<std::string>> kOutside = {
    {"opengv/", {"tracking/opengv_bridge"}},
    {"arv.h", {"acquisition/aravis/aravis_calls", "acquisition/simulator/simulated_gige_camera"}},
    {"acquisition/aravis/aravis_calls.h",
     {"acquisition/aravis/aravis_configuration", "acquisition/aravis/aravis_device",
      "acquisition/aravis/aravis_discovery", "acquisition/aravis/aravis_features",
      "acquisition/aravis/aravis_frames", "acquisition/aravis/aravis_session",
      "acquisition/aravis/aravis_stream"}},
    {"acquisition/gphoto2/gphoto_camera.h",
     {"acquisition/gphoto2/camera_settings", "acquisition/gphoto2/capture_target",
      "acquisition/gphoto2/gphoto_camera", "acquisition/gphoto2/gphoto_device",
      "acquisition/gphoto2/gphoto_features", "acquisition/gphoto2/gphoto_options",
      "acquisition/gphoto2/photograph_downloads"}},
    {"GLFW/", {"render/display/surface"}},
    {"X11/", {"render/display/surface"}},
    {"imgui.h", {"render/display/painter"}},
    {"backends/imgui_", {"render/display/painter"}},
    {"CGAL/",
     {"render/spherical_delaunay", "render/planar_delaunay", "render/stereo/tetrahedra",
      "render/visible_points"}},
};

std::string Stem(const std::string& path) { return path.substr(0, path.rfind('.')); }
std::string Folder(const std::string& path) { return path.substr(0, path.find('/')); }

// "tracking" lets in all of the folder, "coverage/criterion" one pair of header and source.
bool Within(const std::string& path, const std::set<std::string>& places) {
  return std::any_of(places.begin(), places.end(), [&](const std::string& place) {
    return place.find('/') == std::string::npos ? Folder(path) == place : Stem(path) == place;
  });
}

std::vector<std::string> Violations(const fs::path& root) {
  static const std::regex include_line(R"(^\s*#\s*include\s*(["<])([^">]+)[">])");
  std::vector<std::string> found;
  for (const auto& [folder, allowed] : kMayInclude) {
    if (!fs::is_directory(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      const std::string path = fs::relative(entry.path(), root).generic_string();
      const auto stricter = kStricter.find(Stem(path));
      const auto& mine = stricter != kStricter.end() ? stricter->second : allowed;
      std::ifstream file(entry.path());
      std::smatch match;
      for (std::string line; std::getline(file, line);) {
        if (!std::regex_search(line, match, include_line)) continue;
        const std::string included = match[2];
        const bool ours = kMayInclude.count(Folder(included)) > 0 && included.find('/') != std::string::npos;
        if (ours && !Within(included, mine)) found.push_back(path + " includes " + included);
        if (Folder(included) == "tests") found.push_back(path + " includes " + included);
        for (const auto& [prefix, includers] : kOutside)
          if (included.rfind(prefix, 0) == 0 && !includers.count(Stem(path)))
            found.push_back(path + " includes " + included);
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

fs::path Checkout() { return CHECKOUT; }

void Plant(const fs::path& root, const std::string& path, const std::string& text) {
  fs::create_directories((root / path).parent_path());
  std::ofstream(root / path) << text;
}

TEST(Layering, NoIncludeClimbsAFloor) { EXPECT_THAT(Violations(Checkout()), IsEmpty()); }

TEST(Layering, LooksAtTheSources) {
  // A checker that reads nothing passes everything.
  ASSERT_TRUE(fs::exists(Checkout() / "coverage" / "criterion.cpp"));
  for (const auto& [folder, allowed] : kMayInclude)
    EXPECT_TRUE(fs::is_directory(Checkout() / folder)) << folder;
}

TEST(Layering, FindsAPlantedClimb) {
  struct Case {
    std::string path, text;
    bool climbs;
  };
  for (const Case& c : {
           Case{"acquisition/a.cpp", "#include \"tracking/tracker.h\"\n", true},
           Case{"acquisition/simulator/a.h", "  #  include \"coverage/criterion.h\"\n", true},
           Case{"tracking/a.cpp", "#include \"render/proxy.h\"\n", true},
           Case{"tracking/a.cpp", "#include \"acquisition/frame.h\"\n#include \"tracking/map.h\"\n", false},
           Case{"render/a.h", "// essay\n#include \"tracking/map.h\"\n", true},
           Case{"render/a.h", "#include \"coverage/criterion.h\"\n", true},
           Case{"coverage/a.cpp", "#include \"tracking/tracker.h\"\n#include \"render/proxy.h\"\n", false},
           Case{"coverage/criterion.cpp", "#include \"tracking/tracker.h\"\n", true},
           Case{"coverage/criterion.h", "#include \"acquisition/rigid3.h\"\n", false},
           Case{"coverage/coverage_map.cpp", "#include \"render/viewpoint_mesh.h\"\n", true},
           Case{"coverage/coverage_map.cpp", "#include \"coverage/capture_session.h\"\n", true},
           Case{"coverage/coverage_map.cpp", "#include \"coverage/criterion.h\"\n", false},
           Case{"coverage/operator/a.cpp", "#include <arv.h>\n", true},
           Case{"coverage/operator/operator_display.cpp", "#include <imgui.h>\n", true},
           Case{"render/display/painter.cpp", "#include <imgui.h>\n", false},
           Case{"render/gl_context.cpp", "#include <GLFW/glfw3.h>\n", true},
           Case{"tracking/relative_pose.cpp", "#include <opengv/types.hpp>\n", true},
           Case{"tracking/opengv_bridge.cpp", "#include <opengv/types.hpp>\n", false},
           Case{"render/loop_subdivision.cpp", "#include <CGAL/Delaunay_triangulation_on_sphere_2.h>\n",
                true},
           Case{"acquisition/aravis/aravis_calls.h", "#include <arv.h>\n", false},
           Case{"acquisition/replay_device.cpp", "#include \"acquisition/aravis/aravis_calls.h\"\n", true},
           Case{"render/a.cpp", "#include \"tests/support/test_paths.h\"\n", true},
           Case{"render/a.txt", "#include \"tracking/map.h\"\n", false},
       }) {
    const ScratchFolder scratch;
    Plant(scratch.path(), c.path, c.text);
    EXPECT_EQ(!Violations(scratch.path()).empty(), c.climbs) << c.path << ": " << c.text;
  }
}

TEST(Layering, NamesFileAndInclude) {
  const ScratchFolder scratch;
  Plant(scratch.path(), "render/a.h", "#include \"tracking/map.h\"\n");
  EXPECT_THAT(Violations(scratch.path()), ElementsAre("render/a.h includes tracking/map.h"));
}

}  // namespace
}  // namespace ulf::test
