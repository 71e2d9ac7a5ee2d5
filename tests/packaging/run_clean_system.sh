#!/usr/bin/env bash
# The packages in a Debian 12 that has nothing else: install, record, replay, a library user, purge. Needs what
# clean_root.sh needs. Called by ./run installed clean-system.
#   run_clean_system.sh FOLDER_OF_PACKAGES [MIRROR]
set -euo pipefail
. "$(dirname "$0")/clean_root.sh"
repository=$PWD
make_clean_root "$1" "${2:-}"
cp "$repository/tests/data/demo.mkv" "$root/work/"
inside id hdrcam
say "replay"
inside hdrcam replay /work/demo.mkv -o /work/out/%06d.exr 2>/dev/null
[ "$(find "$root/work/out" -name '*.exr' | wc -l)" = 24 ]
say "record from the simulator, as the service's user"
inside install -d -o hdrcam -g hdrcam /var/lib/hdrcam
inside setpriv --reuid hdrcam --regid hdrcam --init-groups hdrcam record --camera sim:walk --frames 30 -o /var/lib/hdrcam/walk.mkv
inside hdrcam info /var/lib/hdrcam/walk.mkv | grep 'frames  *30'

say "install hdrcam-dev and a compiler; compile the example"
inside sh -c 'apt-get install -qq -y --no-install-recommends g++ cmake make pkg-config /work/hdrcam-dev_*.deb >/dev/null'
inside sh -c 'cmake -S /usr/share/doc/hdrcam-dev/examples/mean_radiance -B /work/example >/dev/null &&
  cmake --build /work/example >/dev/null && /work/example/mean_radiance /work/demo.mkv | tail -1'

say "purge"
inside sh -c 'apt-get purge -qq -y hdrcam hdrcam-dev >/dev/null'
after=$(inside find /usr /etc /var/lib -xdev -name '*hdrcam*' ! -path '/var/lib/hdrcam*' | sort)
[ -z "$after" ] || { printf 'left behind:\n%s\n' "$after"; exit 1; }
[ -e "$root/var/lib/hdrcam/walk.mkv" ] && echo "nothing is left but the recording"
