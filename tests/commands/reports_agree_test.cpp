// Tests: commands/commands, commands/capture/capture_report, commands/reports/light_field_report,
// commands/light_field/info_command, commands/reports/geometry_report, commands/tracking/refine_command,
// commands/rendering/evaluate_command, commands/rendering/render_command, commands/rendering/view_command,
// commands/light_field/export_web, core/light_field/formats/transforms_json,
// core/light_field/formats/colmap_files.
//
// One owner a fact: whatever two reports tell of the same light field they tell alike. Each report is read
// into a table of facts, and every pair that tells the same fact is compared.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "tests/support/test_paths.h"

namespace ulf::test::reports_agree_test {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// What reports tell.
class Facts {
 public:
  // `within`: what rounding leaves open.
  void Number(const std::string& by, const std::string& what, double value, double within = 0) {
    told_.push_back({by, what, value, within, {}});
  }
  void Text(const std::string& by, const std::string& what, const std::string& text) {
    told_.push_back({by, what, 0, 0, text});
  }
  // Number `group` of the first place in the report that the pattern fits; it must be there.
  std::string Match(const std::string& by, const std::string& report, const std::string& pattern,
                    std::size_t group = 1) {
    std::smatch found;
    if (std::regex_search(report, found, std::regex(pattern))) return found[group];
    ADD_FAILURE() << by << " does not tell '" << pattern << "':\n" << report;
    return "";
  }
  void NumberIn(const std::string& by, const std::string& what, const std::string& report,
                const std::string& pattern, double within, double scale = 1) {
    const std::string text = Match(by, report, pattern);
    if (!text.empty()) Number(by, what, scale * std::stod(text), scale * within);
  }

  void ExpectAgreement(std::size_t least_pairs) const {
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < told_.size(); ++i)
      for (std::size_t k = i + 1; k < told_.size(); ++k) {
        const Told &a = told_[i], &b = told_[k];
        if (a.what != b.what) continue;
        ++pairs;
        if (a.text != b.text || !(std::abs(a.number - b.number) <= std::max(a.within, b.within) + 1e-9))
          ADD_FAILURE() << a.what << ": " << a.by << " tells " << a.Shown() << ", " << b.by << " tells "
                        << b.Shown();
      }
    EXPECT_GE(pairs, least_pairs) << "reports tell less than they did";
  }

 private:
  struct Told {
    std::string by, what;
    double number, within;
    std::string text;
    std::string Shown() const {
      std::ostringstream shown;
      shown.precision(10);
      if (text.empty())
        shown << number;
      else
        shown << "'" << text << "'";
      return shown.str();
    }
  };
  std::vector<Told> told_;
};

CommandResult Done(const std::string& arguments) {
  CommandResult result = RunUlf(arguments);
  EXPECT_EQ(result.exit_code, 0) << arguments << ": " << result.errors;
  return result;
}
json JsonDone(const std::string& arguments) { return JsonFromText(Done(arguments).output); }

// All that a report says of lamps that changed; "none".
std::string LampsIn(const std::string& report) {
  static const std::regex drift(
      R"(views \d+ to \d+ are \d+ % [a-z]+( green)? than views \d+ to \d+|(brightness|blue|green) [a-z ]*goes up and down by \d+ %)");
  std::string all;
  for (std::sregex_iterator at(report.begin(), report.end(), drift), end; at != end; ++at)
    all += (all.empty() ? "" : "; ") + at->str();
  return all.empty() ? "none" : all;
}

