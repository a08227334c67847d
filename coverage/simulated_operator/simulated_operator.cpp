#include "coverage/simulated_operator/simulated_operator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <deque>
#include <random>

#include "acquisition/simulator/hand.h"
#include "acquisition/simulator/scene/scene.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "coverage/operator/instruction.h"
#include "coverage/operator/shown_sphere.h"
#include "coverage/simulated_operator/rows_by_eye.h"

namespace ulf::coverage {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = Radians(1);
constexpr double kStepS = 1.0 / 120;  // of the hand's movement
constexpr double kRememberedS = 3;    // of the hand's places

struct Habits {
  double delay_s;                 // from eye to hand
  double speed;                   // of the dot on the sphere, radians per second, when nothing is in the way
  double sway_m, tremor_m;        // at most
  double turn_sway, turn_tremor;  // radians
  double misread_place;           // on the sphere, disc radii
  double misread_color;           // of the way from green to full
  double misjudged_course;        // radians
  double spring_hz, damping;      // of the hand
  double aim_per_s;               // how fast the subject is brought back to the middle
  bool looks_away, rushes;
};
constexpr Habits kExperienced{.delay_s = 0.25,
                              .speed = 13 * kDegree,
                              .sway_m = 0.006,
                              .tremor_m = 0.0007,
                              .turn_sway = 1.5 * kDegree,
                              .turn_tremor = 0.12 * kDegree,
                              .misread_place = 0.1,
                              .misread_color = 0.15,
                              .misjudged_course = 6 * kDegree,
                              .spring_hz = 1.6,
                              .damping = 0.65,
                              .aim_per_s = 2,
                              .looks_away = false,
                              .rushes = false};
constexpr Habits kNovice{.delay_s = 0.35,
                         .speed = 14 * kDegree,
                         .sway_m = 0.011,
                         .tremor_m = 0.001,
                         .turn_sway = 2.5 * kDegree,
                         .turn_tremor = 0.2 * kDegree,
                         .misread_place = 0.2,
                         .misread_color = 0.3,
                         .misjudged_course = 12 * kDegree,
                         .spring_hz = 1.3,
                         .damping = 0.5,
                         .aim_per_s = 1.5,
                         .looks_away = true,
                         .rushes = true};
constexpr double kGlanceS = 1.5, kRushS = 1.2, kRushFactor = 2.5;
constexpr double kHardestPush = 2.5;  // metres per second squared

// A glance away, or a rush.
struct Moment {
  double start_s, length_s;
  double yaw = 0, pitch = 0;
  // Rises from 0 to 1 and falls back to 0.
  double Share(double time_s) const {
    const double since = (time_s - start_s) / length_s;
    if (since <= 0 || since >= 1) return 0;
    const double rise = std::sin(M_PI * since);
    return rise * rise;
  }
};

// Describes what the person wants the hand to do: in the camera's own axes, metres and radians per second.
struct Intention {
  Vector3d velocity = Vector3d::Zero();
  Vector3d turn = Vector3d::Zero();  // besides what keeps a subject at arm's length in view
};

// Describes what a person who looks at the display knows at a moment.
struct Perception {
  double time_s = 0;
  ShownPicture picture;
  Instruction instruction;

  // Null unless the dot on the sphere is in the picture.
  const ShownSphere* Sphere() const {
    if (!picture.sphere) return nullptr;
    const auto dot = picture.camera.ImgFromCam(picture.sphere->PointInCam(picture.sphere->toward_camera));
    const bool seen = dot && (dot->array() > 0).all() && dot->x() < picture.camera.width &&
                      dot->y() < picture.camera.height;
    return seen ? &*picture.sphere : nullptr;
  }
  bool Refuses(Reason reason) const {
    return instruction.kind == InstructionKind::kMendFrames && instruction.reason == reason;
  }
  // Returns how much nearer the line says to go, a share of the distance: below 0 to go back.
  std::optional<double> NearerSaid(double distance_m) const {
    if (!instruction.length) return std::nullopt;
    const double share = instruction.length->ShareOf(distance_m);
    return instruction.kind == InstructionKind::kComeNearer ? share : -share;
  }
};

Quaterniond Turned(const Vector3d& by) {
  const double angle = by.norm();
  return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, by / angle)) : Quaterniond::Identity();
}

}  // namespace

