// Doors by which cameras come in (fuzz_targets.h): what arrives by a cable or a network. Aravis itself reads streams and
// descriptions; here is what our code makes of bytes before and behind it.
#pragma once

#include <string_view>

namespace ulf::test {

// A picture as it came, behind a line `FORMAT WIDTH HEIGHT ROW_BYTES` (core/frames/pixel_format.h).
void CameraImageDoor(std::string_view bytes);

// A camera's answer to a discovery packet.
void GigeAnswerDoor(std::string_view bytes);

// Requests to the simulated camera, each behind its length in two bytes, big-endian. What its filter lets through lies
// within its registers and is written by who controls it.
void GvcpRequestsDoor(std::string_view bytes);

}  // namespace ulf::test
