// Machine-vision cameras (GigE Vision, USB3 Vision) through Aravis: `aravis:ID?option=value&...`.
//
// ID: an IPv4 address (opened at once), a serial number, one of Aravis's own ids (Vendor-Serial,
// Vendor-Model-Serial), a hardware address; empty: the first camera found. All but an address take the second
// that discovery takes.
//
//   exposure_us  exposure time; auto exposure is switched off   else: as the camera is
//   gain_db      gain; auto gain is switched off                else: as the camera is
//   fps          frame rate                                     else: as the camera is
//   format       PFNC name                                      else: the best supported one (pixel_format.h)
//   roi          WxH+X+Y on the sensor                          else: the whole sensor
//   packet_size  GigE Vision bytes a packet                     else: negotiated; 7800 on this computer
//   queue        frames that may wait for the reader            else: 4
//
// A camera keeps what the last program wrote: the whole configuration is written on opening, with no trigger
// and no binning. Exposure and gain are read back and stand in every frame; gain is linear, 10^(dB/20), and 1
// where the camera counts in units of its own; exposure is 0 (unknown) while the camera's auto exposure is
// on.
//
// Frame::device_time_s is the camera's clock at the start of the frame. A thread takes frames from the
// library's buffers into a bounded queue; when the reader is slow the oldest goes and is counted. Frames with
// pixels missing are delivered as kIncomplete and counted, but for the very first of a stream, which meets a
// receive buffer of the system's size; gaps in the frame numbers are counted as missing.
//
// The device is lost (kLost) when the control channel breaks or another program takes it, or when no frame
// has come for 5.5 s or ten periods, whichever is longer; Info().problem then says which. What the library
// still holds is torn down behind, because that blocks for seconds once the camera is gone; the process waits
// for it at its end.
#pragma once

#include <memory>

#include "acquisition/device.h"

namespace ulf {

std::unique_ptr<Device> OpenAravisDevice(const DeviceUri& uri);

}  // namespace ulf
