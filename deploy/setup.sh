#!/usr/bin/env bash
# Installs everything that building, running and testing hoodoo needs on Debian 12.
#
#   deploy/setup.sh           all of it
#   deploy/setup.sh --build   only what building, baking and serving need
#
# Needs apt, and root or sudo. Safe to run again: what is there already is left alone.
set -euo pipefail
cd "$(dirname "$0")/.."

build_packages=(
  g++ cmake ninja-build ccache pkg-config ca-certificates
  # pixels and georeferencing
  libopenimageio-dev openimageio-tools libtiff-dev libgeotiff-dev libproj-dev proj-data
  # voxels; OpenVDB's headers include some of Boost's
  libopenvdb-dev libblosc-dev libboost-dev
  # meshes and glTF
  libdraco-dev libtinygltf-dev libmeshoptimizer-dev libeigen3-dev libnanoflann-dev
  # threads, vector code, formats, storage
  libtbb-dev libhwy-dev nlohmann-json3-dev libcli11-dev libspdlog-dev libfmt-dev
  libsqlite3-dev libssl-dev libcurl4-openssl-dev zlib1g-dev libzstd-dev libbrotli-dev prometheus-cpp-dev
  # CMake configures the tests too
  libgtest-dev libgmock-dev libbenchmark-dev
  # to take the cpp-httplib header out of its source package
  dpkg-dev xz-utils
)
test_packages=(
  clang clang-format clang-tidy libclang-rt-14-dev git curl chromium shellcheck proj-bin
  openssl libpcre2-8-0 python3-owslib jq systemd
)
httplib_minimum=0.41.0
httplib=/usr/local/include/cpp-httplib/httplib.h

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Runs a command and shows its output only when it fails.
quietly() {
  local output
  output=$("$@" 2>&1) || { printf '%s\n' "$output" >&2; return 1; }
}

installed() {
  [ "$(dpkg-query --show --showformat '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

install_packages() {
  local missing=() package
  for package in "$@"; do
    installed "$package" || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then return; fi
  echo "setup.sh: installing ${missing[*]}"
  as_root apt-get -qq -o DPkg::Lock::Timeout=600 update
  quietly as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o DPkg::Lock::Timeout=600 \
    install --no-install-recommends "${missing[@]}"
}

# Debian 12 has cpp-httplib 0.11, which an unfriendly client can exhaust. The header of the newest
# suite comes from Debian's own source package there, through an apt configuration of its own that is
# derived from the mirrors of this machine; apt checks the archive's signature as always.
install_httplib() {
  local version
  if [ -r $httplib ]; then
    version=$(sed -n 's/^#define CPPHTTPLIB_VERSION "\(.*\)"/\1/p' $httplib)
    if dpkg --compare-versions "$version" ge $httplib_minimum; then return; fi
  fi
  scratch=$(mktemp -d)
  trap 'rm -rf "$scratch"' EXIT
  if [ "$(id -u)" -eq 0 ]; then chown _apt "$scratch"; fi  # the user apt downloads as
  mkdir -p "$scratch"/{sources,lists,cache}
  local codename mirror
  codename=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
  # shellcheck disable=SC2016  # apt fills these in
  for mirror in $(apt-get indextargets --format '$(RELEASE) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' |
    awk -v codename="$codename" '$1 == codename && $2 == "main" { print $3 }' | sort -u); do
    {
      echo 'Types: deb-src'
      echo "URIs: $mirror"
      echo 'Suites: sid'
      echo 'Components: main'
      echo 'Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg'
    } > "$scratch/sources/sid.sources"
    if unpack_httplib; then
      as_root install -D -m 644 "$scratch/httplib/httplib.h" $httplib
      return
    fi
  done
  echo 'setup.sh: found no mirror of Debian in the apt sources with the source package cpp-httplib' >&2
  return 1
}

unpack_httplib() (
  cd "$scratch"
  private_apt=(-qq -o Dir::State::Lists="$scratch/lists" -o Dir::Cache="$scratch/cache"
    -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$scratch/sources"
    -o APT::Default-Release= -o APT::Update::Post-Invoke-Success::= -o APT::Update::Post-Invoke::=)
  apt-get "${private_apt[@]}" update &&
    apt-get "${private_apt[@]}" source --download-only cpp-httplib &&
    dpkg-source --no-check -q --extract cpp-httplib_*.dsc httplib
)

# take_binary PACKAGE COMMAND: the one file out of a package that would start a service.
take_binary() {
  if command -v "$2" > /dev/null || [ -x "/usr/sbin/$2" ]; then return; fi
  local folder file
  folder=$(mktemp -d)
  if [ "$(id -u)" -eq 0 ]; then chown _apt "$folder"; fi
  (cd "$folder" && quietly apt-get -qq download "$1" && dpkg-deb -x "$1"_*.deb .)
  file=$(find "$folder/usr/bin" "$folder/usr/sbin" -name "$2" -type f 2> /dev/null | head -n 1)
  as_root install -D -m 755 "$file" "/usr/local/sbin/$2"
  rm -rf "$folder"
}

# The packages of a lock file. Nothing runs their install scripts: none of them needs one.
install_node_modules() {
  if [ ! -f "$1/package-lock.json" ]; then return; fi
  if cmp -s "$1/package-lock.json" "$1/node_modules/.installed-lock.json"; then return; fi
  echo "setup.sh: npm packages of $1"
  (cd "$1" && quietly npm ci --ignore-scripts --no-progress --loglevel=error)
  cp "$1/package-lock.json" "$1/node_modules/.installed-lock.json"
}

packages=("${build_packages[@]}")
if [ "${1:-}" != --build ]; then packages+=("${test_packages[@]}"); fi
if ! command -v npm > /dev/null; then packages+=(nodejs npm); fi
install_packages "${packages[@]}"
install_httplib
install_node_modules client
install_node_modules server/viewer
if [ "${1:-}" != --build ]; then
  take_binary nginx nginx
  take_binary prometheus promtool
  install_node_modules tests/e2e
fi
