// The house as docs/architecture.md describes it, held against the sources: its tables say who may include
// whom and which outside library has which room. Planted violations show that each rule can fail.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr std::size_t kMostInAFolder = 25;

fs::path Checkout() { return CHECKOUT; }

// ---- The page ----

std::vector<std::string> Quoted(const std::string& text) {
  static const std::regex quoted("`([^`]+)`");
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), quoted), end; it != end; ++it)
    found.push_back((*it)[1]);
  return found;
}

// Cells of the rows under the table head that begins with `head`; the rows are taken out of the page.
std::vector<std::vector<std::string>> TakeTable(std::string& page, const std::string& head) {
  const std::size_t begin = page.find("\n| " + head + " |");
  if (begin == std::string::npos) return {};
  std::size_t end = begin + 1;
  std::vector<std::vector<std::string>> rows;
  for (int line = 0; page[end] == '|'; ++line) {
    const std::size_t next = std::min(page.find('\n', end), page.size());
    std::vector<std::string> cells;
    for (std::size_t bar = end; bar + 1 < next;) {
      const std::size_t other = std::min(page.find('|', bar + 1), next);
      cells.push_back(page.substr(bar + 1, other - bar - 1));
      bar = other;
    }
    if (line >= 2) rows.push_back(cells);  // below the head and its rule
    end = std::min(next + 1, page.size());
  }
  page.erase(begin, end - begin);
  return rows;
}

// A place is a folder ("render/gl/") or one file, or header and source, by its path without ending.
bool Within(const std::string& path, const std::string& place) {
  if (place.ends_with('/')) return path.starts_with(place);
  return path == place || path.substr(0, path.rfind('.')) == place;
}

bool Within(const std::string& path, const std::vector<std::string>& places) {
  return std::any_of(places.begin(), places.end(),
                     [&](const std::string& place) { return Within(path, place); });
}

// A floor, or a room of one.
struct Floor {
  std::string place;
  std::vector<std::string> may_include;  // itself among them
};

struct Library {
  std::vector<std::string> headers;  // what their names begin with
  std::vector<std::string> room;
};

// A place of the table of rooms is written from its floor on: `gl/` in `render/`.
struct House {
  std::vector<Floor> floors, rooms;
  std::vector<Library> libraries;
  std::string prose;  // the page without the tables that are read

  static House Read(std::string page) {
    House house;
    for (const auto& row : TakeTable(page, "floor")) {
      if (row.size() < 3 || Quoted(row[1]).size() != 1) continue;
      Floor floor{Quoted(row[1])[0], Quoted(row[2])};
      floor.may_include.push_back(floor.place);
      house.floors.push_back(floor);
    }
    for (auto rows = TakeTable(page, "room"); !rows.empty(); rows = TakeTable(page, "room"))
      for (const auto& row : rows) house.AddRoom(row);
    for (const auto& row : TakeTable(page, "library"))
      if (row.size() >= 3) house.libraries.push_back({Quoted(row[1]), Quoted(row[2])});
    house.prose = page;
    return house;
  }

  void AddRoom(const std::vector<std::string>& row) {
    if (row.size() < 3 || Quoted(row[0]).size() != 1) return;
    Floor room{Quoted(row[0])[0], {}};
    const std::string floor = room.place.substr(0, room.place.find('/') + 1);
    for (const std::string& name : Quoted(row[1])) room.may_include.push_back(floor + name);
    room.may_include.push_back(room.place);
    rooms.push_back(room);
  }

  const Floor* FloorOf(const std::string& path) const { return Innermost(floors, path); }
  const Floor* RoomOf(const std::string& path) const { return Innermost(rooms, path); }

  // A file may include what its floor may. What stands on its own floor must also stand in a room that its
  // own room names; a room within that room counts as another.
  bool MayInclude(const std::string& path, const std::string& included) const {
    const Floor* floor = FloorOf(path);
    if (!FloorOf(included)) return true;
    if (!Within(included, floor->may_include)) return false;
    const Floor *own = RoomOf(path), *other = RoomOf(included);
    if (!own || !Within(included, floor->place)) return true;
    return std::any_of(own->may_include.begin(), own->may_include.end(), [&](const std::string& place) {
      return place.ends_with('/') ? other && other->place == place : Within(included, place);
    });
  }

 private:
  static const Floor* Innermost(const std::vector<Floor>& places, const std::string& path) {
    const Floor* found = nullptr;
    for (const Floor& floor : places)
      if (Within(path, floor.place) && (!found || floor.place.size() > found->place.size())) found = &floor;
    return found;
  }
};

// ---- The tree ----