OperatorOptions OperatorOptions::Parse(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  OperatorOptions options;
  options.follows_guidance = name == "guided" || name == "novice";
  options.novice = name == "novice" || name == "unguided-novice";
  bool good = options.follows_guidance || options.novice || name == "unguided";
  if (colon != std::string::npos) {
    const char* begin = text.data() + colon + 1;
    const char* end = text.data() + text.size();
    const auto [parsed, error] = std::from_chars(begin, end, options.seed);
    good &= error == std::errc() && parsed == end;
  }
  if (!good)
    throw Refusal(
        "", text, fmt::format("'{}' is no simulated operator", text),
        "there are guided, unguided, novice and unguided-novice, each with a seed if wanted: novice:7");
  return options;
}

struct SimulatedOperator::Person {
  struct Body {
    Vector3d center;
    Quaterniond cam_from_world;
  };

  Person(const OperatorOptions& options, const OperatorStart& start)
      : options(options),
        habits(options.novice ? kNovice : kExperienced),
        up(start.up_in_world.normalized()),
        reach(start.distance),
        body{start.cam_from_world.OriginInSource(), start.cam_from_world.rotation},
        rows(options.seed, options.novice),
        course_error(options.seed, 201, 3, 0.1, 0.6, habits.misjudged_course),
        color_error(options.seed, 202, 3, 0.02, 0.12, habits.misread_color),
        place_error{acquisition::Waves(options.seed, 203, 3, 0.2, 1, habits.misread_place),
                    acquisition::Waves(options.seed, 204, 3, 0.2, 1, habits.misread_place)} {
    for (int axis = 0; axis < 3; ++axis) {
      sway[axis] = acquisition::Waves(options.seed, 210 + axis, 3, 0.15, 0.8, habits.sway_m);
      sway[axis].Add(acquisition::Waves(options.seed, 220 + axis, 4, 4, 9, habits.tremor_m));
      turn_sway[axis] = acquisition::Waves(options.seed, 230 + axis, 3, 0.1, 0.5, habits.turn_sway);
      turn_sway[axis].Add(acquisition::Waves(options.seed, 240 + axis, 4, 4, 9, habits.turn_tremor));
    }
    std::mt19937_64 random(options.seed * 1000003u + 5u);
    const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
    constexpr double kLongestS = 3600;
    if (habits.looks_away)
      for (double at = 12 + 10 * uniform(); at < kLongestS; at += 8 + 22 * uniform()) {
        const double side = uniform() < 0.5 ? -1 : 1;
        glances.push_back(
            {at, kGlanceS, side * (30 + 18 * uniform()) * kDegree, (12 * uniform() - 4) * kDegree});
      }
    if (habits.rushes)
      for (double at = 10 + 10 * uniform(); at < kLongestS; at += 6 + 14 * uniform())
        rushes.push_back({at, kRushS});
    past.push_back(body);
  }

  double Glances(double time_s, Vector2d* turn = nullptr) const {
    double most = 0;
    for (const Moment& glance : glances) {
      if (glance.start_s > time_s) break;
      const double share = glance.Share(time_s);
      most = std::max(most, share);
      if (turn) *turn += share * Vector2d(glance.yaw, glance.pitch);
    }
    return most;
  }
  double Rush(double time_s) const {
    double most = 0;
    for (const Moment& rush : rushes) {
      if (rush.start_s > time_s) break;
      most = std::max(most, rush.Share(time_s));
    }
    return 1 + (kRushFactor - 1) * most;
  }

  void Decide(const Perception& seen, double now_s);
  Vector3d Starting(double now_s) const;
  Intention GoingBack(double now_s) const;
  Intention Following(const Perception& seen, double now_s);
  Vector3d Aiming(const Perception& seen) const;
  double Pace(const Perception& seen, double now_s);
  Vector3d Goal(const ShownSphere& sphere, double now_s) const;
  double Nearer(const Perception& seen, const ShownSphere& sphere, double now_s) const;
  void Step();
  void ReachUntil(double time_s);
  Body At(double time_s) const;

