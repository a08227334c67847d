#include "commands/rendering/against.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "commands/options/command_line.h"
#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/geometry/similarity3.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/quality/same_photographs.h"
#include "render/scene/scene.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

struct Compared {
  ProtocolResult a, b;  // their views are the same photographs, in the same order
  std::size_t shared = 0;
};

// The differences A - B over the left-out photographs.
struct Difference {
  double psnr_db = 0, ssim = 0;  // means
  double psnr_error_db = 0;      // standard error of the mean; 0 for one photograph
  int better = 0;                // number of photographs of which A's PSNR is higher
};

Difference DifferenceOf(const Compared& compared) {
  Difference difference;
  const double count = static_cast<double>(compared.a.views.size());
  double squared = 0;
  for (std::size_t i = 0; i < compared.a.views.size(); ++i) {
    const render::PaperQuality &a = compared.a.views[i].papers, &b = compared.b.views[i].papers;
    difference.psnr_db += (a.psnr_db - b.psnr_db) / count;
    difference.ssim += (a.ssim - b.ssim) / count;
    difference.better += a.psnr_db > b.psnr_db;
    squared += std::pow(a.psnr_db - b.psnr_db, 2);
  }
  if (count > 1)
    difference.psnr_error_db =
        std::sqrt(std::max(0.0, squared - count * std::pow(difference.psnr_db, 2)) / ((count - 1) * count));
  return difference;
}

std::string OneText(const char* letter, const ProtocolResult& result) {
  return fmt::format("{}: {}, {}, {}, proxy {}{}\n", letter, result.light_field,
                     Counted(result.split.given.size(), "other view"), result.field, result.proxy,
                     result.light ? "; " + result.light->Words() : "");
}

std::string ComparedText(const Compared& compared) {
  const ProtocolResult &a = compared.a, &b = compared.b;
  std::string text = OneText("A", a) + OneText("B", b);
  text += fmt::format("{} in both, {} left out ({}), {}x{}, {}\n\n", Counted(compared.shared, "photograph"),
                      a.views.size(), a.split.name, a.width, a.height, a.renderer);
  std::size_t widest = 4;
  for (const TestView& view : a.views) widest = std::max(widest, view.name.size());
  const auto row = [&](const std::string& name, const render::PaperQuality& in_a,
                       const render::PaperQuality& in_b) {
    text += fmt::format("{:<{}}  {:7.2f}  {:7.2f}  {:+7.2f}  {:7.4f}  {:7.4f}  {:+8.4f}\n", name, widest,
                        in_a.psnr_db, in_b.psnr_db, in_a.psnr_db - in_b.psnr_db, in_a.ssim, in_b.ssim,
                        in_a.ssim - in_b.ssim);
  };
  text += fmt::format("{:<{}}  {:>7}  {:>7}  {:>7}  {:>7}  {:>7}  {:>8}\n", "", widest, "PSNR A", "PSNR B",
                      "A - B", "SSIM A", "SSIM B", "A - B");
  long masked_px = 0;
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    row(a.views[i].name, a.views[i].papers, b.views[i].papers);
    masked_px += a.views[i].masked_px;
  }
  row("mean", MeanOf(a.views), MeanOf(b.views));
  const Difference difference = DifferenceOf(compared);
  text += fmt::format("\nA is better in {} of {}", difference.better, a.views.size());
  if (a.views.size() > 1)
    text += fmt::format(", by {:+.2f} dB on average with a standard error of {:.2f} dB", difference.psnr_db,
                        difference.psnr_error_db);
  text += "\n";
  if (masked_px > 0)
    text += fmt::format(
        "{} pixels of these photographs, which A or B masks or loses by undistortion, do not count\n",
        masked_px);
  return text;
}

nlohmann::json ComparedJson(const Compared& compared) {
  const Difference difference = DifferenceOf(compared);
  nlohmann::json json{{"shared", compared.shared},
                      {"left_out", compared.a.views.size()},
                      {"protocol", compared.a.split.name},
                      {"a", ToJson(compared.a)},
                      {"b", ToJson(compared.b)},
                      {"difference",
                       {{"psnr_db", difference.psnr_db},
                        {"psnr_standard_error_db", difference.psnr_error_db},
                        {"ssim", difference.ssim},
                        {"better", difference.better}}},
                      {"views", nlohmann::json::array()}};
  for (std::size_t i = 0; i < compared.a.views.size(); ++i) {
    const TestView &a = compared.a.views[i], &b = compared.b.views[i];
    json["views"].push_back({{"name", a.name},
                             {"name_in_b", b.name},
                             {"psnr_a_db", a.papers.psnr_db},
                             {"psnr_b_db", b.papers.psnr_db},
                             {"ssim_a", a.papers.ssim},
                             {"ssim_b", b.papers.ssim}});
  }
  return json;
}

