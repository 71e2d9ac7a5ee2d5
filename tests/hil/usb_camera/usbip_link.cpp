#include "tests/hil/usb_camera/usbip_link.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <utility>

namespace hdrcam::hil {
namespace {

constexpr const char* kAttach = "/sys/devices/platform/vhci_hcd.0/attach";
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr int kSpeedHigh = 3, kDeviceId = 0x10002, kHighSpeedPorts = 8;
constexpr std::int32_t kConnectionReset = -104;
using Header = std::array<std::uint32_t, 12>;  // in network order on the wire

bool read_all(int fd, void* memory, std::size_t length) {
  auto* bytes = static_cast<char*>(memory);
  while (length > 0) {
    const ssize_t n = ::read(fd, bytes, length);
    if (n <= 0) return false;
    bytes += n, length -= static_cast<std::size_t>(n);
  }
  return true;
}

void send_all(int fd, const void* memory, std::size_t length) {
  const auto* bytes = static_cast<const char*>(memory);
  while (length > 0) {
    const ssize_t n = ::send(fd, bytes, length, MSG_NOSIGNAL);
    if (n <= 0) return;  // the next receive() finds the plug pulled
    bytes += n, length -= static_cast<std::size_t>(n);
  }
}

}  // namespace

std::optional<UsbIpLink> UsbIpLink::plug_in() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return std::nullopt;
  const int room = 4 << 20;
  ::setsockopt(ends[0], SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
  bool plugged = false;
  const int attach = ::open(kAttach, O_WRONLY | O_CLOEXEC);
  for (int port = 0; attach >= 0 && port < kHighSpeedPorts && !plugged; ++port) {
    std::array<char, 64> words{};
    const int length =
        std::snprintf(words.data(), words.size(), "%d %d %d %d", port, ends[1], kDeviceId, kSpeedHigh);
    plugged = ::write(attach, words.data(), static_cast<std::size_t>(length)) == length;
  }
  if (attach >= 0) ::close(attach);
  ::close(ends[1]);  // the kernel holds its own reference
  if (plugged) return UsbIpLink(ends[0]);
  ::close(ends[0]);
  return std::nullopt;
}

UsbIpLink::UsbIpLink(UsbIpLink&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
UsbIpLink::~UsbIpLink() {
  if (fd_ >= 0) ::close(fd_);
}

std::optional<Message> UsbIpLink::receive() {
  Header header{};
  if (!read_all(fd_, header.data(), sizeof header)) return std::nullopt;
  Message message;
  message.sequence = ntohl(header[1]);
  if (ntohl(header[0]) == kUnlink) {
    message.unlinked = ntohl(header[5]);
    return message;
  }
  if (ntohl(header[0]) != kSubmit) return std::nullopt;
  Transfer transfer;
  transfer.sequence = message.sequence;
  transfer.to_host = ntohl(header[3]) != 0;
  transfer.endpoint = ntohl(header[4]), transfer.length = ntohl(header[6]);
  std::memcpy(transfer.setup.data(), &header[10], transfer.setup.size());
  if (!transfer.to_host) {
    transfer.data.resize(transfer.length);
    if (!read_all(fd_, transfer.data.data(), transfer.data.size())) return std::nullopt;
  }
  message.transfer = std::move(transfer);
  return message;
}

void UsbIpLink::answer(std::uint32_t sequence, int status, std::size_t length,
                       std::span<const std::uint8_t> data) {
  Header header{};
  header[0] = htonl(kSubmitted), header[1] = htonl(sequence);
  header[5] = htonl(static_cast<std::uint32_t>(status)),
  header[6] = htonl(static_cast<std::uint32_t>(length));
  send_all(fd_, header.data(), sizeof header);
  send_all(fd_, data.data(), data.size());
}

void UsbIpLink::answer_unlink(std::uint32_t sequence, bool was_pending) {
  Header header{};
  header[0] = htonl(kUnlinked), header[1] = htonl(sequence);
  header[5] = htonl(static_cast<std::uint32_t>(was_pending ? kConnectionReset : 0));
  send_all(fd_, header.data(), sizeof header);
}

}  // namespace hdrcam::hil