bool IsSource(const fs::path& path) {
  static const std::set<std::string> kEndings{".h",   ".hh", ".hpp", ".hxx", ".inc",
                                              ".inl", ".c",  ".cc",  ".cpp", ".cxx"};
  return kEndings.contains(path.extension());
}

// Files relative to the root, but for what is built, hidden or shared.
std::vector<std::string> FilesUnder(const fs::path& root) {
  static const std::set<std::string> kNotOurs{"build", "demo", "shared"};
  std::vector<std::string> found;
  for (const auto& top : fs::directory_iterator(root)) {
    const std::string name = top.path().filename();
    if (name.starts_with('.') || kNotOurs.count(name)) continue;
    if (!top.is_directory()) {
      found.push_back(name);
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(top))
      if (entry.is_regular_file()) found.push_back(entry.path().lexically_relative(root).generic_string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Tests and examples call everything.
bool IsNoFloor(const std::string& path) {
  return path.starts_with("tests/") || path.starts_with("examples/");
}

std::vector<std::string> IncludeFaults(const fs::path& root, const House& house) {
  static const std::regex any_include(R"(^\s*#\s*include\b)");
  static const std::regex include_line(R"(^\s*#\s*include\s*(["<])([^">]+)[">])");
  std::vector<std::string> found;
  const std::vector<std::string> files = FilesUnder(root);
  for (const std::string& path : files) {
    if (!IsSource(path) || IsNoFloor(path)) continue;
    const Floor* floor = house.FloorOf(path);
    if (!floor) {
      found.push_back(path + " stands on no floor");
      continue;
    }
    std::ifstream file(root / path);
    std::smatch match;
    for (std::string line; std::getline(file, line);) {
      if (!std::regex_search(line, any_include)) continue;
      if (!std::regex_search(line, match, include_line)) {
        found.push_back(path + " includes what a macro names");
        continue;
      }
      const std::string included = match[2];
      bool wrong = included.starts_with("tests/") || !house.MayInclude(path, included);
      // A quoted name is a path from the root: any other way round ("../", the folder itself)
      // hides the floor.
      if (match[1] == "\"")
        wrong |= !house.FloorOf(included) || fs::path(included).lexically_normal() != fs::path(included);
      for (const Library& library : house.libraries)
        for (const std::string& header : library.headers)
          if (included.starts_with(header) && !Within(path, library.room)) wrong = true;
      if (wrong) found.push_back(path + " includes " + included);
    }
  }
  return found;
}

// Folders with sources that have no row of their own, and rooms that name one which stands after them.
std::vector<std::string> RoomFaults(const fs::path& root, const House& house) {
  std::set<std::string> folders;
  for (const std::string& path : FilesUnder(root))
    if (IsSource(path) && house.FloorOf(path) && path.find('/') != std::string::npos)
      folders.insert(fs::path(path).parent_path().generic_string() + "/");
  std::vector<std::string> found;
  for (const std::string& folder : folders)
    if (!house.RoomOf(folder) || house.RoomOf(folder)->place != folder)
      found.push_back(folder + " has no row");
  std::set<std::string> before;
  for (const Floor& room : house.rooms) {
    before.insert(room.place);
    for (const std::string& place : room.may_include)
      if (!before.contains(place.substr(0, place.rfind('/') + 1)))
        found.push_back(room.place + " names " + place + ", which stands after it");
  }
  return found;
}

// Header and source count as one file.
std::vector<std::string> CirclesOfFiles(const fs::path& root) {
  static const std::regex quoted_include("^#include \"([^\"]+)\\.h\"");
  std::map<std::string, std::set<std::string>> includes;
  for (const std::string& path : FilesUnder(root)) {
    if (!IsSource(path) || IsNoFloor(path)) continue;
    const std::string unit = path.substr(0, path.rfind('.'));
    std::ifstream file(root / path);
    std::smatch match;
    for (std::string line; std::getline(file, line);)
      if (std::regex_search(line, match, quoted_include) && match[1] != unit) includes[unit].insert(match[1]);
  }
  // Whoever includes nothing that is left, or is included by nothing that is left, is in no circle.
  for (bool taken = true; taken;) {
    taken = false;
    std::set<std::string> included;
    for (const auto& [unit, others] : includes) included.insert(others.begin(), others.end());
    for (auto it = includes.begin(); it != includes.end();) {
      std::erase_if(it->second, [&](const std::string& other) { return !includes.contains(other); });
      const bool free = it->second.empty() || !included.contains(it->first);
      taken |= free;
      it = free ? includes.erase(it) : std::next(it);
    }
  }
  std::vector<std::string> found;
  for (const auto& [unit, others] : includes) found.push_back(unit);
  return found;
}

// Texts of a source with options of the command line ("--poses", "-o"), but for whole command lines ("ulf
// refine DIR --intrinsics"), which no quotation mark or full stop interrupts. Literals that follow each other
// are one text.
std::vector<std::string> OptionsIn(const std::string& source) {
  std::vector<std::string> texts(1);
  bool joined = false;  // nothing but white space since the last literal
  for (std::size_t at = 0; at < source.size(); ++at) {
    if (source.compare(at, 2, "//") == 0) {
      at = std::min(source.find('\n', at), source.size());
    } else if (source[at] == '\'' && at + 2 < source.size() && !std::isalnum(at ? source[at - 1] : ' ')) {
      at = std::min(source.find('\'', at + (source[at + 1] == '\\' ? 3 : 2)), source.size());
      joined = false;
    } else if (source[at] == '"') {
      if (!joined) texts.emplace_back();
      for (++at; at < source.size() && source[at] != '"'; ++at) {
        if (source[at] == '\\') ++at;
        texts.back() += source[at];
      }
      joined = true;
    } else if (!std::isspace(static_cast<unsigned char>(source[at]))) {
      joined = false;
    }
  }
  static const std::regex option("(^|[^-\\w])--[a-z]|(^|[ (])-[a-z]\\b"),
      command_line(
          "((ulf|udevadm|ros2|colmap) [a-z_]+|ffmpeg|fuser|gio mount|ptp4l)"
          "(([^;.']|'\\{\\}'|\\.\\w)*? --?[a-z][-a-z_]*)+");
  std::vector<std::string> found;
  for (const std::string& text : texts)
    if (std::regex_search(std::regex_replace(text, command_line, ""), option)) found.push_back(text);
  return found;
}

// A folder's names stand in a namespace of the folder's name, what all share (`core/`) in `ulf` itself.
std::vector<std::string> NamespaceFaults(const fs::path& root) {
  static const std::regex opens(R"(^namespace (ulf[a-z_:]*) \{$)");
  static const std::regex declares(
      R"(^((class|struct|enum class) [\w:]+( : [\w:]+)?;( *//.*)?|extern .*[;{]|namespace [A-Z]\w* \{|//.*|\}.*|\s*#.*)?$)");
  std::vector<std::string> found;
  for (const std::string& path : FilesUnder(root)) {
    const std::size_t slash = path.find('/');
    if (!IsSource(path) || slash == std::string::npos || IsNoFloor(path)) continue;
    const std::string folder = path.substr(0, slash);
    const std::string own = folder == "core" ? "ulf" : "ulf::" + folder;
    std::ifstream file(root / path);
    std::smatch match;
    bool elsewhere = true;  // where only types may be declared
    std::string before;
    for (std::string line; std::getline(file, line); before = line) {
      if (before.ends_with('\\')) continue;  // a macro goes on
      if (std::regex_match(line, match, opens))
        elsewhere = match[1] != own && match[1] != own + "::ply" && match[1] != own + "::gvcp";
      else if (elsewhere && !std::regex_match(line, declares)) {
        found.push_back(path + " defines something outside " + own);
        break;
      }
      if (line.starts_with("}  // namespace ulf")) elsewhere = true;
    }
  }
  return found;
}

std::vector<std::string> CrowdedFolders(const fs::path& root) {
  std::map<std::string, std::set<std::string>> units;
  for (const std::string& path : FilesUnder(root))
    if (IsSource(path)) units[fs::path(path).parent_path()].insert(fs::path(path).stem());
  std::vector<std::string> found;
  for (const auto& [folder, names] : units)
    if (names.size() > kMostInAFolder)
      found.push_back(folder + "/ holds " + std::to_string(names.size()) + " files side by side");
  return found;
}

// What looks like a name of ours and is none: of frames and suffixes, the program, files of a light field,
// data sets, words of CMake.
const std::set<std::string> kNoFiles = {
    "cam_from_world", "center_in_world", "_deg",       "still",          "ulf",
    "ulf_core",       "cache/pyramids",  "images",     "masks",          "masters",
    "points.ulf",     "points.ply",      "fox_half",   "shop_grid_even", "_device",
    "_options",       "_configuration",  "ulf_library"};

// Names in backticks for which there is neither a file nor a folder. A name may be the end of a path, without
// the file's ending, and have stars in it.
std::vector<std::string> NamesOfNothing(const fs::path& root, const House& house) {
  std::set<std::string> known;  // all paths, with and without their ending, and all their folders
  for (const std::string& path : FilesUnder(root)) {
    known.insert(path);
    known.insert(path.substr(0, path.rfind('.')));
    for (std::size_t slash = path.find('/'); slash != std::string::npos; slash = path.find('/', slash + 1))
      known.insert(path.substr(0, slash));
  }
  std::string all = "\n";
  for (const std::string& path : known) all += "/" + path + "\n";

  std::vector<std::string> places = Quoted(house.prose);
  for (const auto* table : {&house.floors, &house.rooms})
    for (const Floor& floor : *table)
      places.insert(places.end(), floor.may_include.begin(), floor.may_include.end());
  for (const Library& library : house.libraries)
    places.insert(places.end(), library.room.begin(), library.room.end());
  static const std::regex name_of_ours("[a-z0-9_*./]*[a-z0-9_*/]");
  std::set<std::string> found;
  for (std::string place : places) {
    if (!std::regex_match(place, name_of_ours)) continue;
    if (place.ends_with('/')) place.pop_back();
    if (kNoFiles.count(place)) continue;
    bool exists = all.find("/" + place + "\n") != std::string::npos;
    if (!exists && place.find('*') != std::string::npos) {
      std::string pattern = std::regex_replace(place, std::regex("\\."), "\\.");
      pattern = "(.*/)?" + std::regex_replace(pattern, std::regex("\\*"), "[^/]*");
      const std::regex with_stars(pattern);
      exists = std::any_of(known.begin(), known.end(),
                           [&](const std::string& path) { return std::regex_match(path, with_stars); });
    }
    if (!exists) found.insert(place);
  }
  return {found.begin(), found.end()};
}

// Of the names in backticks on any page: files of ours by their path, sources by their ending.
std::vector<std::string> FilesOfNothing(const fs::path& root, const std::string& page) {
  static const std::regex file_of_ours(
      R"(((core|acquisition|tracking|render|coverage|commands|tests|docs|udev|cmake)/[\w./]+|[\w./]+\.(h|cpp)))");
  const std::vector<std::string> files = FilesUnder(root);
  std::vector<std::string> found;
  for (const std::string& name : Quoted(page)) {
    if (!std::regex_match(name, file_of_ours)) continue;
    const std::string end = name.ends_with('/') ? name : name + ".";
    const bool exists = std::any_of(files.begin(), files.end(), [&](const std::string& file) {
      return file == name || file.starts_with(end) || file.starts_with(name + "/") ||
             file.ends_with("/" + name) || file.find("/" + end) != std::string::npos;
    });
    if (!exists) found.push_back(name);
  }
  return found;
}

// Pages, charts and sections that a source names (docs/tracking.md, "How a map starts") and that
// are not there.
std::vector<std::string> PagesOfNothing(const fs::path& root, std::string source) {
  if (source.find("docs/") == std::string::npos) return {};
  static const std::regex comment_goes_on(R"(\n\s*// ?)"), spaces(R"(\s+)");
  static const std::regex page_and_section(R"((docs/[\w/]+\.(?:md|png|svg|csv))(?:,? "([^"\\]+)\")?)");
  source = std::regex_replace(std::regex_replace(source, comment_goes_on, " "), spaces, " ");
  std::vector<std::string> found;
  for (std::sregex_iterator it(source.begin(), source.end(), page_and_section), end; it != end; ++it) {
    const std::string page = (*it)[1], section = (*it)[2];
    if (!fs::exists(root / page)) {
      found.push_back(page);
    } else if (!section.empty()) {
      const std::string text = "\n" + ReadWholeFile(root / page);
      bool exists = false;
      for (std::size_t line = text.find("\n#"); line != std::string::npos && !exists;
           line = text.find("\n#", line + 1))
        exists = text.substr(line, text.find('\n', line + 1) - line).find(section) != std::string::npos;
      if (!exists) found.push_back(page + ", \"" + section + "\"");
    }
  }
  return found;
}

House OurHouse() { return House::Read(ReadWholeFile(Checkout() / "docs" / "architecture.md")); }

void Plant(const fs::path& root, const std::string& path, const std::string& text = {}) {
  fs::create_directories((root / path).parent_path());
  std::ofstream(root / path) << text;
}

// ---- The house as it stands ----

TEST(Layering, NoIncludeClimbsAndLibrariesStayInRooms) {
  EXPECT_THAT(IncludeFaults(Checkout(), OurHouse()), IsEmpty());
}

TEST(Layering, EveryRoomHasARowAndIncludesRoomsBefore) {
  EXPECT_THAT(RoomFaults(Checkout(), OurHouse()), IsEmpty());
}

TEST(Layering, NoFilesIncludeEachOtherInACircle) { EXPECT_THAT(CirclesOfFiles(Checkout()), IsEmpty()); }

TEST(Layering, LibrariesKnowNoCommandLine) {
  for (const std::string& path : FilesUnder(Checkout())) {
    if (!IsSource(path) || IsNoFloor(path) || path.starts_with("commands/") || path == "main.cpp") continue;
    const std::string text = ReadWholeFile(Checkout() / path);
    EXPECT_THAT(OptionsIn(text), IsEmpty()) << path;
    EXPECT_EQ(text.find("UsageError"), std::string::npos) << path;
  }
}

TEST(Layering, EveryFloorHasItsNamespace) { EXPECT_THAT(NamespaceFaults(Checkout()), IsEmpty()); }

TEST(Layering, NoFolderIsCrowded) { EXPECT_THAT(CrowdedFolders(Checkout()), IsEmpty()); }

TEST(Layering, PagesNameWhatIsThere) {
  for (const char* page : {"docs/architecture.md", "CONTRIBUTING.md"})
    EXPECT_THAT(NamesOfNothing(Checkout(), House::Read(ReadWholeFile(Checkout() / page))), IsEmpty()) << page;
}

TEST(Layering, EveryPageNamesFilesThatAreThere) {
  for (const std::string& page : FilesUnder(Checkout()))
    if (page.ends_with(".md") && page != "CHANGELOG.md") {
      EXPECT_THAT(FilesOfNothing(Checkout(), House::Read(ReadWholeFile(Checkout() / page)).prose), IsEmpty())
          << page;
    }
}

TEST(Layering, SourcesNamePagesAndSectionsThatAreThere) {
  for (const std::string& source : FilesUnder(Checkout()))
    if (IsSource(source) && source != "tests/house/layering_test.cpp") {
      EXPECT_THAT(PagesOfNothing(Checkout(), ReadWholeFile(Checkout() / source)), IsEmpty()) << source;
    }
}

TEST(Layering, LooksAtTheSources) {
  // A checker that reads nothing passes everything.
  const House house = OurHouse();
  std::vector<std::string> folders;
  for (const Floor& floor : house.floors)
    if (std::count(floor.place.begin(), floor.place.end(), '/') == 1 && floor.place.ends_with('/'))
      folders.push_back(floor.place);
  EXPECT_THAT(folders, UnorderedElementsAre("core/", "acquisition/", "tracking/", "render/", "coverage/",
                                            "commands/", "python/"));
  for (const Floor& floor : house.floors)
    EXPECT_TRUE(fs::exists(Checkout() / floor.place) || fs::exists(Checkout() / (floor.place + ".h")))
        << floor.place;
  EXPECT_GE(house.libraries.size(), 15u);
  for (const char* header :
       {"opengv/", "arv.h", "CGAL/", "GLFW/", "X11/", "imgui", "Imf", "ceres/", "gphoto2/", "libusb",
        "epoxy/", "EGL/", "yaml-cpp/", "libexif/", "opencv2/aruco"})
    EXPECT_TRUE(std::any_of(house.libraries.begin(), house.libraries.end(), [&](const Library& library) {
      return std::count(library.headers.begin(), library.headers.end(), header) > 0;
    })) << header;
  EXPECT_GE(FilesUnder(Checkout()).size(), 700u);
}

// ---- Planted violations, against the page's own tables ----

TEST(Layering, FindsAPlantedClimb) {
  struct Case {
    std::string path, text;
    bool climbs;
  };
  const House house = OurHouse();
  for (const Case& c : {
           Case{"core/base/a.cpp", "#include \"acquisition/device/device.h\"\n", true},
           Case{"core/image/a.cpp", "#include \"core/base/error.h\"\n", false},
           Case{"acquisition/a.cpp", "#include \"tracking/tracker/tracker.h\"\n", true},
           Case{"acquisition/simulator/a.h", "  #  include \"coverage/bound/criterion.h\"\n", true},
           Case{"acquisition/a.cpp", "#include \"core/base/error.h\"\n", false},
           Case{"tracking/a.cpp", "#include \"render/proxy/proxy.h\"\n", true},
           Case{"tracking/a.cpp", "#include \"acquisition/device/device.h\"\n", true},
           Case{"tracking/a.cpp", "#include \"core/frames/frame.h\"\n#include \"tracking/map/map.h\"\n",
                false},
           Case{"render/a.h", "// essay\n#include \"tracking/map/map.h\"\n", true},
           Case{"render/a.h", "#include \"acquisition/simulator/simulated_camera.h\"\n", true},
           Case{"render/a.h", "#include \"coverage/bound/criterion.h\"\n", true},
           Case{"coverage/a.cpp",
                "#include \"tracking/tracker/tracker.h\"\n#include \"render/proxy/proxy.h\"\n", false},
           Case{"coverage/a.cpp", "#include \"commands/options/command_line.h\"\n", true},
           Case{"coverage/bound/criterion.cpp", "#include \"tracking/tracker/tracker.h\"\n", true},
           Case{"coverage/bound/criterion.h", "#include \"core/geometry/rigid3.h\"\n", false},
           Case{"coverage/bound/coverage_map.cpp", "#include \"render/viewpoints/viewpoint_mesh.h\"\n", true},
           Case{"coverage/bound/coverage_map.cpp", "#include \"coverage/session/capture_session.h\"\n", true},
           Case{"coverage/bound/coverage_map.cpp", "#include \"coverage/bound/criterion.h\"\n", false},
           Case{"commands/a.cpp", "#include \"coverage/bound/criterion.h\"\n", false},
           Case{"main.cpp", "#include \"commands/options/subcommands.h\"\n", false},
           Case{"main.cpp", "#include \"render/scene/scene.h\"\n", true},
           Case{"render/a.cpp", "#include \"tests/support/test_paths.h\"\n", true},
           Case{"render/a.txt", "#include \"tracking/map/map.h\"\n", false},
           Case{"render/a.inc", "#include \"tracking/map/map.h\"\n", true},
           Case{"render/a.cpp", "#include \"../tracking/map/map.h\"\n", true},
           Case{"render/a.cpp", "#include \"render/../tracking/map/map.h\"\n", true},
           Case{"tracking/map/a.cpp", "#include \"map.h\"\n", true},
           Case{"render/a.cpp", "#define MAP \"tracking/map/map.h\"\n#include MAP\n", true},
           Case{"cellar/a.cpp", "", true},
       }) {
    const ScratchFolder scratch;
    Plant(scratch.path(), c.path, c.text);
    EXPECT_EQ(!IncludeFaults(scratch.path(), house).empty(), c.climbs) << c.path << ": " << c.text;
  }
}

TEST(Layering, FindsARoomWithoutARowAndOneThatLooksAhead) {
  const House house = House::Read(
      "\n| floor | folder | may include |\n| --- | --- | --- |\n| 1 | `a/` | nothing |\n"
      "\n| room | includes | owns |\n| --- | --- | --- |\n| `a/one/` | `two/` | x |\n| `a/two/` |  | y |\n");
  const ScratchFolder scratch;
  Plant(scratch.path(), "a/one/x.h");
  Plant(scratch.path(), "a/two/deep/y.h");
  EXPECT_THAT(RoomFaults(scratch.path(), house),
              ElementsAre("a/two/deep/ has no row", "a/one/ names a/two/, which stands after it"));
  Plant(scratch.path(), "a/two/y.cpp", "#include \"a/one/x.h\"\n");
  EXPECT_THAT(IncludeFaults(scratch.path(), house), ElementsAre("a/two/y.cpp includes a/one/x.h"));
}

TEST(Layering, FindsACircleOfFiles) {
  const ScratchFolder scratch;
  Plant(scratch.path(), "a/x.h");
  Plant(scratch.path(), "a/x.cpp", "#include \"a/x.h\"\n#include \"a/y.h\"\n");
  Plant(scratch.path(), "a/y.h", "#include \"a/z.h\"\n");
  Plant(scratch.path(), "a/z.h");
  Plant(scratch.path(), "a/above.h", "#include \"a/x.h\"\n");
  EXPECT_THAT(CirclesOfFiles(scratch.path()), IsEmpty());
  Plant(scratch.path(), "a/z.cpp", "#include \"a/x.h\"\n");
  EXPECT_THAT(CirclesOfFiles(scratch.path()), ElementsAre("a/x", "a/y", "a/z"));
}

TEST(Layering, FindsAnOptionInAText) {
  EXPECT_THAT(OptionsIn("throw Error(\"--poses {}: none\");"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f(\"leave it out \"\n  \"(--poses)\")"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f('\"', \"x\", \"--a\")"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f(\"run 'ulf refine {} \"\n  \"--intrinsics', or give --poses\")"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f(\"see 'ulf devices', or leave out --poses\")"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f(\"'ulf info' shows it. Leave out --poses\")"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f(\"give another folder with -o\")"), SizeIs(1));
  EXPECT_THAT(OptionsIn("f(\"run 'ulf import a.json --camera '{}' -o {}', x - y\")"), IsEmpty());
  EXPECT_THAT(OptionsIn("// \"--poses\"\nf(\"run 'ulf refine {} \"\n  \"--intrinsics'\"); --i; a--b;"),
              IsEmpty());
}

TEST(Layering, FindsALibraryOutsideItsRoom) {
  struct Case {
    std::string header, outside, room;  // no room: it has none
  };
  const House house = OurHouse();
  for (const Case& c : {
           Case{"opengv/types.hpp", "tracking/estimation/relative_pose.cpp",
                "tracking/estimation/opengv_bridge.cpp"},
           Case{"ceres/ceres.h", "tracking/map/map.cpp", "tracking/estimation/residuals.h"},
           Case{"ImfArray.h", "render/output/picture_files.cpp", "core/image/files/exr_file.cpp"},
           Case{"libexif/exif-data.h", "acquisition/gphoto2/a.cpp", "core/image/files/exif.cpp"},
           Case{"CGAL/Delaunay_triangulation_on_sphere_2.h", "render/fields/loop_subdivision.cpp",
                "render/viewpoints/delaunay.cpp"},
           Case{"epoxy/gl.h", "render/scene/scene.cpp", "render/gl/gl_views.cpp"},
           Case{"EGL/egl.h", "tracking/map/map.cpp", "render/gl/gl_context.cpp"},
           Case{"GLFW/glfw3.h", "render/gl/gl_context.cpp", "render/display/surface.cpp"},
           Case{"X11/Xlib.h", "coverage/operator/review.cpp", "render/display/surface.cpp"},
           Case{"imgui.h", "coverage/operator/operator_display.cpp", "render/display/painter.cpp"},
           Case{"backends/imgui_impl_opengl3.h", "render/display/surface.cpp", "render/display/painter.cpp"},
           Case{"arv.h", "coverage/operator/a.cpp", "acquisition/aravis/aravis_calls.h"},
           Case{"acquisition/aravis/aravis_calls.h", "acquisition/device/replay_device.cpp",
                "acquisition/aravis/aravis_stream.cpp"},
           Case{"gphoto2/gphoto2.h", "acquisition/gphoto2/gphoto_device.cpp",
                "acquisition/gphoto2/gphoto_camera.cpp"},
           Case{"libusb-1.0/libusb.h", "acquisition/opening/open_device.cpp", ""},
           Case{"linux/videodev2.h", "acquisition/device/device.h", "acquisition/v4l2/v4l2_node.h"},
           Case{"opencv2/aruco/charuco.hpp", "tracking/sources/marker_locator.cpp",
                "core/fiducials/board.cpp"},
           Case{"yaml-cpp/yaml.h", "acquisition/calibration/intrinsics.cpp",
                "acquisition/calibration/lens_files/lens_tree.cpp"},
           Case{"CLI/CLI.hpp", "coverage/session/capture_session.h", "commands/options/option_values.h"},
       }) {
    const ScratchFolder scratch;
    Plant(scratch.path(), c.outside, "#include <" + c.header + ">\n");
    EXPECT_THAT(IncludeFaults(scratch.path(), house), ElementsAre(c.outside + " includes " + c.header));
    if (c.room.empty()) continue;
    const ScratchFolder other;
    Plant(other.path(), c.room, "#include <" + c.header + ">\n");
    EXPECT_THAT(IncludeFaults(other.path(), house), IsEmpty()) << c.header;
  }
}

TEST(Layering, FindsAForeignNamespace) {
  struct Case {
    std::string path, text;
    bool wrong;
  };
  for (const Case& c : {
           Case{"render/a.h", "namespace ulf::render {\nint A();\n}  // namespace ulf::render\n", false},
           Case{"render/a.h", "namespace ulf {\nint A();\n}  // namespace ulf\n", true},
           Case{"render/a.h", "namespace ulf {\nstruct FlatField;\n}  // namespace ulf\n", false},
           Case{"render/a.h",
                "namespace ulf::tracking {\nclass Map;\n}\nnamespace ulf::render {\nint A();\n}\n", false},
           Case{"render/a.h", "namespace ulf::tracking {\nvoid Track() {\n}\n}\n", true},
           Case{"render/a.h", "namespace ulf {\nstruct A; int B();\n}\n", true},
           Case{"render/a.h", "int A();\n", true},
           Case{"render/a.h", "#pragma once\n#define A(x) \\\n  B(x)\nstruct _ArvCamera;\n", false},
           Case{"core/base/a.h", "namespace ulf {\nint A();\n}\n", false},
           Case{"core/base/a.h", "namespace ulf::core {\nint A();\n}\n", true},
       }) {
    const ScratchFolder scratch;
    Plant(scratch.path(), c.path, c.text);
    EXPECT_EQ(!NamespaceFaults(scratch.path()).empty(), c.wrong) << c.text;
  }
}

TEST(Layering, FindsACrowdedFolder) {
  const ScratchFolder scratch;
  for (std::size_t i = 0; i < kMostInAFolder; ++i) {
    const std::string name = "render/attic/file_" + std::to_string(i);
    Plant(scratch.path(), name + ".h");
    Plant(scratch.path(), name + ".cpp");
  }
  EXPECT_THAT(CrowdedFolders(scratch.path()), IsEmpty());
  Plant(scratch.path(), "render/attic/below/one_more.h");
  EXPECT_THAT(CrowdedFolders(scratch.path()), IsEmpty());
  Plant(scratch.path(), "render/attic/one_more.h");
  EXPECT_THAT(CrowdedFolders(scratch.path()),
              ElementsAre(HasSubstr("render/attic/ holds 26 files side by side")));
}

TEST(Layering, FindsANameOfNothing) {
  const ScratchFolder scratch;
  for (const char* path :
       {"render/gl/gl_views.h", "render/gl/gl_proxy.cpp", "coverage/operator/panels.h", "main.cpp"})
    Plant(scratch.path(), path);
  const auto missing = [&](const std::string& page) {
    return NamesOfNothing(scratch.path(), House::Read(page));
  };
  EXPECT_THAT(
      missing("`render/gl/`, `render/gl/gl_views`, `gl_views.h`, `operator/panels`, `panels`, `gl_*`, "
              "`render/*/gl_p*.cpp`, `main.cpp`, `ulf render`, `Track::state`, `--json`"),
      IsEmpty());
  EXPECT_THAT(missing("`render/gl/views`, `gl_view`, `render/`, `coverage/panels`, `panels.cpp`, `rendr_*`"),
              UnorderedElementsAre("render/gl/views", "gl_view", "coverage/panels", "panels.cpp", "rendr_*"));
  EXPECT_THAT(
      missing("\n| floor | folder | may include |\n| --- | --- | --- |\n| 1 | `render/` | `cellar/` |\n"),
      ElementsAre("cellar"));
  EXPECT_THAT(missing("\n| library | headers | room |\n| --- | --- | --- |\n| A | `a.h` | `render/gl/a` |\n"),
              ElementsAre("render/gl/a"));
}

TEST(Layering, FindsAFileAPageAndASectionOfNothing) {
  const ScratchFolder scratch;
  Plant(scratch.path(), "render/gl/gl_views.h");
  Plant(scratch.path(), "docs/map.md", "# The map\n\nText of a wall.\n## How it starts\n");
  EXPECT_THAT(FilesOfNothing(scratch.path(),
                             "`render/gl/`, `render/gl/gl_views`, `gl_views.h`, `gl_views`, `a.json`"),
              IsEmpty());
  EXPECT_THAT(FilesOfNothing(scratch.path(), "`render/gl/gl_view`, `views.h`, `docs/walls.md`"),
              ElementsAre("render/gl/gl_view", "views.h", "docs/walls.md"));
  const auto pages = [&](const std::string& source) { return PagesOfNothing(scratch.path(), source); };
  EXPECT_THAT(pages("// docs/map.md, docs/map.md, \"The map\"; (docs/map.md, \"How\n  // it starts\")\n"),
              IsEmpty());
  EXPECT_THAT(pages("// docs/wall.md; docs/charts/map.png; docs/map.md, \"Text of a wall\"\n"),
              ElementsAre("docs/wall.md", "docs/charts/map.png", "docs/map.md, \"Text of a wall\""));
}

TEST(Layering, NamesFileAndInclude) {
  const ScratchFolder scratch;
  Plant(scratch.path(), "render/a.h", "#include \"tracking/map/map.h\"\n");
  EXPECT_THAT(IncludeFaults(scratch.path(), OurHouse()),
              ElementsAre("render/a.h includes tracking/map/map.h"));
}

TEST(Layering, ReadsATable) {
  std::string page =
      "# Page\n\n| floor | folder | may include |\n| --- | --- | --- |\n| 1 | `a/` | nothing |\n"
      "| 2 | `b/` | `a/` |\n\nText `c`.\n";
  const House house = House::Read(page);
  ASSERT_THAT(house.floors, SizeIs(2));
  EXPECT_THAT(house.floors[0].may_include, ElementsAre("a/"));
  EXPECT_THAT(house.floors[1].may_include, ElementsAre("a/", "b/"));
  EXPECT_THAT(house.prose, HasSubstr("Text `c`."));
  EXPECT_THAT(house.prose, testing::Not(HasSubstr("floor")));
}

}  // namespace
}  // namespace ulf::test