  const OperatorOptions options;
  const Habits habits;
  const Vector3d up;
  const double reach;

  // The hand without its tremor.
  Body body;
  Vector3d velocity = Vector3d::Zero(), push = Vector3d::Zero();  // in the camera's axes
  Vector3d spin = Vector3d::Zero(), spin_push = Vector3d::Zero();
  Intention intention;
  std::deque<Body> past;  // every kStepS
  long first_step = 0, steps = 0;

  std::deque<Perception> seen;  // the person acts on the first one once it is old enough
  bool acted = false;
  bool has_tracked = false;
  std::optional<Body> last_tracked;  // where the hand was then
  double slowed_until_s = 0;
  RowsByEye rows;
  std::optional<CapFrame::Angles> by_eye;
  double looked_s = -1;

  acquisition::Waves course_error, color_error;
  std::array<acquisition::Waves, 2> place_error;
  std::array<acquisition::Waves, 3> sway, turn_sway;
  std::vector<Moment> glances, rushes;
};

// Sideways, to and fro, farther each time: a map needs translation, and turning the camera gives none.
Vector3d SimulatedOperator::Person::Starting(double now_s) const {
  constexpr double kPeriodS = 3.2;
  const double wider = std::min(2.0, 1 + now_s / 20);
  const double phase = 2 * M_PI * now_s / kPeriodS;
  return reach * habits.speed * 0.6 * wider * Vector3d(std::cos(phase), 0.25 * std::cos(0.5 * phase), 0);
}

// To the place where tracking last worked, as the display asks.
Intention SimulatedOperator::Person::GoingBack(double now_s) const {
  Intention back;
  if (!last_tracked || Glances(now_s) > 0) return back;
  const Vector3d way = body.cam_from_world * (last_tracked->center - body.center);
  back.velocity = 1.5 * way;
  const double fastest = 0.7 * reach * habits.speed;
  if (back.velocity.norm() > fastest) back.velocity *= fastest / back.velocity.norm();
  const Eigen::AngleAxisd turn(body.cam_from_world * last_tracked->cam_from_world.conjugate());
  back.turn = 1.5 * std::remainder(turn.angle(), 2 * M_PI) * turn.axis();
  return back;
}

// The arrow to a subject outside it gives the direction, not the angle.
Vector3d SimulatedOperator::Person::Aiming(const Perception& seen) const {
  constexpr double kBlindTurn = 0.35;
  if (const auto& way = seen.picture.way_to_subject)
    return habits.aim_per_s * kBlindTurn * Vector3d(-way->y(), way->x(), 0);
  const ShownSphere* sphere = seen.Sphere();
  if (!sphere) return Vector3d::Zero();
  const Vector3d ahead = -sphere->toward_camera;
  return habits.aim_per_s * Vector3d(-std::atan2(ahead.y(), ahead.z()), std::atan2(ahead.x(), ahead.z()), 0);
}

double SimulatedOperator::Person::Pace(const Perception& seen, double now_s) {
  double pace = Rush(now_s) * (1 - Glances(now_s));
  if (seen.Refuses(Reason::kSpeed) || seen.Refuses(Reason::kBlur)) slowed_until_s = now_s + 0.7;
  if (now_s < slowed_until_s) pace *= 0.6;
  if (!seen.picture.held) pace *= 0.3;
  return pace;
}

// Returns the middle of the ring, read with an error.
Vector3d SimulatedOperator::Person::Goal(const ShownSphere& sphere, double now_s) const {
  const Vector3d& at = sphere.target->direction;
  const Vector3d x = at.unitOrthogonal(), y = at.cross(x);
  return (at + sphere.target->ring * (place_error[0].At(now_s) * x + place_error[1].At(now_s) * y))
      .normalized();
}