// The lines that the end of a capture and ulf info have in common.
void ReadSummary(const std::string& by, const std::string& text, Facts& facts) {
  facts.NumberIn(by, "views", text, R"((?:^|\n)views +(\d+))", 0);
  facts.NumberIn(by, "capture time", text, R"(capture time +(\d+) s)", 0.5);
  facts.NumberIn(by, "focal length", text, R"(camera +\d+ x \d+ px, focal length ([\d.]+) px)", 0.05);
  facts.Text(by, "source of the lens", facts.Match(by, text, R"(focal length [\d.]+ px \(from: (.*)\)\n)"));
  facts.NumberIn(by, "covered share", text, R"(covered +([\d.]+) %)", 0.05, 0.01);
  facts.NumberIn(by, "cap's width", text, R"(covered .*% of ([\d.]+) x [\d.]+ degrees)", 0);
  facts.NumberIn(by, "cap's height", text, R"(covered .*% of [\d.]+ x ([\d.]+) degrees)", 0);
  facts.NumberIn(by, "threshold", text, R"(covered .* within ([\d.]+) px)", 0);
  facts.NumberIn(by, "subject's radius", text, R"(subject .* radius ([\d.]+))", 0.0005);
  const std::string units = facts.Match(by, text, R"(subject .* radius [\d.]+ \((.*)\)\n)");
  facts.Text(by, "units", units == "arbitrary units" ? "arbitrary" : units);
  facts.NumberIn(by, "angular range", text, R"(angular range +(\d+) x)", 0.5);
  facts.NumberIn(by, "angle of neighbours", text, R"(neighbours +([\d.]+) degrees)", 0.005);
}

void ReadSummary(const std::string& by, json report, Facts& facts) {
  facts.Number(by, "views", report["views"]);
  facts.Number(by, "capture time", report["capture_s"]);
  facts.Number(by, "focal length", report["lenses"][0]["focal_px"]);
  facts.Text(by, "source of the lens", report["lenses"][0]["calibration_source"]);
  facts.Number(by, "covered share", report["covered"]);
  facts.Number(by, "cap's width", report["cap_deg"][0], 1e-6);
  facts.Number(by, "cap's height", report["cap_deg"][1], 1e-6);
  facts.Number(by, "threshold", report["threshold_px"]);
  facts.Number(by, "subject's radius", report["subject"]["radius"]);
  facts.Text(by, "units", report["units"]);
  facts.Number(by, "angular range", report["angular_range_deg"][0]);
  facts.Number(by, "angle of neighbours", report["mean_edge_deg"]);
  facts.Number(by, "frames that were recorded", report["reasons"]["recorded"]);
  facts.Number(by, "duplicates", report["duplicates"]);
}

void ReadInfo(const std::string& dir, Facts& facts) {
  const std::string text = Done("info " + dir).output;
  ReadSummary("info", text, facts);
  facts.NumberIn("info", "triangles", text, R"(geometry .*?(\d+) triangles)", 0);
  json report = JsonDone("info " + dir + " --json");
  ReadSummary("info --json", report, facts);
  facts.Number("info --json", "triangles", report["geometry"]["triangles"]);
  facts.Number("info --json", "depth maps", report["geometry"]["depth_maps"]);
  facts.NumberIn("info", "depth maps", text, R"(geometry .*; (\d+) depth map)", 0);
  const std::string light = Done("info " + dir + " --check-light").output;
  ReadSummary("info --check-light", light, facts);
  facts.Text("info --check-light", "lamps", LampsIn(light));
  json found = JsonDone("info " + dir + " --check-light --json")["light"];
  std::string words;
  for (const char* kind : {"drifts", "wavers"})
    for (const json& one : found[kind]) words += one["words"].get<std::string>() + "\n";
  facts.Text("info --check-light --json", "lamps", LampsIn(words));
  json poses = JsonDone("info " + dir + " --check-poses --json")["poses"];
  facts.Number("info --check-poses", "views",
               poses["agree"].get<double>() + static_cast<double>(poses["contradicted"].size()) +
                   static_cast<double>(poses["not_judged"].size()));
}

