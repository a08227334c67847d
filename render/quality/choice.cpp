#include "render/quality/choice.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "core/base/counted.h"
#include "render/proxy/planes_proxy.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/evaluate.h"

namespace ulf::render {
namespace {

// The same views without their first pyramid levels.
RenderScene Small(const RenderScene& scene, int size_px) {
  RenderScene small = scene;
  for (SceneView& view : small.views) {
    int skip = 0;
    const auto longer = [&] {
      const cv::Size size = view.photograph->LevelSize(skip);
      return std::max(size.width, size.height);
    };
    while (longer() > size_px) ++skip;
    view.photograph = FromLevel(view.photograph, skip);
    view.camera = view.camera.ScaledTo(view.photograph->size().width, view.photograph->size().height);
  }
  return small;
}

std::vector<ScoredChoice> Try(const RenderScene& scene, const std::vector<FieldOptions>& fields,
                              const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                              int views_left_out, int window_px = 0) {
  const int every = std::max(2, static_cast<int>(scene.views.size()) / views_left_out);
  const EvaluateSummary summary = Evaluate(
      scene,
      {.every = every, .fields = fields, .proxies = proxies, .renderer = renderer, .window_px = window_px});
  std::vector<ScoredChoice> candidates;
  for (std::size_t i = 0; i < summary.results.size(); ++i) {
    const FieldScore& result = summary.results[i];
    const std::shared_ptr<const Proxy>& proxy = proxies[i / fields.size()];
    // Where the viewpoints span no surface, several fields become the same one.
    const bool again = std::ranges::any_of(candidates, [&](const ScoredChoice& other) {
      return other.proxy == proxy && FieldText(other.field) == FieldText(result.used);
    });
    if (!again) candidates.push_back({result.used, proxy, result.Main().psnr_db});
  }
  return candidates;
}

std::string ModelName(const ScoredChoice& candidate, bool by_proxy) {
  return by_proxy ? candidate.proxy->Name() : FieldText(candidate.field);
}

std::string Listed(const std::vector<ScoredChoice>& candidates, bool by_proxy) {
  std::vector<std::string> texts;
  for (const ScoredChoice& candidate : candidates)
    texts.push_back(fmt::format("{} {:.1f}", ModelName(candidate, by_proxy), candidate.psnr_db));
  return fmt::format("{}", fmt::join(texts, ", "));
}

ModelChoice Explained(const std::string& question, const std::vector<ScoredChoice>& tried,
                      const ScoredChoice& chosen, bool by_proxy, double within_db) {
  ModelChoice explained{
      question,
      fmt::format("the first within {} dB of the best on views that were left out, in this order", within_db),
      {}};
  for (const ScoredChoice& candidate : tried)
    explained.candidates.push_back(
        {ModelName(candidate, by_proxy), fmt::format("{:.2f} dB", candidate.psnr_db), &candidate == &chosen});
  return explained;
}

ModelChoice Untried(const std::string& question, const std::string& model, const std::string& why) {
  return {question, "nothing was compared", {{model, why, true}}};
}

// The field for few views, or for views on a line.
std::optional<FieldOptions> LumigraphAmong(const std::vector<FieldOptions>& fields) {
  const auto found = std::ranges::find_if(
      fields, [](const FieldOptions& field) { return field.kind == FieldKind::kLumigraph; });
  return found == fields.end() ? std::nullopt : std::optional(*found);
}

// The widths of the soft field cost the same: none of them is preferred.
const ScoredChoice& BestOfItsKind(const std::vector<ScoredChoice>& tried, const ScoredChoice& chosen) {
  if (chosen.field.kind != FieldKind::kSoft) return chosen;
  return *std::ranges::max_element(tried, {}, [](const ScoredChoice& candidate) {
    return candidate.field.kind == FieldKind::kSoft ? candidate.psnr_db : -1;
  });
}

bool SoftAlone(const std::vector<FieldOptions>& fields) {
  return std::ranges::all_of(fields,
                             [](const FieldOptions& field) { return field.kind == FieldKind::kSoft; });
}

// A mesh that the user names may be of another scene, or in other coordinates.
void WarnOfUnfitMesh(const RenderScene& scene, const Choice& choice, RendererKind renderer,
                     const ChoiceOptions& options) {
  if (choice.candidates.empty() || !choice.proxy->Occluder() || choice.proxy->Name() == kPlanesProxy) return;
  const std::vector<ScoredChoice> both =
      Try(Small(scene, options.size_px), {choice.field},
          {std::make_shared<PlaneProxy>(scene.subject), choice.proxy}, renderer, options.views_left_out);
  const double by_plane = both.front().psnr_db, by_mesh = both.back().psnr_db;
  if (by_mesh < by_plane)
    spdlog::warn(
        "left-out views are worse over {} than over the plane through the subject ({:.1f} dB, {:.1f}): is it "
        "a mesh of this scene, in the light field's world?",
        choice.proxy->Name(), by_mesh, by_plane);
}

}  // namespace

const ScoredChoice& FirstWithinTolerance(const std::vector<ScoredChoice>& candidates, double within_db) {
  const auto best = std::ranges::max_element(
      candidates, [](const auto& a, const auto& b) { return a.psnr_db < b.psnr_db; });
  return *std::ranges::find_if(candidates, [&](const ScoredChoice& candidate) {
    return candidate.psnr_db >= best->psnr_db - within_db;
  });
}

Choice ChooseByEvidence(const RenderScene& scene, const std::vector<FieldOptions>& fields,
                        const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                        const ChoiceOptions& options) {
  Choice choice{FieldThatServes(fields.front(), scene.mesh), proxies.front(), {}, {}, {}};
  const auto add_reason = [&](const std::string& reason) {
    choice.why += (choice.why.empty() ? "" : "; ") + reason;
  };
  const bool few = static_cast<int>(scene.views.size()) < options.fewest_views;
  const auto untried = [&](const std::string& why) {
    choice.explained = {Untried("proxy", choice.proxy->Name(), why),
                        Untried("blending field", FieldText(choice.field), why)};
    return choice;
  };
  if (choice.field.kind != fields.front().kind) {
    choice.why = FieldName(choice.field.kind) + " weights are used: these viewpoints allow no others";
    if (proxies.size() == 1) return untried("the viewpoints span no surface");
  }
  const bool open = fields.size() > 1 || proxies.size() > 1;
  if (few && open) {
    if (const auto lumigraph = LumigraphAmong(fields)) choice.field = FieldThatServes(*lumigraph, scene.mesh);
    choice.proxy = proxies.back();
    add_reason(fmt::format("{} with the {} proxy: {}, too few to leave some out and compare",
                           FieldText(choice.field), choice.proxy->Name(),
                           Counted(scene.views.size(), "view")));
    return untried(fmt::format("{}, and {} or more are compared", Counted(scene.views.size(), "view"),
                               options.fewest_views));
  }
  const bool fields_differ = choice.field.kind == fields.front().kind && fields.size() > 1;
  if (proxies.size() == 1 && !fields_differ) return untried("as asked");

  const auto detailed =
      std::ranges::find_if(proxies, [](const auto& proxy) { return proxy->HasDepthMaps(); });
  const bool in_detail = detailed != proxies.end();
  const RenderScene tried_on = Small(scene, in_detail ? options.detailed_size_px : options.size_px);
  const auto scores = [&](const std::vector<FieldOptions>& some_fields,
                          const std::vector<std::shared_ptr<const Proxy>>& some_proxies) {
    return Try(tried_on, some_fields, some_proxies, renderer, options.views_left_out,
               in_detail ? options.window_px : 0);
  };
  if (proxies.size() > 1) {
    const auto tried = scores({fields.front()}, proxies);
    const ScoredChoice& chosen = FirstWithinTolerance(tried, options.within_db);
    choice.proxy = chosen.proxy;
    choice.explained.push_back(Explained("proxy", tried, chosen, true, options.within_db));
    add_reason(fmt::format("proxy {}: {} dB", choice.proxy->Name(), Listed(tried, true)));
    choice.candidates = tried;
  }
  if (fields_differ) {
    // The soft field takes several times as long, which pays where there are depth maps: it is tried over these, whatever
    // serves the other fields.
    std::vector<FieldOptions> soft, others;
    for (const FieldOptions& field : fields)
      (field.kind == FieldKind::kSoft && in_detail ? soft : others).push_back(field);
    if (!SoftAlone(fields) && !in_detail)
      std::erase_if(others, [](const FieldOptions& field) { return field.kind == FieldKind::kSoft; });
    std::vector<ScoredChoice> tried;
    if (!others.empty()) tried = scores(others, {choice.proxy});
    if (!soft.empty()) {
      const auto by_maps = scores(soft, {*detailed});
      tried.insert(tried.end(), by_maps.begin(), by_maps.end());
    }
    const ScoredChoice& chosen = BestOfItsKind(tried, FirstWithinTolerance(tried, options.within_db));
    choice.field = chosen.field;
    choice.proxy = chosen.proxy;
    choice.explained.push_back(Explained("blending field", tried, chosen, false, options.within_db));
    add_reason(fmt::format("{}: {} dB", FieldText(choice.field), Listed(tried, false)));
    choice.candidates.insert(choice.candidates.end(), tried.begin(), tried.end());
  }
  choice.why +=
      fmt::format(" on left-out views; the first within {} dB of the best, in this order", options.within_db);
  return choice;
}

std::vector<FieldOptions> EveryField(const FieldOptions& details) {
  std::vector<FieldOptions> fields(6, details);
  fields[0].kind = fields[2].kind = FieldKind::kSubdivision;
  fields[1].kind = FieldKind::kLinear;
  fields[2].level = kLimitLevel;
  fields[3].kind = FieldKind::kLumigraph;
  fields[4].kind = fields[5].kind = FieldKind::kSoft;
  fields[4].soft_width = kNarrowSoft;
  fields[5].soft_width = kWideSoft;
  if (details.level == kLimitLevel) fields.erase(fields.begin() + 2);  // it equals the first
  return fields;
}

std::shared_ptr<const Proxy> FitPlane(const RenderScene& scene, const FieldOptions& field,
                                      RendererKind renderer, const FitPlaneOptions& options,
                                      const ChoiceOptions& choice) {
  if (static_cast<int>(scene.views.size()) < choice.fewest_views)
    return std::make_shared<PlaneProxy>(scene.subject);
  const RenderScene small = Small(scene, choice.size_px);
  std::map<double, double> tried;  // PSNR by share
  const auto best = [&] {
    return std::ranges::max_element(tried, {}, &std::pair<const double, double>::second);
  };
  const auto try_at = [&](const std::vector<double>& shares) {
    std::vector<std::shared_ptr<const Proxy>> planes;
    for (const double share : shares) planes.push_back(std::make_shared<PlaneProxy>(scene.subject, share));
    const int every = std::max(2, static_cast<int>(scene.views.size()) / choice.views_left_out);
    const EvaluateSummary summary =
        Evaluate(small, {.every = every, .fields = {field}, .proxies = planes, .renderer = renderer});
    for (std::size_t i = 0; i < shares.size(); ++i) tried[shares[i]] = summary.results[i].all.psnr_db;
  };
  std::vector<double> shares;
  const double ratio = std::pow(options.farthest / options.nearest, 1.0 / (options.first_tries - 1));
  for (int i = 0; i < options.first_tries; ++i) shares.push_back(options.nearest * std::pow(ratio, i));
  try_at(shares);
  // Between the best and its neighbour on either side in turn, halving.
  for (int i = 0; i < options.more_tries; ++i) {
    const auto at = best();
    const bool is_first = at == tried.begin(), is_last = std::next(at) == tried.end();
    std::vector<double> between;
    if (!is_first && (i % 2 == 0 || is_last)) between.push_back(std::sqrt(at->first * std::prev(at)->first));
    if (!is_last && (i % 2 == 1 || is_first)) between.push_back(std::sqrt(at->first * std::next(at)->first));
    try_at(between);
  }
  return std::make_shared<PlaneProxy>(scene.subject, best()->first);
}

std::shared_ptr<const Proxy> ProxyByName(const RenderScene& scene, const std::string& proxy,
                                         const FieldOptions& field, const std::filesystem::path& light_field,
                                         RendererKind renderer) {
  if (proxy != kFittedPlane) return ProxyFromName(proxy, scene.subject, light_field);
  auto plane = FitPlane(scene, FieldThatServes(field, scene.mesh), renderer);
  spdlog::info("--proxy {}: {}", kFittedPlane, plane->Name());
  return plane;
}

Choice ChooseByName(const RenderScene& scene, const std::string& field, const FieldOptions& details,
                    const std::string& proxy, const std::filesystem::path& light_field,
                    RendererKind renderer) {
  std::vector<FieldOptions> fields(1, details);
  if (field != kAuto) {
    fields[0].kind = FieldFromName(field);
  } else {
    fields = EveryField(details);
  }
  std::vector<std::shared_ptr<const Proxy>> proxies =
      proxy == kAuto ? EveryProxyOf(light_field, scene.subject)
                     : std::vector{ProxyByName(scene, proxy, fields[0], light_field, renderer)};
  if (proxy == kAuto && proxies.size() == 1)
    proxies.push_back(ProxyByName(scene, kFittedPlane, fields[0], light_field, renderer));
  Choice choice = ChooseByEvidence(scene, fields, proxies, renderer);
  if (proxy != kAuto) WarnOfUnfitMesh(scene, choice, renderer, {});
  return choice;
}

}  // namespace ulf::render
