#!/usr/bin/env bash
# Builds the image of Dockerfile without a registry or a daemon: Debian's own packages are the base.
#
#   deploy/container/build.sh [FILE]   an OCI archive, build/hoodoo-image.tar by default
#
# Needs root, and the packages mmdebstrap and buildah. BUILDAH_ARGS goes to buildah's build.
set -euo pipefail
cd "$(dirname "$0")/../.."

archive=${1:-build/hoodoo-image.tar}
base=build/debian-base.tar
buildah=(buildah --storage-driver vfs)
export BUILDAH_ISOLATION=chroot
mkdir -p build "$(dirname "$archive")"

if [ ! -f $base ]; then
  sources=(/etc/apt/sources.list /etc/apt/sources.list.d/*.sources)
  for file in "${sources[@]}"; do if [ -f "$file" ]; then found=$file; fi; done
  mmdebstrap --quiet --variant=apt bookworm $base.part "$found"
  mv $base.part $base
fi
if ! "${buildah[@]}" inspect --type image localhost/debian:12 > /dev/null 2>&1; then
  container=$("${buildah[@]}" from scratch)
  "${buildah[@]}" add --quiet "$container" $base / > /dev/null
  "${buildah[@]}" commit --quiet --rm "$container" localhost/debian:12 > /dev/null
fi
# shellcheck disable=SC2086  # words are wanted
"${buildah[@]}" build --layers ${BUILDAH_ARGS:-} --build-arg BASE=localhost/debian:12 \
  --ignorefile deploy/container/Dockerfile.dockerignore -f deploy/container/Dockerfile -t localhost/hoodoo .
rm -f "$archive"
"${buildah[@]}" push --quiet localhost/hoodoo "oci-archive:$archive:hoodoo"
du -h "$archive"