void ReadFilesForOthers(const fs::path& dir, Facts& facts) {
  json transforms = JsonFromText(ReadWholeFile(dir / "transforms.json"));
  const std::string by = "transforms.json";
  facts.Number(by, "views", static_cast<double>(transforms["frames"].size()));
  facts.Number(by, "focal length",
               0.5 * (transforms["fl_x"].get<double>() + transforms["fl_y"].get<double>()));
  facts.Text(by, "source of the lens", transforms["ulf"]["calibration_source"]);
  facts.Text(by, "units", transforms["ulf"]["units"]);
  facts.Number(by, "threshold", transforms["ulf"]["threshold_px"]);
  facts.Number(by, "capture time", transforms["ulf"]["capture_s"]);
  facts.Number(by, "cap's width", transforms["ulf"]["goal"]["cap_deg"][0], 1e-6);
  facts.Number(by, "cap's height", transforms["ulf"]["goal"]["cap_deg"][1], 1e-6);
  facts.Number(by, "subject's radius", transforms["ulf"]["subject"]["radius"]);
  facts.Number(by, "frames that were recorded", transforms["ulf"]["reasons"]["recorded"]);

  std::ifstream cameras(dir / "sparse/0/cameras.txt"), images(dir / "sparse/0/images.txt");
  std::string line;
  while (std::getline(cameras, line) && line.starts_with("#")) continue;
  std::istringstream camera(line);
  std::string id, model, width, height;
  double fx = 0, fy = 0;
  camera >> id >> model >> width >> height >> fx >> fy;
  facts.Number("sparse/0", "focal length", 0.5 * (fx + fy), 1e-4);
  double views = 0;
  while (std::getline(images, line)) {
    if (line.starts_with("#")) continue;
    ++views;
    std::getline(images, line);  // its points
  }
  facts.Number("sparse/0", "views", views);
}

// A page draws the mesh without the views' depth maps.
std::string AsAPageDraws(const std::string& proxy) { return proxy == "soft" ? "mesh" : proxy; }

void ReadRenderings(const std::string& dir, const fs::path& scratch, Facts& facts) {
  const std::string drawn = "field where nothing is compared", over = "geometry where nothing is compared";
  json evaluate = JsonDone("evaluate " + dir + " --every 4 --fields nearest --size-limit 160 --json");
  facts.Number("evaluate", "views", evaluate["views"]);
  facts.Text("evaluate", drawn, evaluate["default"]["field"]);
  facts.Text("evaluate", over, evaluate["default"]["proxy"]);
  facts.Text("evaluate", "field by evidence", evaluate["render"]["field"]);
  facts.Text("evaluate", "geometry by evidence", evaluate["render"]["proxy"]);
  const std::string picture = (scratch / "picture.png").string();
  json view = JsonDone("view " + dir + " --size-limit 160 --screenshot " + picture + " --json");
  facts.Text("view", drawn, view["field"]);
  facts.Text("view", over, view["proxy"]);
  facts.Text("view, for a page", over + " of a page", AsAPageDraws(view["proxy"]));
  const std::string site = (scratch / "site").string();
  json web = JsonDone("export web " + dir + " --size-limit 160 -o " + site + " --json");
  facts.Text("export web", drawn, web["field"]);
  facts.Text("export web", over + " of a page", web["proxy"]);
  facts.Number("export web", "views", web["views"]);
  facts.Number("export web", "triangles", web["triangles_before"]);
  const std::string page = ReadWholeFile(fs::path(site) / "data/scene.js");
  facts.NumberIn("the page", "views", page, R"(\\?"views\\?":(\d+))", 0);
  facts.NumberIn("the page", "subject's radius", page, R"(\\?"radius\\?":([\d.e-]+))", 1e-6);

  const std::string render = "render " + dir + " --size-limit 160 --width 160 -o " + picture;
  const CommandResult told = Done(render + " --explain --json");
  json chosen = JsonFromText(told.output);
  facts.Text("render --json", "field by evidence", chosen["field"]);
  facts.Text("render --json", "geometry by evidence", chosen["proxy"]);
  for (const json& choice : chosen["explain"])
    for (const json& candidate : choice["candidates"])
      if (candidate["chosen"] == true && choice["question"] == "blending field") {
        const std::string model = candidate["model"];
        facts.Text("render --explain", "field by evidence", model.substr(0, model.find(' ')));
      }
  const std::string tip = facts.Match("render", told.errors, R"(the next time: (.*)\n)");
  facts.Text("render's tip", "field by evidence", facts.Match("the tip", tip, R"(--field (\S+))"));
  facts.Text("render's tip", "geometry by evidence", facts.Match("the tip", tip, R"(--proxy (\S+))"));
}

