// Opens machine-vision cameras (GigE Vision, USB3 Vision) through Aravis: `aravis:ID?option=value&...`.
//
// ID: an IPv4 address (opened at once), a serial number, one of Aravis's ids (Vendor-Serial,
// Vendor-Model-Serial) or a hardware address, each found by discovery, which takes a second; empty: the first
// camera found.
//
// The options, with their units and defaults, are those of docs/devices.md#options-of-aravis.
//
// A camera keeps the settings of the last program, so opening writes the whole configuration. Exposure, gain
// and black level are read back and stand in every frame: gain is linear, 10^(dB/20), and 1 where the camera
// counts in units of its own; exposure is 0 (unknown) while the camera's auto exposure is on; the black level
// is taken as counts of the pixel format unless the camera calls it a percentage. A setting that the camera
// changed is a kNotice, and so is an automatic that was switched off: from then on Info().uri contains the
// value that it had reached (aravis_automatics.h).
//
// Opening a camera that another program controls waits as long as a killed program's control lasts, with a
// message on the log that names the controller; after that it is an Error. A URI that asks for what the
// camera cannot do is a Refusal.
//
// trigger=software: Next() fires a trigger when no frame waits, and no other before its frame has come (or is
// a second overdue). So each call gets a frame that was taken after the call.
//
// Frame::device_time_s is the camera's clock at the start of the frame. A thread moves frames from the
// library's buffers into a bounded queue; when the reader is slow the oldest frame is dropped and counted.
// Frames with missing pixels are delivered as kIncomplete and counted, except the first of a stream, which
// meets a receive buffer of the system's size. Gaps in the frame numbers are counted as missing.
//
// Without a frame that is due for half a second (three periods) the device reports kStalled and asks the
// camera four times a second who controls it. The device is lost (kLost, with the reason in Info().problem)
// when nobody controls the camera (it was restarted), when its control channel breaks (the library's
// heartbeat: five seconds), or when it answers and yet sends nothing for three seconds or ten periods
// (aravis_watch.cpp). What the library still holds of a lost camera is closed in the background, because that
// blocks for seconds; the process waits for it at its end.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"

namespace ulf::acquisition {

std::unique_ptr<Device> OpenAravisDevice(const DeviceUri& uri);

// The GenICam tree of a machine-vision camera, for `ulf features`.
//
// List() returns the features of all categories, those outside the tree last; Find() also finds features that
// are in no category (some makers leave AcquisitionFrameRate out). A camera that another program controls can
// be read, not written.
std::unique_ptr<FeatureAccess> OpenAravisFeatures(const DeviceUri& uri);

// Returns the id that the library opens for the ID of a URI (what an ID may be stands above): at once for an
// address, after a second of discovery for anything else. Throws Error that lists the cameras found.
std::string ResolveAravis(const std::string& uri, const std::string& id);

// Returns every camera on every network and USB port; takes about a second. Where a camera cannot be opened,
// `problem` says why and what to do: another program controls it (which one, where the camera tells), it is
// in another network, or this user may not open the USB device.
std::vector<DeviceInfo> ListAravisDevices();

}  // namespace ulf::acquisition
