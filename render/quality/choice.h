// Chooses the blending field and the proxy of a light field by evidence and by time: the views that
// `ulf evaluate` leaves out, or a part of them, are left out, rendered from the others, small or in part, and
// compared with their photographs. Among proxies, and among fields that blend over one surface, it takes the
// first candidate, in an order of preference, within a margin of the best; it takes the soft field, several
// times as slow, if that is better. A mesh that was made from all views knows the left-out ones as well and
// scores a little too well.
//
// For files the best pictures count, and the choice is the same every time: the clock plays no part. For a
// moving camera the frame rate counts: those too slow on this machine are not taken (MotionTiming).
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "render/fields/field_options.h"
#include "render/proxy/proxy.h"
#include "render/renderer/renderer.h"
#include "render/scene/scene.h"

namespace ulf::render {

// Returns the fields between which evidence chooses, in order of preference, with these details.
std::vector<FieldOptions> EveryField(const FieldOptions& details = {});

struct ScoredChoice {
  FieldOptions field;
  std::shared_ptr<const Proxy> proxy;
  double psnr_db = 0;  // mean over the left-out views inside the hull (FieldScore::Main())
  double ms = 0;       // per picture
};

struct Choice {
  FieldOptions field;
  std::shared_ptr<const Proxy> proxy;
  std::vector<ScoredChoice> candidates;  // empty if nothing was compared
  std::string why;                       // one line for people
  std::vector<ModelChoice> explained;    // the choice of the proxy and of the field
};

inline constexpr char kAuto[] = "auto";

// The camera of a viewer in motion, and the time that a picture may take.
struct MotionTiming {
  CameraModel camera;
  Rigid3 cam_from_world;
  double most_ms = 0;  // per picture
};

struct ChoiceOptions {
  std::optional<MotionTiming> in_motion = {};  // none: for files
  // Approximate number, evenly through the light field; of fewer than 64 views every eighth
  // (EvaluateOptions::every). Guessed.
  int views_left_out = 8;
  // Longest side of the pictures; if a proxy has depth maps, the middle of larger ones is compared. Guessed.
  int size_px = 320;
  double gpu_memory_mb = 0;  // RenderOptions::gpu_memory_mb
  // Called before each picture, and after the last, with the subject of the comparison ("geometry", "fields")
  // and the share that is done, 0 to 1; what it throws ends the comparison.
  std::function<void(const std::string& compared, double share)> between = {};
};

// Returns the first of the candidates (at least one) that is hardly worse than the best, by 0.3 dB at most.
const ScoredChoice& FirstWithinTolerance(const std::vector<ScoredChoice>& candidates);

// Returns, of candidates that differ by their field (at least one), the soft field (the first within 0.05 dB
// of the best) if it gains 0.1 dB on the first of the others within tolerance: of the best of them, and of
// `best_db`, the best of other proxies, so that two choices in a row do not give twice the tolerance away.
const ScoredChoice& PreferredField(const std::vector<ScoredChoice>& candidates,
                                   double best_db = -std::numeric_limits<double>::infinity());

// Returns the candidates that take at most `most_ms`; if all take longer, the quickest.
std::vector<ScoredChoice> WithinTime(const std::vector<ScoredChoice>& candidates, double most_ms);

// `fields` and `proxies` are in order of preference, the simplest proxy first. First every proxy is tried
// with the first field, then every field with the chosen proxy (the soft field over the depth maps, whichever
// proxy was chosen), because geometry matters more than weights. With too few views to leave some out, the
// choice is the DefaultField(), if it is among the fields, and the last proxy, which has the most geometry.
// FieldThatServes() replaces fields that the viewpoints do not allow; what is the same then is tried once.
Choice ChooseByEvidence(const RenderScene& scene, const std::vector<FieldOptions>& fields,
                        const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                        const ChoiceOptions& options = {});

// Fits the plane that faces the virtual camera, at the share of the subject's distance at which left-out
// views are shown best (`choice` says how many, how large, and in how much memory). With too few views to
// leave some out it is the plane through the subject.
std::shared_ptr<const Proxy> FitPlane(const RenderScene& scene, const FieldOptions& field,
                                      RendererKind renderer, const ChoiceOptions& choice = {});

// Makes a proxy by its name on the command line: those of ProxyFromName(), and kFittedPlane.
std::shared_ptr<const Proxy> ProxyByName(const RenderScene& scene, const std::string& proxy,
                                         const FieldOptions& field, const std::filesystem::path& light_field,
                                         RendererKind renderer, const ChoiceOptions& options = {});

// Returns the proxies of `proxy`, a name of the command line: that one; for "auto" the plane, a fitted
// plane, and the light field's own planes, points and mesh.
std::vector<std::shared_ptr<const Proxy>> ProxiesToTry(const RenderScene& scene, const std::string& proxy,
                                                       const FieldOptions& field,
                                                       const std::filesystem::path& light_field,
                                                       RendererKind renderer,
                                                       const ChoiceOptions& options = {});

// Chooses by names of the command line among these proxies. "auto" compares subdivision (of `details`'
// level), linear, lumigraph weights and, over depth maps, the soft field, narrow and wide. Subdivision comes
// first because it is the calmest in motion, which left-out views do not show; then cheaper ones.
Choice ChooseByName(const RenderScene& scene, const std::string& field, const FieldOptions& details,
                    const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer,
                    const ChoiceOptions& options = {});

}  // namespace ulf::render
