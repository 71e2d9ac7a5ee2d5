#include "hal/real/device_node.h"

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace hdrcam {

namespace fs = std::filesystem;

namespace {

// Of a folder whose files, or itself, may go away meanwhile, as that of a process does.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code gone;
  for (fs::directory_iterator at(folder, gone), end; !gone && at != end; at.increment(gone))
    entries.push_back(at->path());
  return entries;
}

}  // namespace

Result<DeviceNode> DeviceNode::open(const std::string& path) {
  Descriptor fd(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!fd.is_open()) return device_error(errno, path, "open it");
  return DeviceNode(std::move(fd), path);
}

int DeviceNode::ask(unsigned long request, void* argument) const {
  while (::ioctl(fd(), request, argument) < 0)
    if (errno != EINTR) return errno;
  return 0;
}

Result<void> DeviceNode::demand(unsigned long request, void* argument, const char* doing) const {
  if (const int code = ask(request, argument); code != 0) return device_error(code, path_, doing);
  return {};
}

Error device_error(int code, const std::string& path, const std::string& doing) {
  switch (code) {
    case ENOENT:
      return {ErrorCode::NotFound,
              fmt::format("there is no device '{}'; 'hdrcam list' shows those that there are", path), code};
    case EACCES:
    case EPERM:
      return {ErrorCode::Permission,
              fmt::format("no permission for '{}': {}", path, how_to_get_permission(path)), code};
    case EBUSY: {
      const std::string holder = holder_of(path);
      return {ErrorCode::Busy,
              fmt::format("'{}' is in use by {}; stop it or choose another device", path,
                          holder.empty() ? "another program" : holder),
              code};
    }
    case ENODEV:
    case ENXIO:
      return {ErrorCode::Unplugged, fmt::format("'{}' was unplugged, or its driver went away", path), code};
    case ENOTTY:
    case EINVAL:
      return {ErrorCode::Unsupported, fmt::format("'{}' cannot {}: {}", path, doing, std::strerror(code)),
              code};
    case EPIPE:
      return {
          ErrorCode::Invalid,
          fmt::format("'{}' cannot {}: the formats along its media pipeline do not match (set them with "
                      "'media-ctl', or use the camera through libcamera), or a USB camera stalled (plug it "
                      "in again)",
                      path, doing),
          code};
    case ENOSPC:
      return {ErrorCode::Io, fmt::format("'{}' cannot {}: {}", path, doing, kNoBandwidth), code};
    default:
      return {ErrorCode::Io,
              fmt::format("'{}' cannot {}: {}{}", path, doing, std::strerror(code),
                          is_of_bus(code) ? fmt::format("; {}", kCheckCable) : ""),
              code};
  }
}

Error control_error(int code, const std::string& path, const std::string& doing) {
  const bool gone = code == ENODEV || code == ENXIO, never = code == ENOTTY || code == EINVAL;
  if (gone || never) return device_error(code, path, doing);
  return {ErrorCode::Io, fmt::format("'{}' refused to {}: {}", path, doing, std::strerror(code)), code};
}

bool is_of_bus(int code) { return is_failed_transfer(code) || code == ETIMEDOUT || code == ESHUTDOWN; }

bool is_failed_transfer(int code) {
  return code == EIO || code == EPIPE || code == EPROTO || code == EILSEQ || code == EREMOTEIO;
}

std::vector<std::string> device_nodes(std::string_view beginning) {
  std::vector<std::string> nodes;
  for (const fs::path& file : entries_of("/dev"))
    if (file.filename().string().starts_with(beginning)) nodes.push_back(file);
  std::ranges::sort(nodes, [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return nodes;
}

std::optional<Error> closed_node(const std::vector<std::string>& nodes) {
  for (const std::string& node : nodes)
    if (const auto opened = DeviceNode::open(node); !opened && opened.error().code == ErrorCode::Permission)
      return opened.error();
  return std::nullopt;
}

std::string holder_of(const std::string& path) {
  std::error_code ignored;
  const fs::path canonical = fs::canonical(path, ignored);  // of a link like those of /dev/v4l/by-id
  const std::string own = std::to_string(::getpid());
  for (const fs::path& process : entries_of("/proc")) {
    const std::string pid = process.filename();
    if (pid == own || pid.find_first_not_of("0123456789") != std::string::npos) continue;
    for (const fs::path& file : entries_of(process / "fd")) {
      if (canonical.empty() || fs::read_symlink(file, ignored) != canonical) continue;
      std::string program;
      std::getline(std::ifstream(process / "comm"), program);
      return fmt::format("'{}' (process {})", program, pid);
    }
  }
  return {};
}

std::string how_to_get_permission(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & S_IRGRP) != 0 &&
      (status.st_mode & S_IWGRP) != 0) {
    const group* owners = ::getgrgid(status.st_gid);
    if (owners != nullptr && status.st_gid != 0)
      return fmt::format("add this user to the group '{0}' (sudo usermod -aG {0} $USER) and log in again",
                         owners->gr_name);
  }
  return "only root may open it; a udev rule can give it to a group";
}

WakeUp::WakeUp() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) { HDRCAM_CHECK(fd_.is_open()); }

void WakeUp::set() {
  const std::uint64_t one = 1;
  (void)!::write(fd_.get(), &one, sizeof one);  // a full counter is set already
}

void WakeUp::clear() {
  std::uint64_t count = 0;
  (void)!::read(fd_.get(), &count, sizeof count);
}

WakeUp::Ready WakeUp::sleep(int device, Duration at_most) const {
  std::array<pollfd, 2> fds{{{fd_.get(), POLLIN, 0}, {device, POLLIN, 0}}};
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(at_most);
  const timespec patience{seconds.count(), (at_most - seconds).count()};
  (void)::ppoll(fds.data(), fds.size(), &patience, nullptr);
  return {fds[0].revents, fds[1].revents};
}

}  // namespace hdrcam
