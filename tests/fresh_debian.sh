# Sourced: fresh_debian SUITE [PACKAGE ...] makes a Debian by debootstrap in $fresh, and removes it when the shell
# ends; inside COMMAND ... runs a command in it, as root and with nothing of this machine's environment. share_cache FOLDER
# has it use this folder of ccache.
#
# From this machine come only its certificate authorities and its settings of a proxy.
as_root=()
if [[ $EUID -ne 0 ]]; then as_root=(sudo); fi

fresh_debian() {
  local suite=$1 packages=ca-certificates package authorities
  for package in "${@:2}"; do packages+=",$package"; done
  command -v debootstrap >/dev/null ||
    "${as_root[@]}" apt-get install -y -qq -o DPkg::Lock::Timeout=600 --no-install-recommends debootstrap
  fresh=$(mktemp -d)
  trap remove_fresh_debian EXIT
  trap 'exit 130' INT TERM
  "${as_root[@]}" debootstrap --variant=minbase "--include=$packages" "$suite" "$fresh" >"$fresh.log" 2>&1 ||
    { tail -n 20 "$fresh.log" >&2; exit 1; }
  "${as_root[@]}" mount -t proc proc "$fresh/proc"
  "${as_root[@]}" mount --bind /dev "$fresh/dev"
  "${as_root[@]}" cp -L /etc/resolv.conf "$fresh/etc/resolv.conf"
  grep -lsi proxy /etc/apt/apt.conf.d/* | xargs -r "${as_root[@]}" cp -t "$fresh/etc/apt/apt.conf.d" || true
  for authorities in /etc/ssl/certs /usr/local/share/ca-certificates; do
    [[ -d $authorities ]] || continue
    "${as_root[@]}" mkdir -p "$fresh$authorities"
    "${as_root[@]}" cp -rL "$authorities/." "$fresh$authorities" 2>/dev/null || true # a link may lead nowhere
  done
}

share_cache() {
  cache_of_fresh_debian=$1
  "${as_root[@]}" mkdir -p "$fresh/root/.cache/ccache"
  "${as_root[@]}" mount --bind "$1" "$fresh/root/.cache/ccache"
}

remove_fresh_debian() {
  local folder
  for folder in proc dev root/.cache/ccache; do "${as_root[@]}" umount -l "$fresh/$folder" 2>/dev/null || true; done
  [[ -z ${cache_of_fresh_debian:-} ]] || "${as_root[@]}" chown -R "$UID" "$cache_of_fresh_debian" # root wrote to it
  ! mountpoint -q "$fresh/root/.cache/ccache" || return 0 # it may be of the same file system
  "${as_root[@]}" rm -rf --one-file-system "$fresh" "$fresh.log" # never what is still mounted
}

inside() {
  local variable kept=(PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8)
  for variable in http_proxy https_proxy no_proxy NODE_EXTRA_CA_CERTS PIP_CERT SSL_CERT_FILE REQUESTS_CA_BUNDLE; do
    [[ -z ${!variable:-} ]] || kept+=("$variable=${!variable}")
  done
  "${as_root[@]}" chroot "$fresh" /usr/bin/env -i "${kept[@]}" "$@" </dev/null
}
