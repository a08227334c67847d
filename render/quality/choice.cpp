#include "render/quality/choice.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/planes_proxy.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/evaluate.h"

namespace ulf::render {
namespace {

// With depth maps, everything is compared by the middle of the pictures at (nearly) their own size, because
// small pictures do not show the gain of good geometry. Guessed.
constexpr int kDetailedSizePx = 1600, kWindowPx = 400;

// The first candidate that is at most this much worse than the best is chosen. Guessed.
constexpr double kWithinDb = 0.3;
// The soft field must be better than the choice among the others by this much, which is about the chance
// error of the comparison. Guessed.
constexpr double kSoftGainDb = 0.1;
// The narrow soft field, which is quicker, is taken if at most this much worse than the wide one. Guessed.
constexpr double kNarrowWithinDb = 0.05;

// These are guessed.
constexpr double kFitPlaneNearest = 0.4, kFarthest = 2.5;  // shares of the subject's distance
constexpr int kFirstTries = 13;  // in equal ratios; the search continues around the best of them
constexpr int kMoreTries = 6;

// Returns the same views without their first pyramid levels.
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

// Leaves out no larger share than `ulf evaluate` does: of a set that loses half of its views, or a whole
// row of them, all pictures are guesses, and simple geometry guesses best.
int LeftOutEvery(const RenderScene& scene, const ChoiceOptions& options) {
  return std::max(EvaluateOptions{}.every, static_cast<int>(scene.views.size()) / options.views_left_out);
}

constexpr char kGeometry[] = "geometry", kFields[] = "fields";  // what is compared

std::vector<ScoredChoice> Try(const std::string& compared, const RenderScene& scene,
                              const std::vector<FieldOptions>& fields,
                              const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                              const ChoiceOptions& options, int window_px = 0) {
  std::function<void(double)> between;
  if (options.between) between = [&](double share) { options.between(compared, share); };
  const EvaluateSummary summary = Evaluate(scene, {.every = LeftOutEvery(scene, options),
                                                   .fields = fields,
                                                   .proxies = proxies,
                                                   .renderer = renderer,
                                                   .gpu_memory_mb = options.gpu_memory_mb,
                                                   .window_px = window_px,
                                                   .between = between});
  std::vector<ScoredChoice> candidates;
  for (std::size_t i = 0; i < summary.results.size(); ++i) {
    const FieldScore& result = summary.results[i];
    const std::shared_ptr<const Proxy>& proxy = proxies[i / fields.size()];
    // If the viewpoints span no surface, several fields become the same one.
    const bool again = std::ranges::any_of(candidates, [&](const ScoredChoice& other) {
      return other.proxy == proxy && FieldText(other.field) == FieldText(result.used);
    });
    if (!again) candidates.push_back({result.used, proxy, result.Main().psnr_db, result.ms_per_frame});
  }
  return candidates;
}

// Times candidates as a viewer draws them, without reading the picture back as Rendering::ms does not either.
// The first picture of each waits for photographs and shaders.
void TimeInMotion(const std::string& compared, const RenderScene& scene, RendererKind kind,
                  const ChoiceOptions& options, std::vector<ScoredChoice>& candidates) {
  constexpr int kPictures = 3;
  const MotionTiming& motion = *options.in_motion;
  const auto renderer = MakeRenderer(WithProxy(scene, candidates.front().proxy),
                                     {.renderer = kind, .gpu_memory_mb = options.gpu_memory_mb});
  for (ScoredChoice& candidate : candidates) {
    if (options.between) options.between(compared, 1);
    if (renderer->scene().proxy != candidate.proxy) renderer->SetProxy(candidate.proxy);
    renderer->SetField(candidate.field);
    renderer->Render(motion.camera, motion.cam_from_world);
    std::vector<double> times;
    for (int i = 0; i < kPictures; ++i)
      times.push_back(renderer->Render(motion.camera, motion.cam_from_world).ms);
    candidate.ms = Median(times);
  }
}

std::string ModelName(const ScoredChoice& candidate, bool by_proxy) {
  return by_proxy ? candidate.proxy->Name() : FieldText(candidate.field);
}

bool NoneIsQuickEnough(const std::vector<ScoredChoice>& tried, const ChoiceOptions& options) {
  return options.in_motion && std::ranges::none_of(tried, [&](const ScoredChoice& candidate) {
           return candidate.ms <= options.in_motion->most_ms;
         });
}

// `tried` has the candidates of one question. `where` names the reason for the margin.
std::string Criterion(const ChoiceOptions& options, const std::vector<ScoredChoice>& tried, bool with_soft,
                      const std::string& where = {}) {
  std::string text;
  if (options.in_motion) {
    const std::string in_time =
        fmt::format("at most {} ms for a picture of {}x{}", options.in_motion->most_ms,
                    options.in_motion->camera.width, options.in_motion->camera.height);
    if (NoneIsQuickEnough(tried, options)) return fmt::format("none takes {}: the quickest", in_time);
    text = fmt::format("of those that take {} ", in_time);
  }
  text += fmt::format("the first within {} dB of the best{}, in this order", kWithinDb, where);
  if (with_soft)
    text +=
        fmt::format("; soft where it is {} dB better than that, narrow where wide is less than {} dB better",
                    kSoftGainDb, kNarrowWithinDb);
  return text;
}

bool IsSoft(const FieldOptions& field) { return field.kind == FieldKind::kSoft; }

bool IsSame(const ScoredChoice& a, const ScoredChoice& b) {
  return a.proxy == b.proxy && FieldText(a.field) == FieldText(b.field);
}

ModelChoice Explained(const std::string& question, const std::vector<ScoredChoice>& tried,
                      const ScoredChoice& chosen, bool by_proxy, const ChoiceOptions& options) {
  ModelChoice explained{
      question,
      Criterion(options, tried, !by_proxy && std::ranges::any_of(tried, IsSoft, &ScoredChoice::field),
                " on views that were left out"),
      {}};
  for (const ScoredChoice& candidate : tried)
    explained.candidates.push_back(
        {ModelName(candidate, by_proxy),
         fmt::format("{:.2f} dB, {:.3g} s a picture", candidate.psnr_db, 1e-3 * candidate.ms),
         IsSame(candidate, chosen)});
  return explained;
}

// Returns "The proxy soft shows left-out photographs best: 36.2 dB (points 32.9, planes 32.4, plane 21.5)."
// and, if the best alone did not decide, what did.
std::string InWords(const std::string& question, const std::vector<ScoredChoice>& tried,
                    const ScoredChoice& chosen, bool by_proxy, const ChoiceOptions& options) {
  std::vector<ScoredChoice> others;
  std::ranges::copy_if(tried, std::back_inserter(others),
                       [&](const ScoredChoice& candidate) { return !IsSame(candidate, chosen); });
  std::ranges::stable_sort(others, std::ranges::greater(), &ScoredChoice::psnr_db);
  const std::string name = ModelName(chosen, by_proxy);
  constexpr double kNoticeable_db = 0.05;  // visible in one decimal
  const double better_db = others.empty() ? 0 : others.front().psnr_db - chosen.psnr_db;
  std::string text;
  if (NoneIsQuickEnough(tried, options))
    text = fmt::format(
        "No {} draws a picture within {} ms; {} is the quickest, with {:.1f} dB on left-out photographs",
        question, options.in_motion->most_ms, name, chosen.psnr_db);
  else if (better_db <= 0)
    text =
        fmt::format("The {} {} shows left-out photographs best: {:.1f} dB", question, name, chosen.psnr_db);
  else
    text = fmt::format(
        "The {} {} is taken, with {:.1f} dB on left-out photographs: {}", question, name, chosen.psnr_db,
        options.in_motion && others.front().ms > options.in_motion->most_ms
            ? fmt::format("the best that draws a picture within {} ms", options.in_motion->most_ms)
            : fmt::format(
                  "{} is {}, and {}", ModelName(others.front(), by_proxy),
                  better_db < kNoticeable_db ? "as good" : fmt::format("only {:.1f} dB better", better_db),
                  by_proxy ? "less simple" : "comes after it in the order of preference"));
  std::vector<std::string> rest;
  for (const ScoredChoice& other : others)
    rest.push_back(fmt::format("{} {:.1f}", ModelName(other, by_proxy), other.psnr_db));
  return text + (rest.empty() ? "." : fmt::format(" ({}).", fmt::join(rest, ", ")));
}

ModelChoice Untried(const std::string& question, const std::string& model, const std::string& why) {
  return {question, "nothing was compared", {{model, why, true}}};
}

// Returns the fields that these viewpoints and proxies allow, each once: a row of views has no mesh for
// subdivision and linear, and without depth maps soft is left out if there are others.
std::vector<FieldOptions> FieldsThatServe(const std::vector<FieldOptions>& fields, const ViewpointMesh& mesh,
                                          bool has_depth_maps) {
  const bool all_soft = std::ranges::all_of(fields, IsSoft);
  std::vector<FieldOptions> serving;
  for (const FieldOptions& field : fields) {
    const FieldOptions serves = FieldThatServes(field, mesh);
    const bool again = std::ranges::any_of(
        serving, [&](const FieldOptions& other) { return FieldText(other) == FieldText(serves); });
    if (!again && (has_depth_maps || all_soft || !IsSoft(serves))) serving.push_back(serves);
  }
  return serving;
}

double BestDb(const std::vector<ScoredChoice>& candidates) {
  return std::ranges::max_element(candidates, {}, &ScoredChoice::psnr_db)->psnr_db;
}

// Considers those that are `asked` for. Returns null if there are none. If none is near enough to `best_db`
// of other candidates, their own best counts.
template <typename Asked>
const ScoredChoice* FirstNearBest(const std::vector<ScoredChoice>& candidates, double within_db,
                                  const Asked& asked,
                                  double best_db = -std::numeric_limits<double>::infinity()) {
  double own_best_db = -std::numeric_limits<double>::infinity();
  for (const ScoredChoice& candidate : candidates)
    if (asked(candidate)) own_best_db = std::max(own_best_db, candidate.psnr_db);
  const double least_db = std::min(own_best_db, std::max(own_best_db, best_db) - within_db);
  const auto found = std::ranges::find_if(candidates, [&](const ScoredChoice& candidate) {
    return asked(candidate) && candidate.psnr_db >= least_db;
  });
  return found == candidates.end() ? nullptr : &*found;
}

// A mesh that the user names may be of another scene, or in other coordinates.
void WarnOfUnfitMesh(const RenderScene& scene, const Choice& choice, RendererKind renderer,
                     const ChoiceOptions& options) {
  if (choice.candidates.empty() || !choice.proxy->Occluder() || choice.proxy->Name() == kPlanesProxy) return;
  const std::vector<ScoredChoice> both =
      Try(kGeometry, Small(scene, options.size_px), {choice.field},
          {std::make_shared<PlaneProxy>(scene.subject), choice.proxy}, renderer, options);
  const double by_plane = both.front().psnr_db, by_mesh = both.back().psnr_db;
  if (by_mesh < by_plane)
    spdlog::warn(
        "left-out views are worse over {} than over the plane through the subject ({:.1f} dB, {:.1f}): is it "
        "a mesh of this scene, in the light field's world?",
        choice.proxy->Name(), by_mesh, by_plane);
}

}  // namespace

const ScoredChoice& FirstWithinTolerance(const std::vector<ScoredChoice>& candidates) {
  return *FirstNearBest(candidates, kWithinDb, [](const ScoredChoice&) { return true; });
}

std::vector<ScoredChoice> WithinTime(const std::vector<ScoredChoice>& candidates, double most_ms) {
  std::vector<ScoredChoice> quick;
  std::ranges::copy_if(candidates, std::back_inserter(quick),
                       [&](const ScoredChoice& candidate) { return candidate.ms <= most_ms; });
  if (quick.empty()) quick.push_back(*std::ranges::min_element(candidates, {}, &ScoredChoice::ms));
  return quick;
}

// The soft field is as calm in motion as subdivision. Its wide reach takes 1.3 to 1.4 times as long as
// the narrow one.
const ScoredChoice& PreferredField(const std::vector<ScoredChoice>& candidates, double best_db) {
  const auto is_soft = [](const ScoredChoice& candidate) { return IsSoft(candidate.field); };
  const ScoredChoice* soft = FirstNearBest(candidates, kNarrowWithinDb, is_soft);
  const ScoredChoice* other = FirstNearBest(candidates, kWithinDb, std::not_fn(is_soft), best_db);
  if (!soft) return *other;
  return !other || soft->psnr_db >= other->psnr_db + kSoftGainDb ? *soft : *other;
}

Choice ChooseByEvidence(const RenderScene& scene, const std::vector<FieldOptions>& fields,
                        const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                        const ChoiceOptions& options) {
  Choice choice{FieldThatServes(fields.front(), scene.mesh), proxies.front(), {}, {}, {}};
  const auto add_reason = [&](const std::string& reason) {
    choice.why += (choice.why.empty() ? "" : choice.why.ends_with('.') ? " " : "; ") + reason;
  };
  const bool few = static_cast<int>(scene.views.size()) < kFewestViewsCompared;
  const auto untried = [&](const std::string& why) {
    choice.explained = {Untried("proxy", choice.proxy->Name(), why),
                        Untried("blending field", FieldText(choice.field), why)};
    return choice;
  };
  const auto detailed =
      std::ranges::find_if(proxies, [](const auto& proxy) { return proxy->HasDepthMaps(); });
  const bool in_detail = detailed != proxies.end();
  const std::vector<FieldOptions> serving = FieldsThatServe(fields, scene.mesh, in_detail);
  if (choice.field.kind != fields.front().kind) {
    choice.why = fmt::format("{0} weights are used in place of {1}: these viewpoints span no surface",
                             FieldName(choice.field.kind), FieldName(fields.front().kind));
    if (proxies.size() == 1 && serving.size() == 1) return untried("the viewpoints span no surface");
  }
  const bool open = fields.size() > 1 || proxies.size() > 1;
  if (few && open) {
    const FieldOptions usual = DefaultField(scene, fields.front());
    if (std::ranges::find(fields, usual.kind, &FieldOptions::kind) != fields.end()) choice.field = usual;
    choice.proxy = proxies.back();
    add_reason(fmt::format("{} with the {} proxy: {}, too few to leave some out and compare",
                           FieldText(choice.field), choice.proxy->Name(),
                           Counted(scene.views.size(), "view")));
    return untried(fmt::format("{}, and {} or more are compared", Counted(scene.views.size(), "view"),
                               kFewestViewsCompared));
  }
  const bool fields_differ = serving.size() > 1;
  if (proxies.size() == 1 && !fields_differ) return untried("as asked");

  const RenderScene tried_on = Small(scene, in_detail ? kDetailedSizePx : options.size_px);
  const auto scores = [&](const std::string& compared, const std::vector<FieldOptions>& some_fields,
                          const std::vector<std::shared_ptr<const Proxy>>& some_proxies) {
    return Try(compared, tried_on, some_fields, some_proxies, renderer, options, in_detail ? kWindowPx : 0);
  };
  // Returns the candidates for the choice: all, or in motion those that are quick enough.
  const auto in_time = [&](const std::string& compared, std::vector<ScoredChoice>& tried) {
    if (!options.in_motion) return tried;
    TimeInMotion(compared, scene, renderer, options, tried);
    return WithinTime(tried, options.in_motion->most_ms);
  };
  double best_db = -std::numeric_limits<double>::infinity();  // of all proxies, over the first field
  if (proxies.size() > 1) {
    auto tried = scores(kGeometry, {serving.front()}, proxies);
    const std::vector<ScoredChoice> considered = in_time(kGeometry, tried);
    const ScoredChoice chosen = FirstWithinTolerance(considered);
    best_db = BestDb(considered);
    choice.proxy = chosen.proxy;
    choice.explained.push_back(Explained("proxy", tried, chosen, true, options));
    add_reason(InWords("proxy", tried, chosen, true, options));
    choice.candidates = tried;
  }
  if (fields_differ) {
    // The soft field needs depth maps, so it is tried over these, whichever proxy serves the other fields.
    std::vector<FieldOptions> soft, others;
    for (const FieldOptions& field : serving) (IsSoft(field) && in_detail ? soft : others).push_back(field);
    std::vector<ScoredChoice> tried;
    if (!others.empty()) tried = scores(kFields, others, {choice.proxy});
    if (!soft.empty()) {
      const auto by_maps = scores(kFields, soft, {*detailed});
      tried.insert(tried.end(), by_maps.begin(), by_maps.end());
    }
    const ScoredChoice chosen = PreferredField(in_time(kFields, tried), best_db);
    choice.field = chosen.field;
    choice.proxy = chosen.proxy;
    choice.explained.push_back(Explained("blending field", tried, chosen, false, options));
    add_reason(InWords("blending field", tried, chosen, false, options));
    choice.candidates.insert(choice.candidates.end(), tried.begin(), tried.end());
  }
  return choice;
}

std::vector<FieldOptions> EveryField(const FieldOptions& details) {
  std::vector<FieldOptions> fields(5, details);
  fields[0].kind = FieldKind::kSubdivision;
  fields[1].kind = FieldKind::kLinear;
  fields[2].kind = FieldKind::kLumigraph;
  fields[3].kind = fields[4].kind = FieldKind::kSoft;
  fields[3].soft_width = kNarrowSoft;
  fields[4].soft_width = kWideSoft;
  return fields;
}

std::shared_ptr<const Proxy> FitPlane(const RenderScene& scene, const FieldOptions& field,
                                      RendererKind renderer, const ChoiceOptions& choice) {
  if (static_cast<int>(scene.views.size()) < kFewestViewsCompared)
    return std::make_shared<PlaneProxy>(scene.subject);
  const RenderScene small = Small(scene, choice.size_px);
  std::map<double, double> tried;  // PSNR by share
  const auto best = [&] {
    return std::ranges::max_element(tried, {}, &std::pair<const double, double>::second);
  };
  const auto try_at = [&](const std::vector<double>& shares) {
    std::vector<std::shared_ptr<const Proxy>> planes;
    for (const double share : shares) planes.push_back(std::make_shared<PlaneProxy>(scene.subject, share));
    const EvaluateSummary summary = Evaluate(small, {.every = LeftOutEvery(scene, choice),
                                                     .fields = {field},
                                                     .proxies = planes,
                                                     .renderer = renderer,
                                                     .gpu_memory_mb = choice.gpu_memory_mb});
    for (std::size_t i = 0; i < shares.size(); ++i) tried[shares[i]] = summary.results[i].Main().psnr_db;
  };
  // Rounds as the plane's name does, so that the name gives the same plane.
  const auto named = [](double share) { return std::stod(fmt::format("{:.4g}", share)); };
  std::vector<double> shares;
  const double ratio = std::pow(kFarthest / kFitPlaneNearest, 1.0 / (kFirstTries - 1));
  for (int i = 0; i < kFirstTries; ++i) shares.push_back(named(kFitPlaneNearest * std::pow(ratio, i)));
  try_at(shares);
  // Halves the interval between the best and its neighbour on either side in turn.
  for (int i = 0; i < kMoreTries; ++i) {
    const auto at = best();
    const bool is_first = at == tried.begin(), is_last = std::next(at) == tried.end();
    std::vector<double> between;
    if (!is_first && (i % 2 == 0 || is_last))
      between.push_back(named(std::sqrt(at->first * std::prev(at)->first)));
    if (!is_last && (i % 2 == 1 || is_first))
      between.push_back(named(std::sqrt(at->first * std::next(at)->first)));
    try_at(between);
  }
  return std::make_shared<PlaneProxy>(scene.subject, best()->first);
}

std::shared_ptr<const Proxy> ProxyByName(const RenderScene& scene, const std::string& proxy,
                                         const FieldOptions& field, const std::filesystem::path& light_field,
                                         RendererKind renderer, const ChoiceOptions& options) {
  if (proxy != kFittedPlane) return ProxyFromName(proxy, scene.subject, light_field);
  auto plane = FitPlane(scene, FieldThatServes(field, scene.mesh), renderer, options);
  spdlog::info("{} {}: {}", Parameter("proxy"), kFittedPlane, plane->Name());
  return plane;
}

std::vector<std::shared_ptr<const Proxy>> ProxiesToTry(const RenderScene& scene, const std::string& proxy,
                                                       const FieldOptions& field,
                                                       const std::filesystem::path& light_field,
                                                       RendererKind renderer, const ChoiceOptions& options) {
  if (proxy != kAuto) return {ProxyByName(scene, proxy, field, light_field, renderer, options)};
  auto proxies = EveryProxyOf(light_field, scene.subject);
  const auto fitted = ProxyByName(scene, kFittedPlane, field, light_field, renderer, options);
  if (fitted->Name() != proxies.front()->Name()) proxies.insert(std::next(proxies.begin()), fitted);
  return proxies;
}

Choice ChooseByName(const RenderScene& scene, const std::string& field, const FieldOptions& details,
                    const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                    const ChoiceOptions& options) {
  std::vector<FieldOptions> fields(1, details);
  if (field != kAuto) {
    fields[0].kind = FieldFromName(field);
  } else {
    fields = EveryField(details);
  }
  Choice choice = ChooseByEvidence(scene, fields, proxies, renderer, options);
  if (proxies.size() == 1) WarnOfUnfitMesh(scene, choice, renderer, options);
  return choice;
}

}  // namespace ulf::render
