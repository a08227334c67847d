#include "tests/support/ptpip_camera.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cctype>
#include <chrono>
#include <stdexcept>

#include "tests/support/floors.h"
#include "tests/support/ptp_wire.h"
#include "tests/support/ptpip_connection.h"

namespace ulf::test {

namespace {

bool IsRaw(const std::string& name) {
  std::string ending = name.substr(name.rfind('.') + 1);
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending != "jpg";
}

}  // namespace

PtpipCamera::PtpipCamera(LivePicture live, Photograph photograph, const PtpipCameraOptions& options)
    : live_(std::move(live)), photograph_(std::move(photograph)), options_(options) {
  properties_[kPtpBattery] = {2, 80, {}};
  properties_[kPtpImageFormat] = {2, 2, {0, 1, 2, 4, 5}};
  properties_[kPtpFNumber] = {4, 560, {400, 560, 800, 1100}};
  properties_[kPtpFocusMode] = {4, 0x8010, {1, 0x8010}};
  properties_[kPtpExposure] = {6, 80, {20, 40, 80, 166, 333}};
  properties_[kPtpProgram] = {4, 2, {1, 2, 3, 4}};
  properties_[kPtpIso] = {4, 200, {100, 200, 400, 800, 1600}};

  if (options_.brackets) {
    properties_[kPtpCaptureMode] = {4, 1, {1, 2}};
    properties_[kPtpBurstNumber] = {4, 1, {1, 100, 1}, true};
    properties_[kPtpBracketSet] = {2, 0, {0, 1, 2, 3}};
    properties_[kPtpBracketing] = {2, 0, {0, 1, 1}, true};  // the driver wants a range
    properties_[kPtpBracketStep] = {2, 3, {0, 1, 2, 3, 4, 5}};
    properties_[kPtpBracketPattern] = {2, 0, {0, 1, 2, 3, 4, 5, 6, 7, 8}};
  }

  // Without it the driver begins live view anew for every frame, and drops the first of each.
  if (options_.live_view) properties_[kLiveViewStatus] = {2, 0, {}};

  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (listener_ < 0 || bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_, 8) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    throw std::runtime_error("the PTP/IP camera cannot listen on loopback");
  port_ = ntohs(address.sin_port);
  accept_ = std::thread([this] { Accept(); });
  shutter_ = std::thread([this] { Shutter(); });
}

PtpipCamera::~PtpipCamera() {
  stop_ = true;
  shutdown(listener_, SHUT_RDWR);
  accept_.join();
  close(listener_);
  DropLink();
  released_.notify_all();
  shutter_.join();
  for (std::thread& thread : threads_) thread.join();
}

std::string PtpipCamera::Uri() const { return "gphoto2:ptpip:127.0.0.1:" + std::to_string(port_); }

void PtpipCamera::Accept() {
  while (!stop_) {
    const int socket = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    const int on = 1;
    setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    auto connection = std::make_shared<Connection>(socket);
    if (refuse_ || stop_) continue;
    const std::lock_guard lock(mutex_);
    connections_.push_back(connection);
    threads_.emplace_back([this, connection] { Serve(connection); });
  }
}

void PtpipCamera::Serve(std::shared_ptr<Connection> connection) {
  std::uint32_t type = 0;
  std::string payload;
  if (!connection->Read(type, payload)) return;
  if (type == kInitCommand) {
    std::string ack;
    Put<std::uint32_t>(ack, 1);
    ack += std::string(16, '\1');
    for (const char c : std::string("ulf test camera")) Put<std::uint16_t>(ack, static_cast<std::uint8_t>(c));
    Put<std::uint16_t>(ack, 0);
    Put<std::uint32_t>(ack, 0x10000);
    connection->Send(kInitCommandAck, ack);
    Commands(*connection);
  } else if (type == kInitEvent) {
    connection->Send(kInitEventAck, {});
    {
      const std::lock_guard lock(mutex_);
      events_ = connection;
    }
    while (connection->Read(type, payload)) {
    }
  }
  connection->Shutdown();
}

void PtpipCamera::Commands(Connection& connection) {
  std::uint32_t type = 0;
  std::string payload;
  while (connection.Read(type, payload)) {
    if (type != kRequest) continue;
    Request request;
    const auto phase = Get<std::uint32_t>(payload, 0);
    request.operation = Get<std::uint16_t>(payload, 4);
    request.transaction = Get<std::uint32_t>(payload, 6);
    for (std::size_t at = 10; at + 4 <= payload.size(); at += 4)
      request.parameters.push_back(Get<std::uint32_t>(payload, at));
    if (phase == 2)
      while (connection.Read(type, payload) && type != kEndData)
        if (type == kData) request.data += payload.substr(4);
    if (phase == 2 && type == kEndData) request.data += payload.substr(4);
    Answer(connection, request);
  }
}

void PtpipCamera::Answer(Connection& connection, const Request& request) {
  if (std::uint16_t stalled = request.operation; stalled_operation_.compare_exchange_strong(stalled, 0))
    std::this_thread::sleep_for(std::chrono::duration<double>(stall_s_));
  std::string data;
  switch (request.operation) {
    case kGetDeviceInfo:
      connection.SendData(request, DeviceInfo());
      break;
    case kOpenSession:
    case kCloseSession:
    case kDeviceReady:
      break;
    case kGetStorageIds:
      PutArray<std::uint32_t>(data, {kStorage});
      connection.SendData(request, data);
      break;
    case kGetStorageInfo: {
      Put<std::uint16_t>(data, 4);  // removable RAM: a card
      Put<std::uint16_t>(data, 3);  // DCF
      Put<std::uint16_t>(data, 0);
      Put<std::uint64_t>(data, 1ull << 34);
      Put<std::uint64_t>(data, card_full_ ? 0 : 1ull << 33);
      Put<std::uint32_t>(data, card_full_ ? 0 : 999);
      PutText(data, "card");
      PutText(data, "card");
      connection.SendData(request, data);
      break;
    }
    case kGetNumObjects:
    case kGetObjectHandles:
    case kGetObjectInfo:
    case kGetObject:
    case kDeleteObject:
      return AnswerObject(connection, request);
    case kGetPropertyDescription:
    case kGetProperty:
    case kSetProperty:
      return AnswerProperty(connection, request);
    case kInitiateCapture:
      return AnswerRelease(connection, request);
    case kStartLiveView:
    case kEndLiveView:
    case kGetLiveView:
      return AnswerLiveView(connection, request);
    default:
      return connection.Respond(request, kNotSupported);
  }
  connection.Respond(request, kOk);
}

void PtpipCamera::AnswerObject(Connection& connection, const Request& request) {
  std::string data;
  PtpipFile file;
  if (request.operation == kGetObject && busy_downloads_ > 0) {
    --busy_downloads_;
    ++busy_answers_;
    return connection.Respond(request, kBusy);
  }
  if (request.operation == kGetObject && failing_downloads_ > 0) {
    --failing_downloads_;
    return connection.Respond(request, kGeneralError);
  }
  {
    const std::lock_guard lock(mutex_);
    if (request.operation == kGetObjectHandles || request.operation == kGetNumObjects) {
      std::vector<std::uint32_t> handles;
      for (const auto& [handle, object] : objects_) handles.push_back(handle);
      PutArray(data, handles);
    } else {
      const auto found = objects_.find(request.Parameter(0));
      if (found == objects_.end()) return connection.Respond(request, kBadObject);
      file = found->second;
      if (request.operation == kGetObject && raw_fails_ && IsRaw(file.name))
        return connection.Respond(request, kGeneralError);
      if (request.operation == kDeleteObject) objects_.erase(found);
    }
  }
  if (request.operation == kGetObjectInfo) {
    const std::uint16_t format = IsRaw(file.name) ? 0x3000 : 0x3801;
    Put<std::uint32_t>(data, kStorage);
    Put<std::uint16_t>(data, format);
    Put<std::uint16_t>(data, 0);
    Put<std::uint32_t>(data, static_cast<std::uint32_t>(file.bytes.size()));
    Put<std::uint16_t>(data, 0x3801);  // thumbnail
    for (int i = 0; i < 7; ++i) Put<std::uint32_t>(data, 0);
    Put<std::uint16_t>(data, 0);  // association: none
    Put<std::uint32_t>(data, 0);
    Put<std::uint32_t>(data, request.Parameter(0));
    PutText(data, file.name);
    PutText(data, file.written);
    PutText(data, file.written);
    PutText(data, "");
  }
  if (request.operation == kGetObject)
    connection.SendData(request, file.bytes, options_.download_bytes_per_s);
  else if (request.operation != kDeleteObject)
    connection.SendData(request, data);
  connection.Respond(request, kOk);
}

void PtpipCamera::AnswerProperty(Connection& connection, const Request& request) {
  const auto code = static_cast<std::uint16_t>(request.Parameter(0));
  std::string data;
  {
    const std::lock_guard lock(mutex_);
    const auto found = properties_.find(code);
    if (found == properties_.end()) return connection.Respond(request, kBadProperty);
    if (request.operation == kSetProperty) {
      if (found->second.choices.empty()) return connection.Respond(request, kReadOnly);
      if (code == kPtpBracketing && busy_bracketing_ > 0) {
        --busy_bracketing_;
        ++busy_answers_;
        return connection.Respond(request, kBusy);
      }
      found->second.value = Get<std::uint32_t>(request.data, 0);
    }
    PutNumber(data, found->second.type, found->second.value);
  }
  if (request.operation == kGetPropertyDescription) connection.SendData(request, PropertyDescription(code));
  if (request.operation == kGetProperty) connection.SendData(request, data);
  connection.Respond(request, kOk);
}

void PtpipCamera::AnswerRelease(Connection& connection, const Request& request) {
  if (card_full_) return connection.Respond(request, kStoreFull);
  if (busy_ > 0) {
    --busy_;
    ++busy_answers_;
    return connection.Respond(request, kBusy);
  }
  connection.Respond(request, kOk);
  if (press_first_.exchange(false)) PressShutter();
  ++releases_asked_;
  Release(request.transaction);
}

void PtpipCamera::AnswerLiveView(Connection& connection, const Request& request) {
  if (request.operation != kGetLiveView) {
    const std::lock_guard lock(mutex_);
    properties_.at(kLiveViewStatus).value = request.operation == kStartLiveView;
  } else {
    // A header of the maker's before the picture, as these cameras send it.
    connection.SendData(request, std::string(384, '\0') + live_());
  }
  connection.Respond(request, kOk);
}

std::string PtpipCamera::DeviceInfo() const {
  std::vector<std::uint16_t> operations{kGetDeviceInfo,    kOpenSession,     kCloseSession,
                                        kGetStorageIds,    kGetStorageInfo,  kGetNumObjects,
                                        kGetObjectHandles, kGetObjectInfo,   kGetObject,
                                        kDeleteObject,     kInitiateCapture, kGetPropertyDescription,
                                        kGetProperty,      kSetProperty,     kDeviceReady};
  if (options_.live_view) operations.insert(operations.end(), {kStartLiveView, kEndLiveView, kGetLiveView});
  std::string info;
  Put<std::uint16_t>(info, 100);
  Put<std::uint32_t>(info, kNikon);
  Put<std::uint16_t>(info, 100);
  PutText(info, "");
  Put<std::uint16_t>(info, 0);
  PutArray(info, operations);
  PutArray<std::uint16_t>(info, {kObjectAdded, kPropertyChanged, kStoreFullEvent, kCaptureComplete});
  std::vector<std::uint16_t> codes;
  for (const auto& [code, value] : properties_) codes.push_back(code);
  PutArray(info, codes);
  PutArray<std::uint16_t>(info, {0x3801});
  PutArray<std::uint16_t>(info, {0x3801, 0x3000});
  PutText(info, "Nikon Corporation");
  PutText(info, "ULF test camera");
  PutText(info, "V1.0");
  PutText(info, options_.serial);
  return info;
}

std::string PtpipCamera::PropertyDescription(std::uint16_t code) const {
  const std::lock_guard lock(mutex_);
  const Value& value = properties_.at(code);
  std::string text;
  Put(text, code);
  Put(text, value.type);
  Put<std::uint8_t>(text, value.choices.empty() ? 0 : 1);
  PutNumber(text, value.type, value.value);
  PutNumber(text, value.type, value.value);
  if (code == kPtpBattery || value.is_range) {
    Put<std::uint8_t>(text, 1);  // a range
    for (const std::uint32_t bound : value.is_range ? value.choices : std::vector<std::uint32_t>{0, 100, 1})
      PutNumber(text, value.type, bound);
    return text;
  }
  if (value.choices.empty()) {
    Put<std::uint8_t>(text, 0);
    return text;
  }
  Put<std::uint8_t>(text, 2);  // a list
  Put<std::uint16_t>(text, static_cast<std::uint16_t>(value.choices.size()));
  for (const std::uint32_t choice : value.choices) PutNumber(text, value.type, choice);
  return text;
}

void PtpipCamera::SetProperty(std::uint16_t code, std::uint32_t value) {
  {
    const std::lock_guard lock(mutex_);
    properties_.at(code).value = value;
  }
  Event(kPropertyChanged, 0, code);
}

std::uint32_t PtpipCamera::Property(std::uint16_t code) const {
  const std::lock_guard lock(mutex_);
  const Value& value = properties_.at(code);
  return value.type == 2 ? value.value & 0xFF : value.type == 4 ? value.value & 0xFFFF : value.value;
}

std::vector<std::string> PtpipCamera::FilesKept() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [handle, file] : objects_) names.push_back(file.name);
  return names;
}

