# Debian packages unpacked into folders, never installed: for the checks that need what this system shall not have, or what is
# for another processor. To be sourced; run_hil.sh and run_arm64.sh use it.
#
#   packages_in FOLDER [APT OPTION..]   Debian's own lists in files under FOLDER; comes first, before each of the others
#   download TARGET PACKAGE..           these packages, and nothing that they depend on
#   download_closure TARGET STATUS PACKAGE..   with all they depend on, beyond what dpkg's STATUS file says is installed
#                                       ('': beyond what is installed here)
#   unpack ARCHIVES ROOT
#
# needs: apt with Debian 12's lists (DEBIAN_SOURCES: another file), and setup_failed TEXT of the script that sources it.

packages_in() {
  local folder=$1 sources=/etc/apt/sources.list.d/debian.sources
  shift
  [ -e "$sources" ] || sources=/etc/apt/sources.list # of Debian 12's installer; containers have the other
  mkdir -p "$folder/lists/partial" "$folder/cache/archives/partial"
  apt_archives=$folder/cache/archives
  apt_options=(-o Dir::Etc::sourcelist="${DEBIAN_SOURCES:-$sources}"
    -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists="$folder/lists" -o Dir::Cache="$folder/cache"
    -o APT::Install-Recommends=false -o APT::Sandbox::User=root -o Debug::NoLocking=1 "$@")
  apt-get "${apt_options[@]}" -qq update || setup_failed "apt-get update failed"
}

download() {
  mkdir -p "$1"
  (cd "$1" && shift && apt-get "${apt_options[@]}" -qq download "$@") || setup_failed "cannot download $*"
}

download_closure() {
  local target=$1 status=$2
  shift 2
  apt-get "${apt_options[@]}" ${status:+-o Dir::State::status="$status"} -qq -y -d install "$@" >/dev/null ||
    setup_failed "cannot download $*"
  mkdir -p "$target" && mv "$apt_archives"/*.deb "$target/"
}

unpack() {
  local archive
  for archive in "$1"/*.deb; do dpkg-deb -x "$archive" "$2"; done
}