// Names may hold commas.
std::string ComparedCsv(const Compared& compared) {
  std::string table = "name,name_in_b,psnr_a_db,psnr_b_db,ssim_a,ssim_b\n";
  for (std::size_t i = 0; i < compared.a.views.size(); ++i) {
    const TestView &a = compared.a.views[i], &b = compared.b.views[i];
    table += fmt::format("\"{}\",\"{}\",{:.4f},{:.4f},{:.5f},{:.5f}\n", a.name, b.name, a.papers.psnr_db,
                         b.papers.psnr_db, a.papers.ssim, b.papers.ssim);
  }
  return table;
}

render::SharedPhotographs SharedOf(const LightField& a, const LightField& b) {
  render::SharedPhotographs shared = render::PhotographsInBoth(a, b);
  if (shared.found.empty())
    throw Error("{} and {} have no photograph in common{}; give two light fields of the same photographs",
                a.root.string(), b.root.string(),
                shared.other_pictures == 0
                    ? ""
                    : fmt::format(": of {} the name is in both, but not the picture (an undistorted or "
                                  "resized copy is another one)",
                                  Counted(shared.other_pictures, "photograph")));
  return shared;
}

// Holds how the views of each light field are split into left-out and given ones.
struct Splits {
  render::ProtocolSplit a, b;
};

// The photographs in both are split as the protocol says, by A's names. Views of only one light field are
// what it is compared for, and stay.
Splits SplitBoth(const LightField& a, const LightField& b, const render::SharedPhotographs& shared,
                 const std::string& protocol) {
  LightField in_both = a;
  in_both.views.clear();
  std::vector<bool> only_a(a.views.size(), true), only_b(b.views.size(), true);
  for (const render::SharedPhotograph& each : shared.found) {
    in_both.views.push_back(a.views[At(each.in_first)]);
    only_a[At(each.in_first)] = only_b[At(each.in_second)] = false;
  }
  const render::ProtocolSplit split = render::SplitByProtocol(in_both, protocol);
  Splits splits{{protocol, {}, {}}, {protocol, {}, {}}};
  for (const int test : split.test) {
    splits.a.test.push_back(shared.found[At(test)].in_first);
    splits.b.test.push_back(shared.found[At(test)].in_second);
  }
  for (const int given : split.given) {
    splits.a.given.push_back(shared.found[At(given)].in_first);
    splits.b.given.push_back(shared.found[At(given)].in_second);
  }
  for (std::size_t i = 0; i < only_a.size(); ++i)
    if (only_a[i]) splits.a.given.push_back(static_cast<int>(i));
  for (std::size_t i = 0; i < only_b.size(); ++i)
    if (only_b[i]) splits.b.given.push_back(static_cast<int>(i));
  for (std::vector<int>* views : {&splits.a.test, &splits.a.given, &splits.b.test, &splits.b.given})
    std::ranges::sort(*views);
  return splits;
}

// A's subject and up direction in B's world, by the places of the photographs that both have.
SceneArgs ArgsForB(const SceneArgs& args, const std::string& dir, const LightField& a, const LightField& b,
                   const render::SharedPhotographs& shared) {
  SceneArgs of_b = args;
  of_b.dir = dir;
  if (args.subject.empty() && args.up.empty()) return of_b;
  std::vector<Eigen::Vector3d> in_a, in_b;
  for (const render::SharedPhotograph& each : shared.found) {
    in_a.push_back(a.views[At(each.in_first)].CenterInWorld());
    in_b.push_back(b.views[At(each.in_second)].CenterInWorld());
  }
  const auto b_from_a = AlignPoints(in_a, in_b);
  if (!b_from_a)
    throw UsageError(
        "{}: is in A's world, and the photographs that both light fields have do not tell B's; leave it out",
        args.subject.empty() ? "--up " + args.up : "--subject " + args.subject);
  const render::SceneOptions options = OptionsOf(args);
  const auto text = [](const Eigen::Vector3d& v) { return fmt::format("{},{},{}", v.x(), v.y(), v.z()); };
  if (options.subject)
    of_b.subject = text(*b_from_a * options.subject->center_in_world) +
                   fmt::format(",{}", b_from_a->scale * options.subject->radius);
  if (options.up_in_world) of_b.up = text(b_from_a->rotation * *options.up_in_world);
  return of_b;
}