// `takes_lens`: --intrinsics; then the lens is another one from here on.
void ReadRefine(const std::string& dir, const fs::path& scratch, bool takes_lens, Facts& facts) {
  const std::string copy = (scratch / "refined").string();
  fs::copy(dir, copy, fs::copy_options::recursive);
  json report = JsonDone("refine " + copy + (takes_lens ? " --intrinsics" : "") + " --json");
  facts.Number("refine", "views", report["views"]);
  facts.Text("refine", "units", report["moved"]["units"]);
  for (const json& check : report["calibration"])
    if (!check.is_null()) facts.Number("refine", "focal length", check["given_focal_px"], 1e-6);
  json after = JsonDone("info " + copy + " --json");
  facts.Number("info after refine", "views", after["views"]);
  const std::string now = takes_lens ? ", refined" : "";
  facts.Number("info after refine", "focal length" + now, after["lenses"][0]["focal_px"]);
  facts.Text("info after refine", "source of the lens" + now, after["lenses"][0]["calibration_source"]);
  json transforms = JsonFromText(ReadWholeFile(fs::path(copy) / "transforms.json"));
  facts.Number("transforms.json after refine", "focal length" + now,
               0.5 * (transforms["fl_x"].get<double>() + transforms["fl_y"].get<double>()));
  facts.Text("transforms.json after refine", "source of the lens" + now,
             transforms["ulf"]["calibration_source"]);
  if (!takes_lens) return;
  for (const json& lens : report["lenses"])
    if (lens["taken"] == true)
      facts.Number("refine", "focal length, refined",
                   0.5 * (lens["fx"].get<double>() + lens["fy"].get<double>()), 1e-6);
}

// The stored lens is too long, the tracker finds the right one; a lamp fades.
std::string Capture(const std::string& dir, const std::string& cap) {
  return "capture 'sim:studio?width=320&height=240&seed=4&fault=lens=0.93&fault=drift=-4' -o " + dir +
         " --operator guided --intrinsics refine --quality fast --headless --until-covered " + cap;
}

void ReadAllReports(const std::string& dir, const fs::path& scratch, bool refines_lens, Facts& facts) {
  ReadInfo(dir, facts);
  ReadFilesForOthers(dir, facts);
  ReadRenderings(dir, scratch, facts);
  ReadRefine(dir, scratch, refines_lens, facts);
}

TEST(ReportsAgree, OnACaptureToldInWords) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  Facts facts;
  const CommandResult capture = Done(Capture(dir, "24x16"));
  const std::string& text = capture.output;
  ReadSummary("capture", text, facts);
  facts.NumberIn("capture", "frames that were recorded", text, R"(this session .*, (\d+) recorded)", 0);
  facts.NumberIn("capture", "triangles", text, R"(geometry +(\d+) triangles)", 0);
  facts.NumberIn("capture", "depth maps", text, R"(geometry .*, (\d+) in depth/)", 0);
  facts.NumberIn("capture's lens", "focal length", text, R"(lens +a focal length of ([\d.]+) px)", 0.05);
  const std::string sigma =
      facts.Match("capture", text, R"(lens +a focal length of [\d.]+ px \(± ([\d.]+)\))");
  facts.Text("capture's lens", "source of the lens", "the images of the capture (± " + sigma + " px)");
  const std::string lamps = LampsIn(capture.errors);
  EXPECT_THAT(lamps, testing::HasSubstr("darker")) << "else nothing is compared";
  facts.Text("capture", "lamps", lamps);
  ReadAllReports(dir, scratch.path(), false, facts);
  facts.ExpectAgreement(220);
}

TEST(ReportsAgree, OnACaptureToldAsJson) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  Facts facts;
  const CommandResult capture = Done(Capture(dir, "44x30") + " --json");
  json report = JsonFromText(capture.output);
  ReadSummary("capture --json", report, facts);
  facts.Number("capture --json", "frames that were recorded", report["recorded"]);
  facts.Number("capture --json", "triangles", report["geometry"]["triangles"]);
  facts.Number("capture --json", "depth maps", report["geometry"]["written_maps"]);
  facts.Number("capture --json, lens", "focal length", report["refined_lens"]["focal_px"]);
  facts.Text("capture", "lamps", LampsIn(capture.errors));
  ReadAllReports(dir, scratch.path(), true, facts);
  facts.ExpectAgreement(220);
}

}  // namespace
}  // namespace ulf::test::reports_agree_test
