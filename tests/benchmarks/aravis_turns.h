// Our device against a bare loop of the library that it is built on: short turns at one camera, with the same
// size of picture and number of frames that may wait.
#pragma once

#include <benchmark/benchmark.h>

#include <functional>
#include <string>
#include <vector>

namespace ulf {

inline constexpr int kSlack = 16;  // frames that may wait

struct Size {
  int width, height;
};
Size SizeOf(const benchmark::State& state);  // of its first two arguments

struct Turn {
  double fps = 0, cpu_ms = 0;  // of this process, a frame
  int broken = 0;
  std::vector<double> latencies_ms = {};  // where a number of frames was wanted
};

// Takes frames for `kTurnS`, or as many as are wanted.
Turn OurTurn(const std::string& uri, std::size_t frames_wanted = 0);

struct BareStream {
  const char* camera;  // null: the first that is found
  Size size;
  double fps = 0;
  int gige_packet_bytes = 0;  // none: not GigE Vision
};
// The shortest program that takes every frame of such a stream.
Turn BareTurn(const BareStream& stream, std::size_t frames_wanted = 0);

// Fifteen turns of each: frames a second and the ratio ours / bare (median, least, greatest), processor time,
// and frames that did not arrive whole.
void TellThroughput(benchmark::State& state, const std::function<Turn()>& ours,
                    const std::function<Turn()>& bare);

}  // namespace ulf