// Returns a function for EvaluateSplit() that leaves out what the other light field masks. `others` gives the
// other's index of a left-out view.
LeaveOutPixels MasksOf(const LightField& other, std::map<int, int> others, const SceneArgs& args) {
  const auto scene = std::make_shared<std::shared_ptr<const render::RenderScene>>();
  return [scene, others, args, &other](int view, cv::Mat& valid) {
    if (!*scene) {
      LightField tests = other;
      tests.views.clear();
      for (const auto& [own, index] : others) tests.views.push_back(other.views[At(index)]);
      render::SceneOptions options = OptionsOf(args);
      options.subject = render::SubjectOf(other, options.subject);
      *scene = render::LoadScene(tests, options);
    }
    const int id = other.views[At(others.at(view))].id;
    const auto& views = (*scene)->views;
    const auto same = std::ranges::find(views, id, &render::SceneView::id);
    const cv::Mat masked = render::Undistort(*same).valid;
    if (masked.size() == valid.size()) valid.setTo(0, masked == 0);
  };
}

// Puts B's scores into the order of A's photographs.
void OrderAsA(const LightField& a, const LightField& b, const std::map<int, int>& b_of_a,
              Compared& compared) {
  std::vector<TestView> ordered;
  for (const TestView& view : compared.a.views) {
    const auto own = std::ranges::find(a.views, view.score.view_id, &View::id);
    const int id = b.views[At(b_of_a.at(static_cast<int>(own - a.views.begin())))].id;
    ordered.push_back(*std::ranges::find_if(
        compared.b.views, [&](const TestView& other) { return other.score.view_id == id; }));
  }
  compared.b.views = std::move(ordered);
}

}  // namespace

int RunAgainst(const ProtocolArgs& args, const SceneArgs& scene_args,
               const std::vector<render::FieldOptions>& fields, const std::string& table, bool json) {
  if (args.refine)
    throw UsageError(
        "--refine: with --against each light field keeps its own poses; compare with what 'ulf refine {} -o "
        "NEW' makes",
        scene_args.dir);
  const LightField a = ReadLightField(scene_args.dir), b = ReadLightField(args.against);
  if (!table.empty()) RequireWritable(table);
  std::optional<StagedFolder> folder;  // refuses one in use before photographs are compared
  if (!args.out.empty()) folder.emplace(args.out);
  const render::SharedPhotographs shared = SharedOf(a, b);
  const Splits splits = SplitBoth(a, b, shared, args.protocol);
  fs::path folder_a, folder_b;  // empty: nothing is written
  if (folder) {
    RequireDifferentNames(a, splits.a.test);
    RequireDifferentNames(b, splits.b.test);
    folder_a = folder->path() / "A";
    folder_b = folder->path() / "B";
    MakeFolder(folder_a);
    MakeFolder(folder_b);
  }
  const SceneArgs args_b = ArgsForB(scene_args, args.against, a, b, shared);
  std::map<int, int> a_of_b, b_of_a;  // of left-out views
  for (const render::SharedPhotograph& each : shared.found) {
    if (!std::ranges::binary_search(splits.a.test, each.in_first)) continue;
    b_of_a[each.in_first] = each.in_second;
    a_of_b[each.in_second] = each.in_first;
  }
  Compared compared;
  compared.shared = shared.found.size();
  {
    Progress progress("evaluating A", json);
    compared.a =
        EvaluateSplit(a, splits.a, args, scene_args, fields, folder_a, progress, MasksOf(b, b_of_a, args_b));
  }
  {
    Progress progress("evaluating B", json);
    compared.b =
        EvaluateSplit(b, splits.b, args, args_b, fields, folder_b, progress, MasksOf(a, a_of_b, scene_args));
  }
  OrderAsA(a, b, b_of_a, compared);
  if (folder) {
    WriteFileAtomically(folder->path() / "result.json", JsonText(ComparedJson(compared), 1) + "\n");
    WriteFileAtomically(folder->path() / "result.txt", ComparedText(compared));
    folder->Commit();
  }
  if (!table.empty()) WriteFileAtomically(table, ComparedCsv(compared));
  fmt::print("{}", json ? JsonText(ComparedJson(compared), 1) + "\n" : ComparedText(compared));
  return kOk;
}

}  // namespace ulf::commands
