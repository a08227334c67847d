// The keys and what they do, as the person at the display is told.
#pragma once

#include "render/display/plain_panels.h"

namespace ulf::coverage {

inline constexpr render::KeyHelp kKeysAlways[] = {{"Space", "pause, go on"},
                                                  {"Backspace", "take back the last view"},
                                                  {"S", "subject: place its sphere"},
                                                  {"R", "review what is recorded"},
                                                  {"P", "other colours (colour-blind)"},
                                                  {"L", "legend"},
                                                  {"Z", "close look at the map"},
                                                  {"I", "check list"},
                                                  {"M", "sound on leaving the rectangle"},
                                                  {"F or F11", "full screen"},
                                                  {"?", "these keys"},
                                                  {"Q", "finish: closes the light field"}};
inline constexpr render::KeyHelp kKeysInSubject[] = {{"C", "around the middle"},
                                                     {"Up Down wheel", "farther, nearer"},
                                                     {"PgUp PgDn", "in big steps"},
                                                     {"Left Right", "smaller, larger"},
                                                     {"Shift arrows", "across the picture"},
                                                     {"drag", "left moves, right resizes"},
                                                     {"A", "augmented aperture"},
                                                     {"Enter", "take over"},
                                                     {"Esc", "leave as it was"}};
inline constexpr render::KeyHelp kKeysInReview[] = {{"C", "other control"},
                                                    {"arrows, drag", "round the subject"},
                                                    {"PgUp PgDn", "nearer, farther"},
                                                    {"W", "wipe against live"},
                                                    {", .", "move the wipe"},
                                                    {"B", "blink against live"},
                                                    {"Delete", "take back the marked view"},
                                                    {"R or Esc", "back"}};

}  // namespace ulf::coverage