void PtpipCamera::DropLink() {
  std::vector<std::shared_ptr<Connection>> dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped.swap(connections_);
    events_.reset();
  }
  for (const auto& connection : dropped) connection->Shutdown();
}

void PtpipCamera::Forget() {
  const std::lock_guard lock(mutex_);
  objects_.clear();
}

void PtpipCamera::PutOnCard(PtpipFile file) {
  const std::lock_guard lock(mutex_);
  objects_[next_object_++] = std::move(file);
}

void PtpipCamera::AnnounceAgain() {
  std::vector<std::uint32_t> handles;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [handle, file] : objects_) handles.push_back(handle);
  }
  for (const std::uint32_t handle : handles) Event(kObjectAdded, 0xFFFFFFFF, handle);
}

void PtpipCamera::PressShutter() { Release(0xFFFFFFFF); }

void PtpipCamera::Release(std::uint32_t transaction) {
  {
    const std::lock_guard lock(mutex_);
    waiting_releases_.push_back(transaction);
  }
  released_.notify_all();
}

void PtpipCamera::Shutter() {
  while (true) {
    std::uint32_t transaction = 0;
    {
      std::unique_lock lock(mutex_);
      released_.wait(lock, [this] { return stop_ || !waiting_releases_.empty(); });
      if (stop_) return;
      transaction = waiting_releases_.front();
      waiting_releases_.erase(waiting_releases_.begin());
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(options_.shutter_lag_s));
    const bool is_burst =
        options_.brackets && Property(kPtpBracketing) == 1 && Property(kPtpCaptureMode) == 2;
    for (std::uint32_t left = is_burst ? Property(kPtpBurstNumber) : 1; left > 0; --left) {
      const std::vector<PtpipFile> files = photograph_(++releases_);
      for (const PtpipFile& file : files) {
        std::uint32_t handle = 0;
        if (&file != &files.front())
          std::this_thread::sleep_for(std::chrono::duration<double>(options_.between_files_s));
        {
          const std::lock_guard lock(mutex_);
          handle = next_object_++;
          objects_[handle] = file;
        }
        Event(kObjectAdded, transaction, handle);
      }
    }
    Event(kCaptureComplete, transaction, 0, 0);
  }
}

void PtpipCamera::Event(std::uint16_t code, std::uint32_t transaction, std::uint32_t parameter,
                        int parameters) {
  std::shared_ptr<Connection> events;
  {
    const std::lock_guard lock(mutex_);
    events = events_;
  }
  if (!events) return;
  std::string payload;
  Put(payload, code);
  Put(payload, transaction);
  if (parameters > 0) Put(payload, parameter);
  events->Send(kEvent, payload);
}

}  // namespace ulf::test
