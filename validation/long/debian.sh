#!/usr/bin/env bash
# Installs, builds and tests the present commit on a fresh Debian:
#   validation/long/debian.sh trixie                   ./lichtenberg test
#   validation/long/debian.sh bookworm --version       any other words for ./lichtenberg
# Needs root and debootstrap. The fresh system (about 4 GB) is a temporary folder (TMPDIR), which is removed at the end. Packages
# come from where apt of this machine gets its own. LICHTENBERG_FIGURES names the file for the versions of the packages. If
# CCACHE_DIR names a folder, the build uses ccache with it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

say() { printf 'debian: %s\n' "$*" >&2; }
fail() { say "$*" && exit 1; }

((EUID == 0)) || fail 'only root can make a root folder'
command -v debootstrap >/dev/null || fail 'debootstrap is missing: apt-get install debootstrap'
(($#)) || { say 'the name of a release is missing, such as: debian.sh trixie' && exit 2; }
release=$1
shift
(($#)) || set -- test

# Mounts of this process end with it, also when it is killed.
if [[ ${LICHTENBERG_OWN_MOUNTS:-} != yes ]]; then exec env LICHTENBERG_OWN_MOUNTS=yes unshare --mount validation/long/debian.sh "$release" "$@"; fi

root=$(mktemp -d -t "lichtenberg-$release.XXXXXX")
remove_root() {
  while umount "$root/proc" 2>/dev/null; do :; done  # debootstrap mounts it too
  umount "$root/dev" "$root/ccache" 2>/dev/null || true
  mountpoint -q "$root/dev" || mountpoint -q "$root/ccache" || rm -rf --one-file-system "$root"
}
trap remove_root EXIT
log=$root.log
mirror=$(apt-get indextargets --format '$(ORIGIN) $(LABEL) $(REPO_URI)' 'Created-By: Packages' | sed -n 's/^Debian Debian //p' | head -n 1)
debootstrap --variant=minbase --include=ca-certificates "$release" "$root" ${mirror:+"$mirror"} >"$log" 2>&1 ||
  { tail -n 3 "$log" >&2 && fail "no system of the release $release could be made (all output is in $log)"; }
rm "$log"
mount --bind /proc "$root/proc"
mount --bind /dev "$root/dev"
cp /etc/resolv.conf "$root/etc/"

git clone -q --no-hardlinks . "$root/lichtenberg"
cache=()
if [[ -d ${CCACHE_DIR:-} ]]; then
  mkdir "$root/ccache"
  mount --bind "$CCACHE_DIR" "$root/ccache"
  cache=(CCACHE_DIR=/ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
inside() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 ${http_proxy:+http_proxy="$http_proxy"} \
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "${cache[@]}" chroot "$root" "$@"
}
if ((${#cache[@]})); then
  inside apt-get -q -y install ccache >"$log" 2>&1 || { tail -n 3 "$log" >&2 && fail "ccache could not be installed (all output is in $log)"; }
  rm "$log"
fi
status=0
inside env -C /lichtenberg ./lichtenberg "$@" || status=$?
if [[ ${LICHTENBERG_FIGURES:-} ]]; then
  # shellcheck disable=SC2046  # one word per package
  inside dpkg-query -W -f '${Package} ${Version}\n' $(sed 's/#.*//' cmake/debian-packages.txt) |
    awk 'BEGIN { printf "{" } { printf "%s\"%s\": \"%s\"", (NR > 1 ? ", " : ""), $1, $2 } END { print "}" }' >"$LICHTENBERG_FIGURES"
fi
exit "$status"
