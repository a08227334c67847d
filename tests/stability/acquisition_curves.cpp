// Cameras that lose part of what they send. Each is taken from in a process of its own (lossy_camera.cpp).
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "core/base/error.h"
#include "tests/measure/curve.h"
#include "tests/support/child_process.h"

namespace ulf::test {
namespace {

constexpr int kCannot = 3;
constexpr double kLeastWhole = 0.6;  // of the frames that a webcam sent whole; a busy machine misses some

struct Outcome {
  unsigned whole = 0, could = 0, others = 0, uncounted = 0, damaged = 0, said = 0;  // as lossy_camera tells
};

std::vector<std::string> Command(const std::string& kind) {
  // What stands in for the kernel must be loaded first.
  if (kind == "link") return {LOSSY_CAMERA, kind};
  return {"/usr/bin/env", "LD_PRELOAD=" UMOCKDEV_PRELOAD, LOSSY_CAMERA, kind};
}

std::optional<std::string> WhyNot(const std::string& kind) {
  ChildProcess probe(Command(kind));
  const std::string said = probe.ReadUntil("\n", 20);
  return probe.Wait(20) == kCannot ? std::optional(said) : std::nullopt;
}

Outcome Take(const std::string& kind, double how_much, unsigned seed) {
  std::vector<std::string> command = Command(kind);
  command.push_back(fmt::format("{}", how_much));
  command.push_back(fmt::format("{}", seed));
  ChildProcess camera(command);
  const std::string said = camera.ReadUntil("whole", 60);
  Outcome outcome;
  if (std::sscanf(said.c_str(), "whole %u could %u others %u uncounted %u damaged %u said %u", &outcome.whole,
                  &outcome.could, &outcome.others, &outcome.uncounted, &outcome.damaged, &outcome.said) != 6)
    throw Error("lossy_camera {} {}: {}", kind, how_much, said);
  camera.Wait(20);
  return outcome;
}

// Right: what is given as whole is, all others are counted, and of those that could be whole enough are.
Verdict Judge(const Outcome& outcome, double least_whole) {
  if (outcome.damaged > 0 || outcome.uncounted > 0 || !outcome.said) return Verdict::kWrong;
  return outcome.whole > 0 && outcome.whole >= least_whole * outcome.could ? Verdict::kRight
                                                                           : Verdict::kSaidSo;
}

double NotWhole_pct(const Outcome& outcome) {
  const unsigned all = outcome.whole + outcome.others;
  return all > 0 ? 100.0 * outcome.others / all : std::numeric_limits<double>::quiet_NaN();
}

Trial Lossy(const std::string& kind, double share, double least_whole, unsigned seed) {
  const Outcome outcome = Take(kind, share, seed);
  return {Judge(outcome, least_whole), NotWhole_pct(outcome)};
}

Trial Holed(double bytes, unsigned seed) {
  const Outcome outcome = Take("holes", bytes, seed);
  return {Judge(outcome, kLeastWhole), 100.0 * outcome.damaged / std::max(1u, outcome.whole)};
}

CURVE(camera_lossy_link,
      {.stage = "Cameras",
       .title = "A GigE Vision link that loses packets",
       .about =
           R"(A camera of 50 frames a second in 59 packets each, behind a relay that loses packets, also
  those that are sent again. Right: 95 % of the frames are whole, to the pixel. Where fewer are, counting
  the others as incomplete or missing says so.)",
       .driven = {Log("packets lost [%]"), {0.1, 1, 3, 10, 20, 30, 50, 70, 100}, 1, 70},
       .error = {"frames that are not whole [%]"},
       .trial = [](double percent, unsigned seed) { return Lossy("link", percent / 100, 0.95, seed); },
       .seeds = 5,
       .why_not = [] { return WhyNot("link"); }});

CURVE(camera_lossy_webcam,
      {.stage = "Cameras",
       .title = "A webcam that loses frames",
       .about =
           R"(An emulated webcam, 100 frames a second, of which some never arrive, come marked as damaged or
  are cut in two. Right: 60 % of those that were sent whole come (a busy machine misses some), whole to the
  byte, and all others are counted, which says so.)",
       .driven = {Log("frames lost or damaged [%]"), {1, 3, 10, 30, 50, 70, 90, 97, 100}, 10, 100},
       .error = {"frames that are not whole [%]"},
       .trial = [](double percent,
                   unsigned seed) { return Lossy("webcam", percent / 100, kLeastWhole, seed); },
       .seeds = 5,
       .why_not = [] { return WhyNot("webcam"); }});

CURVE(
    camera_jpeg_holes,
    {.stage = "Cameras",
     .title = "A webcam whose JPEGs have holes",
     .about =
         R"(640 x 480 JPEGs of some 45,000 bytes; every third lacks bytes in the middle, as a lost USB
  packet leaves it. Right: those are counted as incomplete, and 60 % of the others come.)",
     .driven = {Log("bytes that are missing"),
                {10000, 3000, 2000, 1000, 500, 300, 180, 100, 60, 30, 10},
                3000,
                180},
     .error = {"damaged among those given as whole [%]"},
     .trial = Holed,
     .seeds = 5,
     .wrong_from = 100,
     .why_wrong = "the code of a JPEG falls into step again behind a hole, and where no block is left over, "
                  "nothing in the file tells. USB packets of webcams carry some 180 bytes or more.",
     .why_not = [] { return WhyNot("webcam"); }});

}  // namespace
}  // namespace ulf::test
