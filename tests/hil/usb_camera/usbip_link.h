// The connection of a simulated USB device: the kernel's virtual host controller (vhci_hcd) speaks USB/IP
// over a socket, and this is the other end. Structures as in the kernel's
// Documentation/usb/usbip_protocol.rst. Thread-bound.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace hdrcam::hil {

// A transfer that the host requests; `data` is what it sends with it.
struct Transfer {
  std::uint32_t sequence = 0, endpoint = 0, length = 0;
  bool to_host = false;
  std::array<std::uint8_t, 8> setup{};  // of endpoint 0
  std::vector<std::uint8_t> data;
};

// A message from the host: a transfer, or the request to cancel one.
struct Message {
  std::optional<Transfer> transfer;
  std::uint32_t sequence = 0, unlinked = 0;  // where there is no transfer
};

constexpr int kStall = -32;  // EPIPE: the device does not support the request

class UsbIpLink {
 public:
  // Plugs a high-speed device into the first free port of the virtual host controller; nullopt where there is
  // none.
  static std::optional<UsbIpLink> plug_in();
  UsbIpLink(UsbIpLink&& other) noexcept;
  ~UsbIpLink();

  int fd() const { return fd_; }
  // The next message; nullopt when the host has pulled the plug.
  std::optional<Message> receive();
  void answer(std::uint32_t sequence, int status, std::size_t length, std::span<const std::uint8_t> data);
  void answer_unlink(std::uint32_t sequence, bool was_pending);

 private:
  explicit UsbIpLink(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace hdrcam::hil