// Returns how much nearer to go, a share of the distance. The line names large shares. Small ones are read
// from the colours about the dot, which have no scale: the person moves until they are green.
double SimulatedOperator::Person::Nearer(const Perception& seen, const ShownSphere& sphere,
                                         double now_s) const {
  if (const auto said = seen.NearerSaid(reach); said && options.follows_guidance) return *said;
  constexpr double kFaint = 0.15, kFull = 0.12, kAboutTheDot = 12 * kDegree;
  std::vector<double> colors;
  const CapFrame::Angles dot = sphere.frame.Of(sphere.toward_camera);
  for (const ShownSphere::Paint& paint : sphere.paint) {
    if (paint.bottom > dot.elevation + kAboutTheDot || paint.top < dot.elevation - kAboutTheDot) continue;
    const Vector3d middle =
        sphere.frame.Direction(0.5 * (paint.left + paint.right), 0.5 * (paint.bottom + paint.top));
    if (middle.dot(sphere.toward_camera) > std::cos(kAboutTheDot)) colors.push_back(paint.nearer);
  }
  if (colors.empty()) return 0;
  const double read = std::clamp(Median(std::move(colors)), -1.0, 1.0) + color_error.At(now_s);
  return std::abs(read) < kFaint ? 0 : kFull * read;
}

Intention SimulatedOperator::Person::Following(const Perception& seen, double now_s) {
  Intention wanted;
  if (Glances(now_s) == 0 && Glances(now_s - habits.delay_s) == 0) wanted.turn = Aiming(seen);
  const double pace = Pace(seen, now_s);
  const ShownSphere* sphere = seen.Sphere();
  if (!sphere) return wanted;

  std::optional<Vector3d> toward;
  if (options.follows_guidance) {
    if (sphere->target) toward = Goal(*sphere, now_s);
  } else {
    constexpr double kLookEveryS = 0.2;
    if (now_s - looked_s >= kLookEveryS) {
      by_eye = rows.Toward(*sphere, now_s);
      looked_s = now_s;
    }
    if (by_eye) toward = sphere->frame.Direction(by_eye->azimuth, by_eye->elevation);
  }
  if (toward) {
    constexpr double kSlowsPerS = 2.2;
    const Vector3d& dot = sphere->toward_camera;
    const Vector3d tangent = *toward - toward->dot(dot) * dot;
    if (tangent.norm() > 1e-9) {
      const Vector3d course = Turned(course_error.At(now_s) * dot) * tangent.normalized();
      wanted.velocity =
          reach * std::min(habits.speed * pace, kSlowsPerS * sphere->AngleFromDot(*toward)) * course;
    }
  }
  constexpr double kNearerPerS = 1.0;
  const double nearer = std::clamp(Nearer(seen, *sphere, now_s), -0.2, 0.2);
  wanted.velocity -= reach * kNearerPerS * nearer * sphere->toward_camera;
  return wanted;
}

// The display shows the sphere and the rectangle while the pose is known; while it is not, the line says what
// to do.
void SimulatedOperator::Person::Decide(const Perception& now, double now_s) {
  const bool tracked = now.picture.rectangle.has_value();
  if (tracked) {
    has_tracked = true;
    last_tracked = At(now.time_s);
  }
  const bool is_lost =
      now.instruction.kind == InstructionKind::kReturn || now.instruction.reason == Reason::kInsideSphere;
  if (tracked && now.picture.sphere)
    intention = Following(now, now_s);
  else if (has_tracked && is_lost)
    intention = GoingBack(now_s);
  else
    intention = {.velocity = Starting(now_s)};
}

