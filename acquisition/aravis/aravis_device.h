// Machine-vision cameras (GigE Vision, USB3 Vision) through Aravis: `aravis:ID?option=value&...`.
//
// ID: an IPv4 address (opened at once), a serial number, one of Aravis's own ids (Vendor-Serial,
// Vendor-Model-Serial), a hardware address; empty: the first camera found. All but an address take the second
// that discovery takes.
//
//   user_set           the camera's own settings loaded first: Default, UserSet1, ...    else: none
//   exposure_us        exposure time; auto exposure is switched off           else: as the camera is
//   gain_db            gain; auto gain is switched off                        else: as the camera is
//   gain_raw           the same for a camera that counts in units of its own
//   black_level        in the camera's unit; its automatic is switched off    else: as the camera is
//   white_balance      RED,BLUE as ratios to green, or auto: by the camera, once at each start
//   auto_exposure, auto_gain, auto_white_balance, auto_black_level
//                      on: continuous; off: at once    else: what is on settles, then is switched off and
//                      held
//   settle             seconds that automatics get for that                   else: 1
//   fps                frame rate                                             else: as the camera is
//   format             PFNC name                        else: the best supported one (pixel_format.h)
//   binning            2x2                                                    else: none
//   roi                WxH+X+Y in pixels of the image, after binning, in the camera's steps, of a mosaic
//                      with even offsets                                      else: the whole sensor
//   trigger            software, or the camera's name for a line (Line0)      else: free, without one
//   chunks             on: exposure, gain, number and time of each frame from the camera itself, if offered
//   packet_size        GigE Vision bytes a packet                 else: negotiated; 7800 on this computer
//   packet_delay_ns    pause between packets: several cameras on one link     else: 0
//   resend             on, off: ask again for packets that did not come       else: on
//   packet_timeout_ms  before a packet is asked for again                     else: the library's
//   frame_retention_ms after the last packet, before a frame is given up      else: the library's
//   socket_buffer      bytes that the system may hold         else: two frames, at least two megabytes
//   buffers            frames the library may fill at once                    else: 4 to 24, by size
//   priority           high, realtime: of the receiving thread, if the system lets us    else: normal
//   queue              frames that may wait for the reader                    else: 4
//
// A camera keeps what the last program wrote: the whole configuration is written on opening. Exposure, gain
// and black level are read back and stand in every frame; gain is linear, 10^(dB/20), and 1 where the camera
// counts in units of its own; exposure is 0 (unknown) while the camera's auto exposure is on; the black level
// is taken for counts of the pixel format unless the camera calls it a percentage. What the camera made
// different is a kNotice, and so is an automatic that was switched off: from then on Info().uri names what it
// had reached, so that the camera opened again by it takes the same pictures (aravis_automatics.h).
//
// A camera that another program controls is waited for until a killed program's control would have ended,
// after a word on the log that says whose it is; then it is an Error. A URI that asks for what the camera
// cannot do is a UsageError.
//
// trigger=software: Next() fires one when nothing waits, and no other before its frame is there (or is a
// second overdue). So each call gets a frame of its own, taken after the call.
//
// Frame::device_time_s is the camera's clock at the start of the frame. A thread takes frames from the
// library's buffers into a bounded queue; when the reader is slow the oldest goes and is counted. Frames with
// pixels missing are delivered as kIncomplete and counted, but for the very first of a stream, which meets a
// receive buffer of the system's size; gaps in the frame numbers are counted as missing.
//
// After half a second (three periods) without a frame that is due: kStalled, and the camera is asked directly
// who controls it, four times a second. The device is lost (kLost, Info().problem says why) when the camera
// says that nobody does (it was restarted), when its control channel breaks (the library's heartbeat: five
// seconds), or when it answers and yet sends nothing for three seconds or ten periods. What the library still
// holds of a camera that is gone is torn down behind, because that blocks for seconds; the process waits for
// it at its end.
#pragma once

#include <memory>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

std::unique_ptr<Device> OpenAravisDevice(const DeviceUri& uri);

}  // namespace ulf::acquisition
