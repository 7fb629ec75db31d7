# Sourced by demos/run, tests/run and .ci/run: installs missing Debian packages and configures the build.
# Idempotent: a second call finds everything in place and returns at once.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# What granular_demo is built and run with; tests/run adds the test harness.
demo_packages=(g++ cmake ninja-build pkg-config libeigen3-dev libtbb-dev libassimp-dev libbullet-dev libcli11-dev
               nlohmann-json3-dev libembree-dev libpng-dev libcairo2-dev ffmpeg)
test_packages=(libgtest-dev lammps)

# install_packages NAME...: those of the named Debian packages that are missing.
install_packages() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    if command -v cmake >/dev/null && command -v ninja >/dev/null; then
      echo "This is not Debian or Ubuntu: taking it that these are installed under their names here: $*" >&2
      return
    fi
    echo "This is not Debian or Ubuntu. Please install what these Debian packages hold, then run this again:" >&2
    echo "  $*" >&2
    exit 1
  fi
  local missing=() name
  for name in "$@"; do
    dpkg-query -W -f '${Status}' "$name" 2>/dev/null | grep -q 'install ok installed' || missing+=("$name")
  done
  [ ${#missing[@]} -eq 0 ] && return
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "These packages are missing, and there is neither root nor sudo to install them: ${missing[*]}" >&2
      exit 1
    fi
    as_root=(sudo)
  fi
  echo "Installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
}

# configure PRESET [CMAKE ARGUMENT...]: once; ninja sees to it later that changes are noticed.
configure() {
  local preset=$1
  shift
  if [ ! -f "$root/build/$preset/build.ninja" ] || [ $# -gt 0 ]; then
    (cd "$root" && cmake --preset "$preset" "$@" >"/tmp/granular-configure-$$.log" 2>&1) || {
      cat "/tmp/granular-configure-$$.log" >&2
      exit 1
    }
    rm -f "/tmp/granular-configure-$$.log"
  fi
}

# build PRESET [TARGET...]: quiet when there is nothing to do.
build() {
  local preset=$1
  shift
  cmake --build "$root/build/$preset" --target "${@:-all}" -- --quiet 2>/dev/null ||
    cmake --build "$root/build/$preset" --target "${@:-all}"
}