void SimulatedOperator::Person::Step() {
  const double now_s = static_cast<double>(steps) * kStepS;
  if (!has_tracked && seen.empty()) intention = {.velocity = Starting(now_s)};
  while (seen.size() > 1 && seen[1].time_s <= now_s - habits.delay_s) {
    seen.pop_front();
    acted = false;
  }
  if (!seen.empty() && !acted && seen.front().time_s <= now_s - habits.delay_s) {
    Decide(seen.front(), now_s);
    acted = true;
  }
  const double rate = 2 * M_PI * habits.spring_hz;
  const auto follow = [&](const Vector3d& wanted, Vector3d& is, Vector3d& pushed, double hardest) {
    pushed += kStepS * (rate * rate * (wanted - is) - 2 * habits.damping * rate * pushed);
    if (pushed.norm() > hardest) pushed *= hardest / pushed.norm();
    is += kStepS * pushed;
  };
  follow(intention.velocity, velocity, push, kHardestPush);
  // A person who walks round the subject turns with the movement, and keeps the camera level.
  const Vector3d up_in_cam = body.cam_from_world * up;
  const Vector3d turn =
      intention.turn + Vector3d(velocity.y() / reach, -velocity.x() / reach, 2 * up_in_cam.x());
  follow(turn, spin, spin_push, kHardestPush * 4);
  body.center += kStepS * (body.cam_from_world.conjugate() * velocity);
  body.cam_from_world = (Turned(-kStepS * spin) * body.cam_from_world).normalized();
  ++steps;
  past.push_back(body);
  while (static_cast<double>(past.size()) * kStepS > kRememberedS) {
    past.pop_front();
    ++first_step;
  }
}

void SimulatedOperator::Person::ReachUntil(double time_s) {
  while (static_cast<double>(steps) * kStepS < time_s) Step();
}

SimulatedOperator::Person::Body SimulatedOperator::Person::At(double time_s) const {
  const double at = std::clamp(time_s / kStepS - static_cast<double>(first_step), 0.0,
                               static_cast<double>(past.size() - 1));
  const auto before = std::min(static_cast<std::size_t>(at), past.size() - 1);
  const auto after = std::min(before + 1, past.size() - 1);
  const double share = at - static_cast<double>(before);
  return {(1 - share) * past[before].center + share * past[after].center,
          past[before].cam_from_world.slerp(share, past[after].cam_from_world)};
}

SimulatedOperator::SimulatedOperator(const OperatorOptions& options, const OperatorStart& start)
    : person_(std::make_unique<Person>(options, start)) {}
SimulatedOperator::~SimulatedOperator() = default;

void SimulatedOperator::See(double time_s, const CaptureState& state) {
  person_->seen.push_back({time_s, ShownPicture::Of(state), InstructionFor(state)});
}

Rigid3 SimulatedOperator::CamFromWorld(double time_s) const {
  person_->ReachUntil(time_s);
  const Person::Body body = person_->At(time_s);
  Vector2d glance = Vector2d::Zero();
  person_->Glances(time_s, &glance);
  const auto& sway = person_->sway;
  const auto& turn = person_->turn_sway;
  const Vector3d center = body.center + Vector3d(sway[0].At(time_s), sway[1].At(time_s), sway[2].At(time_s));
  const Quaterniond turned =
      Turned(Vector3d(turn[0].At(time_s) + glance.y(), turn[1].At(time_s) + glance.x(), turn[2].At(time_s)));
  const Quaterniond rotation = (turned * body.cam_from_world).normalized();
  return {rotation, -(rotation * center)};
}

std::shared_ptr<SimulatedOperator> MakeSimulatedOperator(const DeviceUri& uri, const std::string& text) {
  const OperatorOptions options = OperatorOptions::Parse(text);
  const std::vector<std::string> scenes = acquisition::Scene::Names();
  if (uri.scheme != "sim" || std::ranges::find(scenes, uri.path) == scenes.end())
    throw Refusal(Parameter("operator"), text, fmt::format("{} is not a simulated scene", uri.Text()),
                  "a simulated person can hold nothing else");
  const auto scene = acquisition::Scene::Named(uri.path);
  const Vector3d center = scene->subject().center_in_world;
  return std::make_shared<SimulatedOperator>(
      options,
      OperatorStart{.cam_from_world = LookAt(center + scene->FirstDistance() * scene->FirstDirection(),
                                             center, scene->UpInWorld()),
                    .up_in_world = scene->UpInWorld(),
                    .distance = scene->FirstDistance()});
}

}  // namespace ulf::coverage
