// Opens machine-vision cameras (GigE Vision, USB3 Vision) through Aravis: `aravis:ID?option=value&...`.
//
// ID: an IPv4 address (opened at once), a serial number, one of Aravis's ids (Vendor-Serial,
// Vendor-Model-Serial) or a hardware address, each found by discovery, in a second; empty: the first found.
//
// The options, with their units and defaults, are those of docs/devices.md#options-of-aravis.
//
// A camera keeps the settings of the last program, so opening writes the whole configuration. Exposure, gain
// and black level are read back and stand in every frame: gain is linear, 10^(dB/20), and 1 (unknown) while
// auto gain is on or if the camera counts in units of its own; exposure is 0 (unknown) while auto exposure is
// on; the black level is taken as counts of the pixel format unless the camera calls it a percentage. The
// device reports as kNotice each setting that the camera changed and each automatic that was switched off;
// from then on Info().uri contains the value that the automatic had reached (aravis_automatics.h).
//
// Opening a camera that another program controls waits as long as a killed program's control lasts, with a
// message on the log that names the controller; then it throws Error. It throws Refusal for a URI that asks
// for what the camera cannot do.
//
// trigger=software: Next() fires a trigger when no frame waits, and fires again only after that frame has
// come or has not come for a second or three frame periods, whichever is longer. So each call gets a frame
// that was taken after the call.
//
// Frame::device_time_s is the camera's clock at the start of the frame. A thread moves frames from the
// library's buffers into a bounded queue; when the reader is slow the oldest frame is dropped and counted.
// Frames with missing pixels are counted and delivered as kIncomplete, except the first frame of a stream,
// which is counted only. Gaps in the frame numbers are counted as missing.
//
// When a frame is due and none has come for half a second or three frame periods, whichever is longer, the
// device reports kStalled and asks a GigE Vision camera four times a second who controls it. The device is
// lost (kLost, with the reason in Info().problem) when nobody controls the camera (it was restarted), when
// its control channel breaks (the library's heartbeat notices within five seconds), or when the camera
// answers but sends nothing for three seconds or ten periods (aravis_watch.cpp). A lost camera is closed in
// the background, because that blocks for seconds; the process waits for it at its end.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"

namespace ulf::acquisition {

std::unique_ptr<Device> OpenAravisDevice(const DeviceUri& uri);

// Opens the GenICam tree of a machine-vision camera, for `ulf features`. Throws as OpenAravisDevice().
//
// List() returns the features of all categories, those outside the tree last; Find() also finds features that
// are in no category (some makers leave AcquisitionFrameRate out). A camera that another program controls can
// be read, not written.
std::unique_ptr<FeatureAccess> OpenAravisFeatures(const DeviceUri& uri);

// Returns the name under which the library opens the camera `id`, an ID as above: at once for an address,
// after a second of discovery for anything else. Throws Error with a list if none or several match.
std::string ResolveAravis(const std::string& uri, const std::string& id);

// Returns every camera on every network and USB port; takes about a second. Where a camera cannot be opened,
// `problem` says why and what to do: another program controls it (which one, where the camera tells), it is
// in another network, or this user may not open the USB device.
std::vector<DeviceInfo> ListAravisDevices();

}  // namespace ulf::acquisition
