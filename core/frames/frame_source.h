// Where frames come from, by what whoever runs the program can still change about them. All advice asks it, so that it
// names only what can be changed (tests/commands/capture/advice_test.cpp goes over all of it).
#pragma once

#include <array>

namespace ulf {

enum class FrameSource {
  kSettableCamera,  // a camera in the hand, whose settings `ulf features` and the URI change
  kCamera,          // a camera in the hand, whose settings its URI changes, if anything does (the simulator)
  kRecording,       // frames of one motion that are taken already: a video, a recorded session
  kPhotographs,     // pictures that are taken already: the files of a folder, a light field's views
};
inline constexpr std::array kFrameSources{FrameSource::kSettableCamera, FrameSource::kCamera,
                                          FrameSource::kRecording, FrameSource::kPhotographs};

// Pictures that are taken already: no camera can be moved or set, no lamp and no subject be changed.
inline bool IsTaken(FrameSource source) {
  return source == FrameSource::kRecording || source == FrameSource::kPhotographs;
}

// Where a camera's settings are changed: "set the exposure (...)".
inline const char* WhereToSet(FrameSource source) {
  return source == FrameSource::kSettableCamera ? "in the URI, by ulf features, or at the camera"
                                                : "in the URI, or at the camera";
}

}  // namespace ulf
